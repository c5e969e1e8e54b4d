#include "roomwise/recording/messages/mcap_file.h"

#include <algorithm>
#include <set>

#include "roomwise/base/byte_reader.h"
#include "roomwise/base/in_context.h"
#include "roomwise/recording/messages/log_builder.h"

namespace roomwise::recording {
namespace {

using RecordBytes = std::span<const std::uint8_t>;

constexpr std::array<std::uint8_t, 8> kMcapMagic{0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};
constexpr std::uint64_t kMcapRecordHead = 9;  // opcode and length
constexpr std::uint64_t kFooterBytes = 20;
constexpr std::uint64_t kMessageHead = 22;
// So that any two times, a negative one among them, have a difference.
constexpr std::uint64_t kMaxTime = std::uint64_t{1} << 62;
// Schemas and channels hold texts; what claims more is damaged.
constexpr std::uint64_t kMaxTextRecord = std::uint64_t{1} << 26;
// Of a chunk's fields in front of its records; the compression's name is short.
constexpr std::uint64_t kMaxChunkHead = 128;

enum McapOpcode : std::uint8_t {
  kFooterRecord = 0x02,
  kSchemaRecord = 0x03,
  kChannelRecord = 0x04,
  kMessageRecord = 0x05,
  kChunkRecord = 0x06,
  kChunkIndexRecord = 0x08,
  kDataEndRecord = 0x0F
};

struct McapRecord {
  std::uint8_t opcode = 0;
  std::uint64_t begin = 0;  // of the content
  std::uint64_t size = 0;   // of the content
  [[nodiscard]] std::uint64_t end() const { return begin + size; }
};

// The record at `offset`; nothing where the space ends within it.
Expected<std::optional<McapRecord>> record_at(RecordSpace& space, std::uint64_t offset) {
  if (!space.holds(offset, kMcapRecordHead)) return std::optional<McapRecord>();
  ROOMWISE_TRY(const auto head, space.at(offset, kMcapRecordHead));
  const McapRecord record{head[0], offset + kMcapRecordHead, load<std::uint64_t>(&head[1])};
  if (!space.holds(record.begin, record.size)) return std::optional<McapRecord>();
  return record;
}

Expected<Encoding> encoding_named(std::string_view name) {
  if (name == "ros1") return Encoding::kRos1;
  if (name == "cdr") return Encoding::kCdr;
  if (name == "protobuf") return Encoding::kProtobuf;
  if (name == "json") return Encoding::kJson;
  return fail("unknown");
}

// What the index at the end knows of a chunk.
struct IndexedChunk {
  std::uint64_t offset = 0;  // of its record
  std::set<std::uint16_t> channels;
};

class McapScan {
 public:
  explicit McapScan(const RandomAccessFile& file)
      : file_(file), builder_(file), space_(file, 0, file.size()) {}

  Expected<LogContents> scan() {
    if (!space_.holds(0, kMcapMagic.size())) return fail("{}: is empty", file_.path().string());
    ROOMWISE_TRY(const auto index, read_index());
    if (index) {
      ROOMWISE_RETURN_IF_ERROR(read_indexed(*index));
    } else {
      ROOMWISE_RETURN_IF_ERROR(read_on());
    }
    return std::move(builder_).take();
  }

 private:
  using Index = std::vector<IndexedChunk>;

  Unexpected damaged(std::uint64_t offset, std::string_view what) const {
    return fail("{}: {} at byte {} is damaged; try 'mcap recover' on a copy", file_.path().string(),
                what, offset);
  }

  // Where the summary begins; nothing where the file does not end as a whole one does.
  Expected<std::optional<std::uint64_t>> find_summary() {
    constexpr std::uint64_t kEnd = kMcapRecordHead + kFooterBytes + kMcapMagic.size();
    if (space_.size() < kMcapMagic.size() + kEnd) return std::optional<std::uint64_t>();
    const std::uint64_t begin = space_.size() - kEnd;
    ROOMWISE_TRY(const auto end, space_.at(begin, kEnd));
    const bool is_whole = std::ranges::equal(end.last(kMcapMagic.size()), kMcapMagic) &&
                          end[0] == kFooterRecord && load<std::uint64_t>(&end[1]) == kFooterBytes;
    const auto summary = load<std::uint64_t>(&end[kMcapRecordHead]);
    if (!is_whole || summary == 0 || summary >= begin) return std::optional<std::uint64_t>();
    return summary;
  }

