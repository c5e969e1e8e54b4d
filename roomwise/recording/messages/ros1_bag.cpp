#include "roomwise/recording/messages/ros1_bag.h"

#include <algorithm>

#include "roomwise/base/byte_reader.h"
#include "roomwise/base/in_context.h"
#include "roomwise/recording/messages/log_builder.h"

namespace roomwise::recording {
namespace {

constexpr std::string_view kBagMagic = "#ROSBAG V2.0\n";
// Headers hold some numbers and a topic.
constexpr std::uint64_t kMaxBagHeader = std::uint64_t{1} << 20;
constexpr std::uint64_t kMaxConnectionData = std::uint64_t{1} << 24;  // with the type's definition

enum BagOpcode : std::uint8_t {
  kBagMessage = 0x02,
  kBagHeader = 0x03,
  kBagIndex = 0x04,
  kBagChunk = 0x05,
  kBagChunkInfo = 0x06,
  kBagConnection = 0x07
};

// The fields of a header: name=value, each with its length in front.
class BagFields {
 public:
  // False where they do not fit into the header.
  bool read(std::span<const std::uint8_t> header) {
    ByteReader reader(header);
    while (reader.remaining() > 0) {
      const std::string_view field = reader.counted_text<std::uint32_t>();
      const std::size_t equals = field.find('=');
      if (!reader.ok() || equals == std::string_view::npos) return false;
      fields_.emplace(field.substr(0, equals), field.substr(equals + 1));
    }
    return true;
  }
  template <typename Number>
  [[nodiscard]] std::optional<Number> number(const char* name) const {
    const auto found = fields_.find(name);
    if (found == fields_.end() || found->second.size() != sizeof(Number)) return std::nullopt;
    return load<Number>(reinterpret_cast<const std::uint8_t*>(found->second.data()));
  }
  [[nodiscard]] std::string text(const char* name) const {
    const auto found = fields_.find(name);
    return found == fields_.end() ? std::string() : found->second;
  }

 private:
  std::map<std::string, std::string, std::less<>> fields_;
};

struct BagRecord {
  std::uint8_t opcode = 0;
  BagFields fields;
  std::uint64_t begin = 0, size = 0;  // of the data
  [[nodiscard]] std::uint64_t end() const { return begin + size; }
};

// The record at `offset`. Nothing where the space ends within it.
Expected<std::optional<BagRecord>> bag_record_at(RecordSpace& space, std::uint64_t offset) {
  BagRecord record;
  const auto none = std::optional<BagRecord>();
  if (!space.holds(offset, 4)) return none;
  ROOMWISE_TRY(const auto length, space.at(offset, 4));
  const std::uint64_t header_size = load<std::uint32_t>(length.data());
  if (header_size > kMaxBagHeader) return fail("a header of {} bytes", header_size);
  if (!space.holds(offset + 4, header_size + 4)) return none;
  ROOMWISE_TRY(const auto header, space.at(offset + 4, header_size + 4));
  record.size = load<std::uint32_t>(header.data() + header_size);
  record.begin = offset + 8 + header_size;
  if (!record.fields.read(header.first(static_cast<std::size_t>(header_size)))) {
    return fail("a header that makes no sense");
  }
  record.opcode = record.fields.number<std::uint8_t>("op").value_or(0);
  if (!space.holds(record.begin, record.size)) return none;
  return record;
}

bool is_known_opcode(std::uint8_t opcode) {
  return opcode >= kBagMessage && opcode <= kBagConnection;
}

TimestampNs bag_time(std::uint64_t time) {
  return static_cast<std::int64_t>(time & 0xFFFFFFFFU) * 1'000'000'000 +
         static_cast<std::int64_t>(time >> 32U);
}

class BagScan {
 public:
  explicit BagScan(const RandomAccessFile& file)
      : file_(file), builder_(file), space_(file, 0, file.size()) {}

  Expected<LogContents> scan() {
    ROOMWISE_RETURN_IF_ERROR(read_connections_at_end());
    for (std::uint64_t offset = kBagMagic.size(); offset < space_.size();) {
      const auto record = bag_record_at(space_, offset);
      const bool is_known = record && *record && is_known_opcode((*record)->opcode);
      const bool is_cut_off = record && !*record;
      if (!is_known && was_closed_ && !is_cut_off) {
        return damaged(offset, record ? "an unknown record" : record.error().message);
      }
      if (!is_known) {
        builder_.note(fmt::format(
            "the file ends within a record, at byte {}; what comes before is read", offset));
        break;
      }
      ROOMWISE_RETURN_IF_ERROR(read_record(**record));
      offset = (*record)->end();
    }
    return std::move(builder_).take();
  }

 private:
  Unexpected damaged(std::uint64_t offset, std::string_view what) const {
    return fail("{}: {} at byte {}; the file is damaged; try 'rosbag reindex' on a copy",
                file_.path().string(), what, offset);
  }
  Expected<std::optional<BagRecord>> record_in_file(std::uint64_t offset) {
    auto record = bag_record_at(space_, offset);
    if (!record) return damaged(offset, record.error().message);
    return record;
  }

