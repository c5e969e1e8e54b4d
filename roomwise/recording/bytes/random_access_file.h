#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <utility>

#include "roomwise/base/file.h"

namespace roomwise::recording {

// A file that is read in parts, wherever they lie. Reading is thread-safe. Errors name the file.
class RandomAccessFile {
 public:
  // Fails where it is missing, no regular file, or unreadable.
  [[nodiscard]] static Expected<RandomAccessFile> open(const std::filesystem::path& path);

  RandomAccessFile(RandomAccessFile&& other) noexcept
      : path_(std::move(other.path_)),
        descriptor_(std::exchange(other.descriptor_, -1)),
        size_(other.size_) {}
  RandomAccessFile& operator=(RandomAccessFile&&) = delete;
  ~RandomAccessFile();

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::uint64_t size() const { return size_; }  // bytes, when it was opened
  [[nodiscard]] bool holds(std::uint64_t offset, std::uint64_t size) const {
    return offset <= size_ && size <= size_ - offset;
  }
  // Fails, before memory is taken, where the file ends within the part.
  [[nodiscard]] Expected<Bytes> read(std::uint64_t offset, std::uint64_t size) const;
  [[nodiscard]] Expected<void> read(std::uint64_t offset, std::span<std::uint8_t> into) const;

 private:
  RandomAccessFile(std::filesystem::path path, int descriptor, std::uint64_t size)
      : path_(std::move(path)), descriptor_(descriptor), size_(size) {}

  std::filesystem::path path_;
  int descriptor_;
  std::uint64_t size_;
};

}  // namespace roomwise::recording