  // The chunks, with the channels and schemas; nothing where there is no usable index.
  Expected<std::optional<Index>> read_index() {
    ROOMWISE_TRY(const auto summary, find_summary());
    if (!summary) return std::optional<Index>();
    Index index;
    for (std::uint64_t offset = *summary;;) {
      ROOMWISE_TRY(const auto record, record_at(space_, offset));
      if (!record) return std::optional<Index>();
      if (record->opcode == kFooterRecord) break;
      if (record->opcode == kChunkIndexRecord) {
        ROOMWISE_TRY(IndexedChunk chunk, read_chunk_index(*record));
        index.push_back(std::move(chunk));
      }
      ROOMWISE_RETURN_IF_ERROR(read_description(space_, *record));
      offset = record->end();
    }
    // Without chunks the messages lie between other records, which no index knows.
    if (index.empty()) return std::optional<Index>();
    std::ranges::sort(index, {}, &IndexedChunk::offset);
    return index;
  }

  Expected<IndexedChunk> read_chunk_index(const McapRecord& record) {
    if (record.size > kMaxTextRecord) return damaged(record.begin, "a chunk's index");
    ROOMWISE_TRY(const auto bytes, space_.at(record.begin, record.size));
    ByteReader reader(bytes);
    reader.bytes(16);  // first and last time
    IndexedChunk chunk;
    chunk.offset = reader.number<std::uint64_t>();
    reader.bytes(8);  // the record's size
    ByteReader channels(reader.counted_bytes<std::uint32_t>());
    if (!reader.ok()) return damaged(record.begin, "a chunk's index");
    while (channels.remaining() >= 10) {
      chunk.channels.insert(channels.number<std::uint16_t>());
      channels.bytes(8);
    }
    return chunk;
  }

  [[nodiscard]] bool is_wanted(const IndexedChunk& chunk) const {
    const auto is_read = [this](std::uint16_t number) {
      return builder_.channel(number)->is_read();
    };
    return chunk.channels.empty() || std::ranges::any_of(chunk.channels, is_read);
  }

  // Some writers describe the channels in chunks alone, perhaps in one that has none of their
  // messages.
  [[nodiscard]] bool knows_all_channels(const Index& index) const {
    const auto is_known = [this](std::uint16_t number) {
      return builder_.channel(number) != nullptr;
    };
    return std::ranges::all_of(index, [&](const IndexedChunk& chunk) {
      return std::ranges::all_of(chunk.channels, is_known);
    });
  }

  Expected<void> read_indexed(const Index& index) {
    const bool may_pass_over = knows_all_channels(index);
    for (const IndexedChunk& chunk : index) {
      if (may_pass_over && !is_wanted(chunk)) continue;
      ROOMWISE_TRY(const auto record, record_at(space_, chunk.offset));
      if (!record || record->opcode != kChunkRecord) return damaged(chunk.offset, "the chunk");
      ROOMWISE_RETURN_IF_ERROR(read_chunk(*record));
    }
    return {};
  }

  // One record after the other, up to the end of the data or of the file.
  Expected<void> read_on() {
    std::uint64_t offset = kMcapMagic.size();
    for (;;) {
      ROOMWISE_TRY(const auto record, record_at(space_, offset));
      if (!record) {
        note_cut_off(offset);
        return {};
      }
      if (record->opcode == kDataEndRecord || record->opcode == kFooterRecord) return {};
      if (record->opcode == 0) return damaged(offset, "the record");
      if (record->opcode == kChunkRecord) ROOMWISE_RETURN_IF_ERROR(read_chunk(*record));
      ROOMWISE_RETURN_IF_ERROR(read_content(space_, *record, kNoChunk));
      offset = record->end();
    }
  }

  void note_cut_off(std::uint64_t offset) {
    builder_.note(fmt::format(
        "the file ends within a record, at byte {}; what comes before is read", offset));
  }

  Expected<void> read_chunk(const McapRecord& record) {
    ROOMWISE_TRY(const auto head, space_.at(record.begin, std::min(record.size, kMaxChunkHead)));
    ByteReader reader(head);
    reader.bytes(16);  // first and last time
    Chunk chunk;
    chunk.size = reader.number<std::uint64_t>();
    chunk.crc32 = reader.number<std::uint32_t>();
    const std::string packing(reader.counted_text<std::uint32_t>());
    chunk.packed_size = reader.number<std::uint64_t>();
    chunk.offset = record.begin + reader.position();
    if (!reader.ok() || chunk.packed_size > record.size - reader.position()) {
      return damaged(record.begin, "the chunk");
    }
    ROOMWISE_TRY(chunk.packing, in_context(fmt::format("{}: the chunk at byte {}",
                                                       file_.path().string(), record.begin),
                                           packing_named(packing)));
    return read_messages_of(chunk);
  }

