#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "roomwise/base/file.h"

// The parts of decode_lzfse(); callers use lzfse.h.
namespace roomwise::recording {

// What a Lempel-Ziv decoder writes: bytes as they are, and repetitions of what came before. It
// never grows beyond `max_size`.
class LzOutput {
 public:
  explicit LzOutput(std::size_t max_size) : max_size_(max_size) {}

  [[nodiscard]] std::size_t size() const { return bytes_.size(); }
  // False, and nothing is written, where it would grow too large.
  [[nodiscard]] bool append(std::span<const std::uint8_t> bytes);
  // `count` bytes from `distance` back, which may overlap what is written. False, too, where that
  // lies before the first byte.
  [[nodiscard]] bool repeat(std::size_t distance, std::size_t count);
  [[nodiscard]] Bytes take() && { return std::move(bytes_); }

 private:
  Bytes bytes_;
  std::size_t max_size_;
};

// The payload of one block of LZVN. False where it is damaged.
[[nodiscard]] bool decode_lzvn(std::span<const std::uint8_t> payload, LzOutput& out);

}  // namespace roomwise::recording
