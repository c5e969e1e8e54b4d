#pragma once

#include <bzlib.h>
#include <lz4frame.h>
#include <zlib.h>
#include <zstd.h>

#include <map>
#include <vector>

#include "roomwise/base/timestamp.h"
#include "roomwise/recording/messages/channel.h"
#include "roomwise/recording/messages/testing/byte_writer.h"

// Small files of messages, for tests.
namespace roomwise::recording::testing {

inline Bytes pack_bytes(const std::string& packing, const Bytes& plain) {
  Bytes packed(2 * plain.size() + 1024);
  if (packing == "lz4") {
    packed.resize(
        LZ4F_compressFrame(packed.data(), packed.size(), plain.data(), plain.size(), nullptr));
  } else if (packing == "zstd") {
    packed.resize(ZSTD_compress(packed.data(), packed.size(), plain.data(), plain.size(), 1));
  } else if (packing == "bz2") {
    auto size = static_cast<unsigned>(packed.size());
    Bytes copy = plain;
    BZ2_bzBuffToBuffCompress(reinterpret_cast<char*>(packed.data()), &size,
                             reinterpret_cast<char*>(copy.data()),
                             static_cast<unsigned>(copy.size()), 1, 0, 0);
    packed.resize(size);
  } else {
    return plain;
  }
  return packed;
}

struct WrittenMessage {
  std::size_t channel = 0;
  TimestampNs time_ns = 0;
  Bytes data;
};

struct LogPlan {
  std::vector<Channel> channels;
  std::vector<std::vector<WrittenMessage>> chunks;
  std::string packing;  // "", "lz4", "zstd", "bz2"
  bool has_index = true;
  bool has_sums = true;             // MCAP: a CRC-32 of each chunk
  bool has_channels_at_end = true;  // MCAP
  bool has_chunks = true;           // MCAP: else messages lie between the other records
};

inline const char* encoding_name(Encoding encoding) {
  switch (encoding) {
    case Encoding::kRos1:
      return "ros1";
    case Encoding::kCdr:
      return "cdr";
    case Encoding::kProtobuf:
      return "protobuf";
    case Encoding::kJson:
      return "json";
  }
  return "";
}

class McapWriter {
 public:
  static Bytes write(const LogPlan& plan) {
    McapWriter writer(plan);
    return std::move(writer.out_.all());
  }

 private:
  explicit McapWriter(const LogPlan& plan) : plan_(plan) {
    magic();
    record(out_, 0x01, ByteWriter().counted<std::uint32_t>("").counted<std::uint32_t>("test"));
    if (!plan.has_chunks) {
      describe(out_);
      for (const auto& messages : plan.chunks) put_messages(out_, messages);
    } else {
      for (const auto& messages : plan.chunks) put_chunk(messages);
    }
    record(out_, 0x0F, ByteWriter().number<std::uint32_t>(0));
    const std::uint64_t summary = plan.has_index ? out_.size() : 0;
    if (plan.has_index) put_summary();
    record(
        out_, 0x02,
        ByteWriter().number<std::uint64_t>(summary).number<std::uint64_t>(0).number<std::uint32_t>(
            0));
    magic();
  }

  static void record(ByteWriter& out, std::uint8_t opcode, const ByteWriter& content) {
    out.number<std::uint8_t>(opcode).number<std::uint64_t>(content.size()).bytes(content.all());
  }
  void magic() { out_.text(std::string_view("\x89MCAP0\r\n", 8)); }

  void describe(ByteWriter& out) const {
    for (std::size_t i = 0; i < plan_.channels.size(); ++i) {
      const auto number = static_cast<std::uint16_t>(i + 1);
      const Channel& channel = plan_.channels[i];
      record(out, 0x03,
             ByteWriter()
                 .number<std::uint16_t>(number)
                 .counted<std::uint32_t>(channel.type_name)
                 .counted<std::uint32_t>("")
                 .counted<std::uint32_t>(""));
      record(out, 0x04,
             ByteWriter()
                 .number<std::uint16_t>(number)
                 .number<std::uint16_t>(number)
                 .counted<std::uint32_t>(channel.topic)
                 .counted<std::uint32_t>(encoding_name(channel.encoding))
                 .counted<std::uint32_t>(""));
    }
  }
  static void put_messages(ByteWriter& out, const std::vector<WrittenMessage>& messages) {
    for (const WrittenMessage& message : messages) {
      const auto time = static_cast<std::uint64_t>(message.time_ns);
      record(out, 0x05,
             ByteWriter()
                 .number<std::uint16_t>(static_cast<std::uint16_t>(message.channel + 1))
                 .number<std::uint32_t>(0)
                 .number<std::uint64_t>(time)
                 .number<std::uint64_t>(time)
                 .bytes(message.data));
    }
  }
  void put_chunk(const std::vector<WrittenMessage>& messages) {
    ByteWriter records;
    if (index_.empty()) describe(records);
    put_messages(records, messages);
    index_.emplace_back(out_.size(), &messages);
    const Bytes packed = pack_bytes(plan_.packing, records.all());
    const auto crc = plan_.has_sums ? crc32_z(0, records.all().data(), records.size()) : 0;
    record(out_, 0x06,
           ByteWriter()
               .number<std::uint64_t>(0)
               .number<std::uint64_t>(0)
               .number<std::uint64_t>(records.size())
               .number<std::uint32_t>(static_cast<std::uint32_t>(crc))
               .counted<std::uint32_t>(plan_.packing)
               .counted<std::uint64_t>(packed));
  }
  void put_summary() {
    if (plan_.has_channels_at_end) describe(out_);
    for (const auto& [offset, messages] : index_) {
      ByteWriter channels;
      std::map<std::size_t, int> seen;
      for (const WrittenMessage& message : *messages) {
        if (seen[message.channel]++ > 0) continue;
        channels.number<std::uint16_t>(static_cast<std::uint16_t>(message.channel + 1));
        channels.number<std::uint64_t>(0);
      }
      record(out_, 0x08,
             ByteWriter()
                 .number<std::uint64_t>(0)
                 .number<std::uint64_t>(0)
                 .number<std::uint64_t>(offset)
                 .number<std::uint64_t>(0)
                 .counted<std::uint32_t>(channels.all())
                 .number<std::uint64_t>(0)
                 .counted<std::uint32_t>(plan_.packing)
                 .number<std::uint64_t>(0)
                 .number<std::uint64_t>(0));
    }
  }

