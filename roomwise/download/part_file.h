#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "roomwise/base/expected.h"

namespace roomwise::download {

// What is known beforehand of a file that is fetched; what is absent is not checked.
struct ExpectedFile {
  std::optional<std::uint64_t> bytes;
  // Lower-case hexadecimal, all 64 digits or the first ones.
  std::string sha256_begin;
};

// A file that is in place.
struct FetchedFile {
  std::uint64_t bytes = 0;
  std::string sha256;
  std::uint64_t resumed_from = 0;  // bytes that an earlier try had left
};

// Called with a file that is as expected, before it gets its name: what must be on the disk no
// later than the file is written here. Where it fails, the file does not get its name.
using BeforeNaming = std::function<Expected<void>(const FetchedFile&)>;

// Size and digest of a file that is there. Fails where it is not as expected, saying how.
[[nodiscard]] Expected<FetchedFile> check_file(const std::filesystem::path& file,
                                               const ExpectedFile& expected);

// TARGET.part, in which a file is put together before it gets its name, and TARGET.part.etag, which
// says what it is a part of. Nobody else has it open as such. It stays when this goes away, unless
// nothing has come.
class PartFile {
 public:
  // Opens it as it is, or empty; also makes its folder. Fails where somebody else is at it.
  [[nodiscard]] static Expected<PartFile> open(const std::filesystem::path& target);
  PartFile(PartFile&& other) noexcept;
  PartFile& operator=(PartFile&&) = delete;
  ~PartFile();

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] Expected<std::uint64_t> bytes() const;
  // What set_origin() was told; empty where nobody did.
  [[nodiscard]] std::string origin() const;
  // Remembers what it is a part of; forgets it where that is empty.
  [[nodiscard]] Expected<void> set_origin(std::string_view origin);

  [[nodiscard]] Expected<void> clear();
  [[nodiscard]] Expected<void> append(std::span<const std::uint8_t> bytes);
  [[nodiscard]] Expected<void> flush_to_disk();
  // Deletes it; nothing can be done with it afterwards.
  void remove();
  // Checks it and gives it the name of the target. What is not as expected is deleted; what cannot
  // be read or named stays.
  [[nodiscard]] Expected<FetchedFile> accept(const ExpectedFile& expected,
                                             const BeforeNaming& before_naming);

 private:
  PartFile(std::filesystem::path target, int descriptor);
  [[nodiscard]] std::filesystem::path origin_path() const { return path_.string() + ".etag"; }

  std::filesystem::path target_;
  std::filesystem::path path_;
  int descriptor_ = -1;
  bool named_ = true;  // as TARGET.part
};

// Puts a file of this machine in place as a fetched one.
[[nodiscard]] Expected<FetchedFile> copy_checked(const std::filesystem::path& source,
                                                 const std::filesystem::path& target,
                                                 const ExpectedFile& expected,
                                                 const BeforeNaming& before_naming = {});

// Whether it can be the beginning of a SHA-256, or all of it: lower-case hexadecimal digits.
[[nodiscard]] bool is_digest_begin(std::string_view text);

}  // namespace roomwise::download
