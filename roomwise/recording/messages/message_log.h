#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "roomwise/base/timestamp.h"
#include "roomwise/recording/bytes/random_access_file.h"
#include "roomwise/recording/bytes/unpack.h"
#include "roomwise/recording/messages/channel.h"

namespace roomwise::recording {

// A message as it lies in the file.
struct MessagePlace {
  std::uint32_t channel = 0;     // in MessageLog::channels
  TimestampNs logged_ns = 0;     // when it was recorded
  TimestampNs timestamp_ns = 0;  // of its header; logged_ns where it has none
  std::uint32_t chunk = 0;       // in the log's chunks; kNoChunk: outside of all
  std::uint64_t offset = 0;      // of its data, in the file or in the unpacked chunk
  std::uint64_t size = 0;
};
constexpr std::uint32_t kNoChunk = UINT32_MAX;

// Messages of many channels that are stored together, packed or not.
struct Chunk {
  std::uint64_t offset = 0;  // of the packed bytes in the file
  std::uint64_t packed_size = 0, size = 0;
  Packing packing = Packing::kNone;
  std::uint32_t crc32 = 0;  // of the unpacked bytes; 0: unknown
};

// More is refused before memory is taken; writers begin a new chunk after some MB.
constexpr std::uint64_t kMaxChunkBytes = std::uint64_t{1} << 29;
// Of the channels that are read. A file that claims more is damaged or no recording of a home.
constexpr std::size_t kMaxMessages = 20'000'000;

// What a file of recorded messages holds, of the channels that are understood.
struct LogContents {
  std::vector<Channel> channels;
  std::vector<Chunk> chunks;
  std::vector<MessagePlace> messages;  // in the order of the file
  // For people: what was found wrong and passed over, such as an end that was cut off.
  std::vector<std::string> notes;
};

// A file of recorded messages (MCAP, ROS 1 bag) and where each of them lies. Errors name the file
// and where in it. Reading is thread-safe.
class MessageLog {
 public:
  MessageLog(RandomAccessFile file, LogContents contents);
  MessageLog(MessageLog&& other) noexcept
      : file_(std::move(other.file_)),
        contents_(std::move(other.contents_)),
        messages_of_(std::move(other.messages_of_)) {}
  MessageLog& operator=(MessageLog&&) = delete;
  ~MessageLog() = default;

  [[nodiscard]] const std::filesystem::path& path() const { return file_.path(); }
  [[nodiscard]] const std::vector<Channel>& channels() const { return contents_.channels; }
  [[nodiscard]] const std::vector<std::string>& notes() const { return contents_.notes; }
  // The messages of a channel in the order of their time stamps.
  [[nodiscard]] const std::vector<MessagePlace>& messages(std::size_t channel) const {
    return messages_of_[channel];
  }
  [[nodiscard]] Expected<Bytes> read(const MessagePlace& message) const;

 private:
  using SharedBytes = std::shared_ptr<const Bytes>;
  [[nodiscard]] Expected<SharedBytes> unpacked(std::uint32_t chunk) const;
  [[nodiscard]] SharedBytes find_unpacked(std::uint32_t chunk) const;
  void keep_unpacked(std::uint32_t chunk, SharedBytes bytes) const;

  RandomAccessFile file_;
  LogContents contents_;
  std::vector<std::vector<MessagePlace>> messages_of_;
  // The chunks that were unpacked last: neighbours in time lie in one or two.
  mutable std::mutex mutex_;
  mutable std::deque<std::pair<std::uint32_t, SharedBytes>> unpacked_;
};

// The unpacked bytes of a chunk, checked against its CRC-32. Errors name the file and the chunk.
[[nodiscard]] Expected<Bytes> unpack_chunk(const RandomAccessFile& file, const Chunk& chunk);

}  // namespace roomwise::recording