  const LogPlan& plan_;
  ByteWriter out_;
  std::vector<std::pair<std::uint64_t, const std::vector<WrittenMessage>*>> index_;
};

class BagWriter {
 public:
  static Bytes write(const LogPlan& plan) {
    BagWriter writer(plan);
    return std::move(writer.out_.all());
  }

 private:
  explicit BagWriter(const LogPlan& plan) : plan_(plan) {
    out_.text("#ROSBAG V2.0\n");
    put_head(0);
    for (const auto& messages : plan.chunks) put_chunk(messages);
    if (!plan.has_index) return;
    const std::uint64_t index = out_.size();
    for (std::size_t i = 0; i < plan.channels.size(); ++i) put_connection(out_, i);
    ByteWriter whole;
    std::swap(whole, out_);
    out_.text("#ROSBAG V2.0\n");
    put_head(index);
    out_.bytes(std::span(whole.all()).subspan(out_.size()));
  }

  template <typename Number>
  static ByteWriter field(std::string_view name, std::type_identity_t<Number> value) {
    ByteWriter number;
    number.number<Number>(value);
    return text_field(name, {reinterpret_cast<const char*>(number.all().data()), number.size()});
  }
  static ByteWriter text_field(std::string_view name, std::string_view value) {
    return ByteWriter().counted<std::uint32_t>(std::string(name) + "=" + std::string(value));
  }
  static void record(ByteWriter& out, std::uint8_t opcode, std::initializer_list<ByteWriter> fields,
                     std::span<const std::uint8_t> data) {
    ByteWriter header = field<std::uint8_t>("op", opcode);
    for (const ByteWriter& one : fields) header.bytes(one.all());
    out.counted<std::uint32_t>(header.all()).counted<std::uint32_t>(data);
  }

  void put_head(std::uint64_t index) {
    record(out_, 0x03,
           {field<std::uint64_t>("index_pos", index), field<std::uint32_t>("conn_count", 1),
            field<std::uint32_t>("chunk_count", 1)},
           Bytes(16, ' '));
  }
  void put_connection(ByteWriter& out, std::size_t number) const {
    const Channel& channel = plan_.channels[number];
    ByteWriter about = text_field("topic", channel.topic);
    about.bytes(text_field("type", channel.type_name).all());
    record(out, 0x07,
           {field<std::uint32_t>("conn", static_cast<std::uint32_t>(number)),
            text_field("topic", channel.topic)},
           about.all());
  }
  static std::uint64_t bag_time(TimestampNs time) {
    return static_cast<std::uint64_t>(time % 1'000'000'000) << 32U |
           static_cast<std::uint64_t>(time / 1'000'000'000);
  }
  void put_chunk(const std::vector<WrittenMessage>& messages) {
    ByteWriter records;
    std::map<std::size_t, int> counts;
    for (const WrittenMessage& message : messages) {
      if (known_[message.channel]++ == 0) put_connection(records, message.channel);
      ++counts[message.channel];
      record(records, 0x02,
             {field<std::uint32_t>("conn", static_cast<std::uint32_t>(message.channel)),
              field<std::uint64_t>("time", bag_time(message.time_ns))},
             message.data);
    }
    const Bytes packed = pack_bytes(plan_.packing, records.all());
    record(out_, 0x05,
           {text_field("compression", plan_.packing.empty() ? "none" : plan_.packing),
            field<std::uint32_t>("size", static_cast<std::uint32_t>(records.size()))},
           packed);
    for (const auto& [channel, count] : counts) {
      record(out_, 0x04,
             {field<std::uint32_t>("ver", 1),
              field<std::uint32_t>("conn", static_cast<std::uint32_t>(channel)),
              field<std::uint32_t>("count", static_cast<std::uint32_t>(count))},
             Bytes(static_cast<std::size_t>(12 * count)));
    }
  }

  const LogPlan& plan_;
  ByteWriter out_;
  std::map<std::size_t, int> known_;
};

}  // namespace roomwise::recording::testing
