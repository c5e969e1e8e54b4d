#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/base/file.h"
#include "roomwise/live/recording/free_disk_bytes.h"

namespace roomwise::live {

struct UploadLimits {
  std::uint64_t max_bytes = std::uint64_t{32} << 30U;     // of one file
  std::size_t max_uploads = 4;                            // that wait at once, complete or not
  std::uint64_t reserve_bytes = std::uint64_t{1} << 30U;  // of the disk, that stay free
  // How many bytes are free where a file lies.
  FreeBytesQuery free_bytes = {};  // none: free_bytes_at()

  [[nodiscard]] Expected<void> validate() const;
};

// A file that somebody hands in, as far as it is there.
struct Upload {
  std::string id;    // the same for the same file, whoever begins it again
  std::string name;  // of the file, as it was told
  std::uint64_t bytes = 0;
  std::uint64_t offset = 0;  // bytes that are there: the next one's number
  std::string walk = {};     // the folder or file that it becomes; empty: nobody began that

  [[nodiscard]] bool is_complete() const { return offset == bytes; }
  friend bool operator==(const Upload&, const Upload&) = default;
};

// Files that come in pieces, in order, and outlive whatever stops: what is there is the file's own
// length, so that a kill at any byte loses nothing that came before. A piece is in memory, the file
// never. Thread-safe.
class Uploads {
 public:
  static constexpr std::size_t kMaxChunkBytes = std::size_t{1} << 20U;

  // `folder` is made with the first upload.
  [[nodiscard]] static Expected<Uploads> open(std::filesystem::path folder, UploadLimits limits);
  Uploads(Uploads&& other) noexcept
      : folder_(std::move(other.folder_)), limits_(std::move(other.limits_)) {}
  Uploads& operator=(Uploads&&) = delete;
  ~Uploads() = default;

  // A new upload, or the one that was begun of the same file before. `modified` tells files of the
  // same name and size apart. Fails where it is too large, too many wait, or the disk has no room.
  [[nodiscard]] Expected<Upload> begin(const std::string& name, std::uint64_t bytes,
                                       const std::string& modified);
  [[nodiscard]] Expected<std::vector<Upload>> list() const;  // by id
  [[nodiscard]] Expected<Upload> find(const std::string& id) const;
  // Adds what of `chunk`, which begins at `offset`, is not there yet: one that is sent again
  // changes nothing. Fails where bytes before it are missing, where it goes beyond the file's end,
  // and on a full disk; what had been there stays.
  [[nodiscard]] Expected<Upload> put(const std::string& id, std::uint64_t offset,
                                     std::span<const std::uint8_t> chunk);
  // Keeps what it becomes, for after a kill.
  [[nodiscard]] Expected<void> note_walk(const std::string& id, const std::string& walk);
  // No matter how much is there.
  [[nodiscard]] Expected<void> remove(const std::string& id);
  [[nodiscard]] Expected<void> remove_all();

  // The bytes.
  [[nodiscard]] std::filesystem::path file_of(const std::string& id) const;
  // That may still be written, with the reserve left free.
  [[nodiscard]] Expected<std::uint64_t> writable_bytes() const;

 private:
  Uploads(std::filesystem::path folder, UploadLimits limits)
      : folder_(std::move(folder)), limits_(std::move(limits)) {}
  [[nodiscard]] std::filesystem::path metadata_path(const std::string& id) const;
  // With the lock held.
  [[nodiscard]] Expected<Upload> read(const std::string& id) const;
  [[nodiscard]] Expected<void> write_facts(const Upload& upload) const;
  [[nodiscard]] Expected<std::vector<Upload>> read_all() const;

  std::filesystem::path folder_;
  UploadLimits limits_;
  mutable std::mutex mutex_;
};

}  // namespace roomwise::live
