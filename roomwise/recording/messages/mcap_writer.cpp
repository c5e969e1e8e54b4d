#include "roomwise/recording/messages/mcap_writer.h"

#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <concepts>
#include <cstring>
#include <span>

namespace roomwise::recording {
namespace {

constexpr std::string_view kFileMagic("\x89MCAP0\r\n", 8);
constexpr std::size_t kChunkBytes = std::size_t{1} << 20U;  // a chunk is closed when it has as many

// Records by the numbers that the specification gives them.
enum class Record : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kStatistics = 0x0B,
  kSummaryOffset = 0x0E,
  kDataEnd = 0x0F
};

template <std::unsigned_integral Number>
void add_number(Bytes& bytes, Number number) {
  for (std::size_t i = 0; i < sizeof(Number); ++i) {
    bytes.push_back(static_cast<std::uint8_t>(std::uint64_t{number} >> (8 * i)));
  }
}

void add_bytes(Bytes& bytes, std::span<const std::uint8_t> more) {
  bytes.insert(bytes.end(), more.begin(), more.end());
}

void add_text(Bytes& bytes, std::string_view text) {
  add_number(bytes, static_cast<std::uint32_t>(text.size()));
  bytes.insert(bytes.end(), text.begin(), text.end());
}

// Maps and arrays: their length in bytes, then their content.
void add_list(Bytes& bytes, const Bytes& content) {
  add_number(bytes, static_cast<std::uint32_t>(content.size()));
  add_bytes(bytes, content);
}

void add_record(Bytes& bytes, Record kind, const Bytes& content) {
  bytes.push_back(static_cast<std::uint8_t>(kind));
  add_number(bytes, std::uint64_t{content.size()});
  add_bytes(bytes, content);
}

std::uint32_t crc_of(std::span<const std::uint8_t> bytes, std::uint32_t before = 0) {
  return static_cast<std::uint32_t>(crc32_z(before, bytes.data(), bytes.size()));
}

}  // namespace

McapFileWriter::McapFileWriter(std::filesystem::path path, std::filesystem::path partial,
                               std::FILE* file)
    : path_(std::move(path)),
      partial_(std::make_unique<const std::filesystem::path>(std::move(partial))),
      file_(file) {}

McapFileWriter::McapFileWriter(McapFileWriter&& other) noexcept = default;

McapFileWriter::~McapFileWriter() {
  if (partial_) ::unlink(partial_->c_str());
}

Expected<McapFileWriter> McapFileWriter::create(const std::filesystem::path& path) {
  std::error_code ignored;
  if (std::filesystem::exists(std::filesystem::symlink_status(path, ignored))) {
    return fail("{}: is there and is not overwritten; choose another name", path.string());
  }
  std::filesystem::path partial = path;
  partial += fmt::format(".partial-{}", ::getpid());
  std::FILE* const file = std::fopen(partial.c_str(), "wbe");
  if (file == nullptr) {
    return fail("{}: cannot be written: {}", path.string(), std::strerror(errno));
  }
  McapFileWriter writer(path, std::move(partial), file);
  Bytes head(kFileMagic.begin(), kFileMagic.end());
  Bytes header;
  add_text(header, "");
  add_text(header, "roomwise");
  add_record(head, Record::kHeader, header);
  ROOMWISE_RETURN_IF_ERROR(writer.append(head));
  return writer;
}

Expected<void> McapFileWriter::append(const Bytes& bytes) {
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size()) {
    return fail("{}: cannot be written: {}", path_.string(), std::strerror(errno));
  }
  data_crc_ = crc_of(bytes, data_crc_);
  size_ += bytes.size();
  return {};
}

std::uint16_t McapFileWriter::add_json_channel(const std::string& topic,
                                               const std::string& schema_name,
                                               const std::string& schema) {
  const auto [known, is_new] =
      schema_ids_.try_emplace(schema_name, static_cast<std::uint16_t>(schema_ids_.size() + 1));
  if (is_new) {
    Bytes record;
    add_number(record, known->second);
    add_text(record, schema_name);
    add_text(record, "jsonschema");
    add_text(record, schema);
    add_record(schemas_, Record::kSchema, record);
    add_record(chunk_, Record::kSchema, record);
  }
  const auto id = static_cast<std::uint16_t>(channels_.size());
  channels_.emplace_back();
  Bytes record;
  add_number(record, id);
  add_number(record, known->second);
  add_text(record, topic);
  add_text(record, "json");
  add_list(record, {});
  add_record(channels_records_, Record::kChannel, record);
  add_record(chunk_, Record::kChannel, record);
  return id;
}

Expected<void> McapFileWriter::write(std::uint16_t channel, TimestampNs time_ns,
                                     std::string_view message) {
  if (time_ns < 0) {
    return fail("{}: a time of {} s is before 0, which MCAP cannot say", path_.string(),
                format_timestamp(time_ns));
  }
  const auto time = static_cast<std::uint64_t>(time_ns);
  WrittenChannel& written = channels_.at(channel);
  const bool is_first = std::ranges::all_of(
      channels_, [](const WrittenChannel& one) { return one.in_chunk.empty(); });
  chunk_first_ns_ = is_first ? time : std::min(chunk_first_ns_, time);
  chunk_last_ns_ = is_first ? time : std::max(chunk_last_ns_, time);
  first_ns_ = message_count_ == 0 ? time : std::min(first_ns_, time);
  last_ns_ = std::max(last_ns_, time);
  written.in_chunk.emplace_back(time, chunk_.size());

  chunk_.push_back(static_cast<std::uint8_t>(Record::kMessage));
  add_number(chunk_, std::uint64_t{2 + 4 + 8 + 8 + message.size()});
  add_number(chunk_, channel);
  add_number(chunk_, static_cast<std::uint32_t>(written.messages));
  add_number(chunk_, time);  // logged
  add_number(chunk_, time);  // published
  chunk_.insert(chunk_.end(), message.begin(), message.end());
  ++written.messages;
  ++message_count_;
  return chunk_.size() < kChunkBytes ? Expected<void>{} : close_chunk();
}

