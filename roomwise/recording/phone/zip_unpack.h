#pragma once

#include <cstdint>
#include <filesystem>

#include "roomwise/base/expected.h"
#include "roomwise/base/progress.h"

namespace roomwise::recording {

// What an archive may become, so that a small one that somebody hands in cannot fill the disk.
struct UnpackLimits {
  std::uint64_t max_bytes = std::uint64_t{64} << 30U;  // of all files together
  std::uint64_t max_files = 500'000;
  // Of all files to the archive: pictures and videos hardly shrink, numbers in text some ten times.
  double max_ratio = 100;

  [[nodiscard]] Expected<void> validate() const;
};

// Whether it begins as a zip archive does. False where it cannot be read.
[[nodiscard]] bool is_zip_file(const std::filesystem::path& path);

// Writes the files of a zip archive into a new folder. All names and sizes are looked at before the
// first is written: refused are names that lead out of the folder or some thirty folders deep,
// links, names that come twice, and more than `limits` say. What macOS and iOS add for themselves
// (__MACOSX, ._*, .DS_Store) is left out. Memory does not grow with the archive but for the list of
// its names. Fails on damage (a wrong check sum; kDamaged), on what is not safe (kRefused; a file
// that is longer than it says), a full disk and interruption; what was written by then stays, for
// the caller to remove.
[[nodiscard]] Expected<void> unpack_zip(const std::filesystem::path& archive,
                                        const std::filesystem::path& folder,
                                        const UnpackLimits& limits, Progress& progress);

}  // namespace roomwise::recording
