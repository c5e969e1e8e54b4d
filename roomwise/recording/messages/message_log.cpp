#include "roomwise/recording/messages/message_log.h"

#include <zlib.h>

#include <algorithm>

#include "roomwise/base/in_context.h"

namespace roomwise::recording {
namespace {

// Of one thread that reads colour and depth; more for each thread beside it.
constexpr std::size_t kMaxKeptChunks = 8;
constexpr std::size_t kMaxKeptBytes = std::size_t{1} << 27;

std::string chunk_name(const RandomAccessFile& file, const Chunk& chunk) {
  return fmt::format("{}: the chunk at byte {}", file.path().string(), chunk.offset);
}

}  // namespace

Expected<Bytes> unpack_chunk(const RandomAccessFile& file, const Chunk& chunk) {
  const std::string name = chunk_name(file, chunk);
  if (chunk.size > kMaxChunkBytes) {
    return fail("{} claims {} bytes, more than any writer makes; the file is damaged", name,
                chunk.size);
  }
  ROOMWISE_TRY(const Bytes packed, file.read(chunk.offset, chunk.packed_size));
  ROOMWISE_TRY(auto bytes, in_context(name, unpack(chunk.packing, packed, chunk.size)));
  const auto crc = crc32_z(0, bytes.data(), bytes.size());
  if (chunk.crc32 != 0 && crc != chunk.crc32) {
    return fail("{} is damaged: its CRC-32 is {:08x}, not {:08x}; copy the file again", name, crc,
                chunk.crc32);
  }
  return bytes;
}

MessageLog::MessageLog(RandomAccessFile file, LogContents contents)
    : file_(std::move(file)), contents_(std::move(contents)), messages_of_(channels().size()) {
  for (const MessagePlace& message : contents_.messages) {
    messages_of_[message.channel].push_back(message);
  }
  contents_.messages = {};
  for (auto& messages : messages_of_) {
    std::ranges::stable_sort(messages, {}, &MessagePlace::timestamp_ns);
  }
}

Expected<Bytes> MessageLog::read(const MessagePlace& message) const {
  if (message.chunk == kNoChunk) return file_.read(message.offset, message.size);
  const Chunk& chunk = contents_.chunks[message.chunk];
  if (chunk.packing == Packing::kNone) {
    return file_.read(chunk.offset + message.offset, message.size);
  }
  ROOMWISE_TRY(const SharedBytes bytes, unpacked(message.chunk));
  const auto begin = bytes->begin() + static_cast<std::ptrdiff_t>(message.offset);
  return Bytes(begin, begin + static_cast<std::ptrdiff_t>(message.size));
}

Expected<MessageLog::SharedBytes> MessageLog::unpacked(std::uint32_t chunk) const {
  if (SharedBytes kept = find_unpacked(chunk)) return kept;
  ROOMWISE_TRY(Bytes bytes, unpack_chunk(file_, contents_.chunks[chunk]));
  auto shared = std::make_shared<const Bytes>(std::move(bytes));
  keep_unpacked(chunk, shared);
  return shared;
}

MessageLog::SharedBytes MessageLog::find_unpacked(std::uint32_t chunk) const {
  const std::lock_guard lock(mutex_);
  const auto kept =
      std::ranges::find(unpacked_, chunk, &std::pair<std::uint32_t, SharedBytes>::first);
  return kept == unpacked_.end() ? nullptr : kept->second;
}

void MessageLog::keep_unpacked(std::uint32_t chunk, SharedBytes bytes) const {
  const std::lock_guard lock(mutex_);
  unpacked_.emplace_front(chunk, std::move(bytes));
  std::size_t total = 0, count = 0;
  for (const auto& [number, kept] : unpacked_) {
    total += kept->size();
    if (++count > kMaxKeptChunks || (count > 2 && total > kMaxKeptBytes)) break;
  }
  unpacked_.resize(count > kMaxKeptChunks || (count > 2 && total > kMaxKeptBytes) ? count - 1
                                                                                  : count);
}

}  // namespace roomwise::recording