  // The connections, where the file was closed well: then a chunk's index tells whether any of its
  // messages is read before it is unpacked.
  Expected<void> read_connections_at_end() {
    ROOMWISE_TRY(const auto header, record_in_file(kBagMagic.size()));
    if (!header || header->opcode != kBagHeader) {
      return damaged(kBagMagic.size(), "no head of a bag");
    }
    if (!header->fields.text("encryptor").empty()) {
      return fail("{}: is encrypted; decrypt it by 'rosbag decrypt'", file_.path().string());
    }
    const auto index = header->fields.number<std::uint64_t>("index_pos").value_or(0);
    was_closed_ = index != 0;
    for (std::uint64_t offset = index; offset != 0 && offset < space_.size();) {
      const auto record = bag_record_at(space_, offset);
      if (!record || !*record || (*record)->opcode != kBagConnection) break;
      ROOMWISE_RETURN_IF_ERROR(read_connection(space_, **record));
      knows_connections_ = true;
      offset = (*record)->end();
    }
    return {};
  }

  Expected<void> read_record(const BagRecord& record) {
    switch (record.opcode) {
      case kBagHeader:
      case kBagIndex:
      case kBagChunkInfo:
        return {};
      case kBagConnection:
        return read_connection(space_, record);
      case kBagMessage:
        return read_message(space_, record, kNoChunk);
      case kBagChunk:
        return read_chunk(record);
      default:
        return damaged(record.begin, "an unknown record");
    }
  }

  Expected<void> read_chunk(const BagRecord& record) {
    ROOMWISE_TRY(const bool is_wanted, is_chunk_wanted(record));
    // A recorder that is killed leaves the head of its last chunk without sizes, and its messages
    // behind it.
    if (!is_wanted || record.size == 0) return {};
    Chunk chunk;
    chunk.offset = record.begin;
    chunk.packed_size = record.size;
    chunk.size = record.fields.number<std::uint32_t>("size").value_or(0);
    ROOMWISE_TRY(chunk.packing, in_context(fmt::format("{}: the chunk at byte {}",
                                                       file_.path().string(), record.begin),
                                           packing_named(record.fields.text("compression"))));
    const std::uint32_t number = builder_.add_chunk(chunk);
    if (chunk.packing == Packing::kNone) {
      RecordSpace records(file_, chunk.offset, chunk.packed_size);
      return read_messages_of(chunk, number, records);
    }
    ROOMWISE_TRY(const Bytes bytes, unpack_chunk(file_, chunk));
    RecordSpace records((std::span<const std::uint8_t>(bytes)));
    return read_messages_of(chunk, number, records);
  }

  // By the index records that follow it; where they are missing it is.
  Expected<bool> is_chunk_wanted(const BagRecord& chunk) {
    if (!knows_connections_) return true;
    bool has_index = false;
    for (std::uint64_t offset = chunk.end(); offset < space_.size();) {
      ROOMWISE_TRY(const auto record, record_in_file(offset));
      if (!record || record->opcode != kBagIndex) break;
      const auto number = record->fields.number<std::uint32_t>("conn");
      const Channel* channel = number ? builder_.channel(*number) : nullptr;
      if (channel == nullptr || channel->is_read()) return true;
      has_index = true;
      offset = record->end();
    }
    return !has_index;
  }

  Expected<void> read_messages_of(const Chunk& chunk, std::uint32_t number, RecordSpace& records) {
    for (std::uint64_t offset = 0; offset < records.size();) {
      auto record = bag_record_at(records, offset);
      if (!record || !*record) return damaged(chunk.offset, "damaged messages in the chunk");
      if ((*record)->opcode == kBagConnection) {
        ROOMWISE_RETURN_IF_ERROR(read_connection(records, **record));
      } else if ((*record)->opcode == kBagMessage) {
        ROOMWISE_RETURN_IF_ERROR(read_message(records, **record, number));
      }
      offset = (*record)->end();
    }
    return {};
  }

  Expected<void> read_connection(RecordSpace& space, const BagRecord& record) {
    const auto number = record.fields.number<std::uint32_t>("conn");
    if (!number || record.size > kMaxConnectionData) {
      return damaged(record.begin, "a damaged connection");
    }
    ROOMWISE_TRY(const auto data, space.at(record.begin, record.size));
    BagFields about;
    if (!about.read(data)) return damaged(record.begin, "a damaged connection");
    Channel channel;
    channel.topic = record.fields.text("topic");
    channel.type_name = about.text("type");
    channel.type = message_type_named(channel.type_name);
    return builder_.add_channel(*number, std::move(channel));
  }

  Expected<void> read_message(RecordSpace& space, const BagRecord& record, std::uint32_t chunk) {
    const auto number = record.fields.number<std::uint32_t>("conn");
    const auto time = record.fields.number<std::uint64_t>("time");
    if (!number || !time || builder_.channel(*number) == nullptr) {
      return damaged(record.begin, "a message of no connection");
    }
    return builder_.add_message(*number, chunk, bag_time(*time), space, record.begin, record.size);
  }

  const RandomAccessFile& file_;
  LogBuilder builder_;
  RecordSpace space_;
  bool was_closed_ = false;  // by its recorder, not by a crash
  bool knows_connections_ = false;
};

}  // namespace

bool is_ros1_bag(std::span<const std::uint8_t> first_bytes) {
  return first_bytes.size() >= kBagMagic.size() &&
         std::ranges::equal(first_bytes.first(kBagMagic.size()), kBagMagic);
}

Expected<MessageLog> read_ros1_bag(const std::filesystem::path& path) {
  ROOMWISE_TRY(RandomAccessFile file, RandomAccessFile::open(path));
  ROOMWISE_TRY(LogContents contents, BagScan(file).scan());
  return MessageLog(std::move(file), std::move(contents));
}

}  // namespace roomwise::recording
