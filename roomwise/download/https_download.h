#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "roomwise/base/expected.h"
#include "roomwise/base/progress.h"

namespace roomwise::download {

// What is known beforehand of a file that is fetched; what is absent is not checked.
struct ExpectedFile {
  std::optional<std::uint64_t> bytes;
  // Lower-case hexadecimal, all 64 digits or the first ones.
  std::string sha256_begin;
};

struct DownloadOptions {
  std::uint64_t most_bytes = std::uint64_t{2} << 30U;
  int connect_timeout_s = 30;
  int stall_timeout_s = 30;  // without a kilobyte a second on average
  // Certificates to trust in place of the system's.
  std::filesystem::path certificates = {};

  [[nodiscard]] Expected<void> validate() const;
};

// A file that is in place.
struct FetchedFile {
  std::uint64_t bytes = 0;
  std::string sha256;
  std::uint64_t resumed_from = 0;  // bytes that an earlier try had left
};

// Fetches `url`, which must be https and may lead on to https only, into the file `target`.
//
// It is written to TARGET.part, checked, and only then gets its name; what is not as expected is
// deleted. What a broken connection or Ctrl-C leaves stays in TARGET.part, and its ETag in
// TARGET.part.etag: the next try goes on from there if the server still has the same file, and
// begins anew otherwise. Errors name the address and what to do.
[[nodiscard]] Expected<FetchedFile> download(const std::string& url,
                                             const std::filesystem::path& target,
                                             const ExpectedFile& expected, Progress& progress,
                                             const DownloadOptions& options = {});

// The same from a file of this machine.
[[nodiscard]] Expected<FetchedFile> copy_checked(const std::filesystem::path& source,
                                                 const std::filesystem::path& target,
                                                 const ExpectedFile& expected);

// Size and digest of a file that is there. Fails where it is not as expected, saying how.
[[nodiscard]] Expected<FetchedFile> check_file(const std::filesystem::path& file,
                                               const ExpectedFile& expected);

// Whether it can be the beginning of a SHA-256, or all of it: lower-case hexadecimal digits.
[[nodiscard]] bool is_digest_begin(std::string_view text);

}  // namespace roomwise::download
