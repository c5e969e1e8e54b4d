#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "roomwise/base/file.h"

struct zip;

namespace roomwise::recording {

// A zip archive that is read where it lies: nothing of it is written to the disk. Errors name the
// archive and the file in it. Reading is thread-safe.
class ZipFile {
 public:
  // Fails where it is no zip archive, or names a file that would lie outside of a folder.
  [[nodiscard]] static Expected<ZipFile> open(const std::filesystem::path& path);
  ZipFile(ZipFile&& other) noexcept
      : path_(std::move(other.path_)), archive_(std::move(other.archive_)) {}
  ZipFile& operator=(ZipFile&&) = delete;
  ~ZipFile() = default;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] bool contains(const std::string& name) const;
  // Memory grows with what comes out, at most to `max_size`: more is an error, however little it
  // was packed into. Its check sum must be right.
  [[nodiscard]] Expected<Bytes> read(const std::string& name, std::size_t max_size) const;

 private:
  struct Close {
    void operator()(zip* archive) const;
  };
  ZipFile(std::filesystem::path path, zip* archive) : path_(std::move(path)), archive_(archive) {}

  std::filesystem::path path_;
  std::unique_ptr<zip, Close> archive_;
  mutable std::mutex mutex_;
};

}  // namespace roomwise::recording
