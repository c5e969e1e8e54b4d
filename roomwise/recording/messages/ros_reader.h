#pragma once

#include <bit>
#include <string>

#include "roomwise/base/byte_reader.h"
#include "roomwise/recording/messages/messages.h"

namespace roomwise::recording {

// The fields of a ROS message one after the other: ROS 1 packs them; CDR (ROS 2, XCDR1) aligns each
// to its own size, counted from behind its four bytes of preamble, which also tell the byte order.
// As with ByteReader, callers ask ok() once.
class RosReader {
 public:
  RosReader(std::span<const std::uint8_t> message, Encoding encoding)
      : reader_(message), is_cdr_(encoding == Encoding::kCdr) {
    if (is_cdr_) read_preamble();
  }

  [[nodiscard]] bool ok() const { return reader_.ok() && is_known_; }
  [[nodiscard]] std::size_t remaining() const { return reader_.remaining(); }

  template <typename Number>
  Number number() {
    align(sizeof(Number));
    return reader_.number<Number>(order_);
  }
  std::string text() {
    std::string text(reader_.text(number<std::uint32_t>()));
    if (is_cdr_ && text.ends_with('\0')) text.pop_back();
    return text;
  }
  std::span<const std::uint8_t> counted_bytes() { return reader_.bytes(number<std::uint32_t>()); }
  TimestampNs time() {
    // ROS 1 counts unsigned seconds, ROS 2 signed ones.
    const auto s = number<std::uint32_t>();
    const auto ns = number<std::uint32_t>();
    const std::int64_t seconds = is_cdr_ ? static_cast<std::int32_t>(s) : std::int64_t{s};
    return seconds * 1'000'000'000 + ns;
  }
  MessageHeader header() {
    if (!is_cdr_) number<std::uint32_t>();  // a count
    MessageHeader header;
    header.timestamp_ns = time();
    header.frame = text();
    if (header.frame.starts_with('/')) header.frame.erase(0, 1);
    return header;
  }

 private:
  void read_preamble() {
    reader_.number<std::uint8_t>();
    const auto kind = reader_.number<std::uint8_t>();
    reader_.number<std::uint16_t>();
    is_known_ = kind <= 1;
    order_ = kind == 0 ? std::endian::big : std::endian::little;
  }
  void align(std::size_t size) {
    if (!is_cdr_ || !reader_.ok()) return;
    reader_.bytes((size - (reader_.position() - 4) % size) % size);
  }

  ByteReader reader_;
  bool is_cdr_;
  bool is_known_ = true;
  std::endian order_ = std::endian::little;
};

}  // namespace roomwise::recording