Expected<void> McapFileWriter::close_chunk() {
  if (chunk_.empty()) return {};
  WrittenChunk& chunk = chunks_.emplace_back();
  chunk.first_ns = chunk_first_ns_;
  chunk.last_ns = chunk_last_ns_;
  chunk.offset = size_;
  chunk.records_size = chunk_.size();
  Bytes content;
  add_number(content, chunk.first_ns);
  add_number(content, chunk.last_ns);
  add_number(content, chunk.records_size);
  add_number(content, crc_of(chunk_));
  add_text(content, "");  // not compressed
  add_number(content, chunk.records_size);
  add_bytes(content, chunk_);
  Bytes bytes;
  add_record(bytes, Record::kChunk, content);
  chunk.length = bytes.size();
  for (std::size_t id = 0; id < channels_.size(); ++id) {
    WrittenChannel& channel = channels_[id];
    if (channel.in_chunk.empty()) continue;
    Bytes places;
    for (const auto& [time, offset] : channel.in_chunk) {
      add_number(places, time);
      add_number(places, offset);
    }
    channel.in_chunk.clear();
    Bytes index;
    add_number(index, static_cast<std::uint16_t>(id));
    add_list(index, places);
    chunk.index_offsets[static_cast<std::uint16_t>(id)] = size_ + bytes.size();
    add_record(bytes, Record::kMessageIndex, index);
  }
  chunk.index_length = bytes.size() - chunk.length;
  chunk_.clear();
  chunk_first_ns_ = chunk_last_ns_ = 0;
  return append(bytes);
}

// The summary with the offsets to its parts, without the footer's CRC-32.
Bytes McapFileWriter::summary() const {
  Bytes bytes, offsets;
  const auto add_part = [&](Record kind, const Bytes& records) {
    if (records.empty()) return;
    Bytes offset;
    offset.push_back(static_cast<std::uint8_t>(kind));
    add_number(offset, size_ + bytes.size());
    add_number(offset, std::uint64_t{records.size()});
    add_record(offsets, Record::kSummaryOffset, offset);
    add_bytes(bytes, records);
  };
  add_part(Record::kSchema, schemas_);
  add_part(Record::kChannel, channels_records_);

  Bytes counts;
  for (std::size_t id = 0; id < channels_.size(); ++id) {
    add_number(counts, static_cast<std::uint16_t>(id));
    add_number(counts, channels_[id].messages);
  }
  Bytes content, statistics;
  add_number(content, message_count_);
  add_number(content, static_cast<std::uint16_t>(schema_ids_.size()));
  add_number(content, static_cast<std::uint32_t>(channels_.size()));
  add_number(content, std::uint32_t{0});  // attachments
  add_number(content, std::uint32_t{0});  // metadata
  add_number(content, static_cast<std::uint32_t>(chunks_.size()));
  add_number(content, first_ns_);
  add_number(content, last_ns_);
  add_list(content, counts);
  add_record(statistics, Record::kStatistics, content);
  add_part(Record::kStatistics, statistics);

  Bytes indices;
  for (const WrittenChunk& chunk : chunks_) {
    Bytes map, index;
    for (const auto& [channel, offset] : chunk.index_offsets) {
      add_number(map, channel);
      add_number(map, offset);
    }
    add_number(index, chunk.first_ns);
    add_number(index, chunk.last_ns);
    add_number(index, chunk.offset);
    add_number(index, chunk.length);
    add_list(index, map);
    add_number(index, chunk.index_length);
    add_text(index, "");
    add_number(index, chunk.records_size);
    add_number(index, chunk.records_size);
    add_record(indices, Record::kChunkIndex, index);
  }
  add_part(Record::kChunkIndex, indices);

  const std::uint64_t offsets_start = size_ + bytes.size();
  add_bytes(bytes, offsets);
  bytes.push_back(static_cast<std::uint8_t>(Record::kFooter));
  add_number(bytes, std::uint64_t{20});
  add_number(bytes, size_);
  add_number(bytes, offsets_start);
  return bytes;
}

Expected<void> McapFileWriter::finish() {
  ROOMWISE_RETURN_IF_ERROR(close_chunk());
  Bytes end, crc;
  add_number(crc, data_crc_);
  add_record(end, Record::kDataEnd, crc);
  ROOMWISE_RETURN_IF_ERROR(append(end));
  Bytes rest = summary();
  add_number(rest, crc_of(rest));
  rest.insert(rest.end(), kFileMagic.begin(), kFileMagic.end());
  ROOMWISE_RETURN_IF_ERROR(append(rest));
  const auto failed = [&](const char* what) {
    return fail("{}: {}: {}", path_.string(), what, std::strerror(errno));
  };
  if (std::fflush(file_.get()) != 0 || ::fsync(::fileno(file_.get())) != 0) {
    return failed("cannot be flushed to the disk");
  }
  if (std::fclose(file_.release()) != 0) return failed("cannot be closed");
  if (::rename(partial_->c_str(), path_.c_str()) != 0) return failed("cannot be put in place");
  partial_.reset();
  return {};
}

}  // namespace roomwise::recording