  Expected<void> read_messages_of(const Chunk& chunk) {
    ROOMWISE_TRY(const Bytes bytes, unpack_chunk(file_, chunk));
    const std::uint32_t number = builder_.add_chunk(chunk);
    RecordSpace records((std::span<const std::uint8_t>(bytes)));
    for (std::uint64_t offset = 0; offset < records.size();) {
      ROOMWISE_TRY(const auto record, record_at(records, offset));
      if (!record) return damaged(chunk.offset, "what is in the chunk");
      ROOMWISE_RETURN_IF_ERROR(read_content(records, *record, number));
      offset = record->end();
    }
    return {};
  }

  Expected<void> read_content(RecordSpace& space, const McapRecord& record, std::uint32_t chunk) {
    if (record.opcode == kMessageRecord) return read_message(space, record, chunk);
    return read_description(space, record);
  }

  Expected<void> read_message(RecordSpace& space, const McapRecord& record, std::uint32_t chunk) {
    if (record.size < kMessageHead) return damaged(record.begin, "the message");
    ROOMWISE_TRY(const auto head, space.at(record.begin, kMessageHead));
    ByteReader reader(head);
    const auto channel = reader.number<std::uint16_t>();
    reader.number<std::uint32_t>();  // a count
    const auto logged =
        static_cast<TimestampNs>(std::min(reader.number<std::uint64_t>(), kMaxTime));
    if (builder_.channel(channel) == nullptr) {
      return damaged(record.begin, fmt::format("the message of the unknown channel {}", channel));
    }
    return builder_.add_message(channel, chunk, logged, space, record.begin + kMessageHead,
                                record.size - kMessageHead);
  }

  // Schemas and channels.
  Expected<void> read_description(RecordSpace& space, const McapRecord& record) {
    if (record.opcode != kSchemaRecord && record.opcode != kChannelRecord) return {};
    if (record.size > kMaxTextRecord) return damaged(record.begin, "a description");
    ROOMWISE_TRY(const auto bytes, space.at(record.begin, record.size));
    const bool ok = record.opcode == kSchemaRecord ? read_schema(bytes) : true;
    if (!ok) return damaged(record.begin, "a schema");
    if (record.opcode == kChannelRecord) return read_channel(bytes, record.begin);
    return {};
  }

  bool read_schema(RecordBytes bytes) {
    ByteReader reader(bytes);
    const auto number = reader.number<std::uint16_t>();
    const auto name = reader.counted_text<std::uint32_t>();
    if (reader.ok()) schemas_[number] = name;
    return reader.ok();
  }

  Expected<void> read_channel(RecordBytes bytes, std::uint64_t offset) {
    ByteReader reader(bytes);
    const auto number = reader.number<std::uint16_t>();
    const auto schema = reader.number<std::uint16_t>();
    Channel channel;
    channel.topic = reader.counted_text<std::uint32_t>();
    const auto encoding = encoding_named(reader.counted_text<std::uint32_t>());
    if (!reader.ok()) return damaged(offset, "a channel");
    if (const auto found = schemas_.find(schema); found != schemas_.end()) {
      channel.type_name = found->second;
    }
    channel.encoding = encoding.value_or(Encoding::kRos1);
    channel.type = encoding ? message_type_named(channel.type_name) : MessageType::kOther;
    return builder_.add_channel(number, std::move(channel));
  }

  const RandomAccessFile& file_;
  LogBuilder builder_;
  RecordSpace space_;
  std::map<std::uint16_t, std::string> schemas_;
};

}  // namespace

bool is_mcap(RecordBytes first_bytes) {
  return first_bytes.size() >= kMcapMagic.size() &&
         std::ranges::equal(first_bytes.first(kMcapMagic.size()), kMcapMagic);
}

Expected<MessageLog> read_mcap(const std::filesystem::path& path) {
  ROOMWISE_TRY(RandomAccessFile file, RandomAccessFile::open(path));
  ROOMWISE_TRY(LogContents contents, McapScan(file).scan());
  return MessageLog(std::move(file), std::move(contents));
}

}  // namespace roomwise::recording
