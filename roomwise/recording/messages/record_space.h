#pragma once

#include <cstdint>
#include <span>

#include "roomwise/recording/bytes/random_access_file.h"

namespace roomwise::recording {

// Bytes in which records lie one after the other: a part of a file, or a chunk that was unpacked.
// Of a file only what is looked at is read, some KB at a time, so that records can be passed over.
class RecordSpace {
 public:
  // Both must outlive it.
  explicit RecordSpace(std::span<const std::uint8_t> bytes) : bytes_(bytes), size_(bytes.size()) {}
  RecordSpace(const RandomAccessFile& file, std::uint64_t begin, std::uint64_t size)
      : file_(&file), begin_(begin), size_(size) {}

  [[nodiscard]] std::uint64_t size() const { return size_; }
  [[nodiscard]] bool holds(std::uint64_t offset, std::uint64_t size) const {
    return offset <= size_ && size <= size_ - offset;
  }
  // Valid until the next call. The part must lie within (holds()); fails where the file cannot be
  // read.
  [[nodiscard]] Expected<std::span<const std::uint8_t>> at(std::uint64_t offset,
                                                           std::uint64_t size);

 private:
  std::span<const std::uint8_t> bytes_;
  const RandomAccessFile* file_ = nullptr;
  std::uint64_t begin_ = 0, size_ = 0;
  Bytes window_;
  std::uint64_t window_begin_ = 0;
};

}  // namespace roomwise::recording
