#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <utility>

#include "roomwise/base/expected.h"
#include "roomwise/base/file.h"

namespace roomwise {

// How much of something that grows, as a map does, stays in memory. It changes no result.
struct WorkingSet {
  std::size_t max_bytes = std::size_t{128} << 20U;
  // The rest goes into a scratch file on this folder's disk; empty: all stays in memory.
  std::filesystem::path scratch_folder;
};

// A file without a name, for what does not fit into memory: it takes room on the disk while it is
// used, and is gone with the program, however that ends.
class ScratchFile {
 public:
  // On the disk that holds the folder. Errors of all functions name the folder.
  [[nodiscard]] static Expected<ScratchFile> create(const std::filesystem::path& folder);
  ScratchFile(ScratchFile&& other) noexcept
      : folder_(std::move(other.folder_)),
        descriptor_(std::exchange(other.descriptor_, -1)),
        size_(other.size_) {}
  ScratchFile& operator=(ScratchFile&&) = delete;
  ~ScratchFile();

  // Where the bytes lie from now on.
  [[nodiscard]] Expected<std::uint64_t> append(std::span<const std::uint8_t> bytes);
  // In the place of bytes that lie there.
  [[nodiscard]] Expected<void> overwrite(std::uint64_t offset, std::span<const std::uint8_t> bytes);
  [[nodiscard]] Expected<Bytes> read(std::uint64_t offset, std::size_t size) const;

 private:
  ScratchFile(std::filesystem::path folder, int descriptor)
      : folder_(std::move(folder)), descriptor_(descriptor) {}

  std::filesystem::path folder_;
  int descriptor_;
  std::uint64_t size_ = 0;
};

}  // namespace roomwise
