#pragma once

#include <filesystem>

#include "roomwise/base/expected.h"

namespace roomwise::home {

// The right to be the one that writes a home, for as long as this lives: SQLite alone would let two
// programs write in turns, and each would map on from what it believes the other has not changed.
// A lock (flock) on the file NAME-lock beside it, which is removed at the end; the system drops the
// lock of a killed process.
class WriterLock {
 public:
  // Fails at once where another holds it.
  [[nodiscard]] static Expected<WriterLock> take(const std::filesystem::path& path);
  ~WriterLock();
  WriterLock(WriterLock&& other) noexcept;
  WriterLock& operator=(WriterLock&&) = delete;

 private:
  WriterLock(std::filesystem::path lock_path, int descriptor)
      : lock_path_(std::move(lock_path)), descriptor_(descriptor) {}

  std::filesystem::path lock_path_;
  int descriptor_;  // -1 once it was moved away
};

}  // namespace roomwise::home
