#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "roomwise/base/expected.h"
#include "roomwise/base/progress.h"
#include "roomwise/download/part_file.h"

namespace roomwise::download {

struct DownloadOptions {
  std::uint64_t max_bytes = std::uint64_t{2} << 30U;
  int connect_timeout_s = 30;
  int stall_timeout_s = 30;  // without a kilobyte a second on average
  // Certificates to trust in place of the system's.
  std::filesystem::path certificates = {};
  BeforeNaming before_naming = {};

  [[nodiscard]] Expected<void> validate() const;
};

// Fetches `url`, which must be https and may lead on to https only, into the file `target`.
//
// It is written to TARGET.part, checked, and only then gets its name; what is not as expected is
// deleted. What a broken connection or Ctrl-C leaves stays in TARGET.part, and its ETag in
// TARGET.part.etag: the next try goes on from there if the server still has the same file, and
// begins anew otherwise. What is all there by its digest only gets its name. While somebody else
// fetches the same TARGET, it fails. Errors name the address and what to do.
[[nodiscard]] Expected<FetchedFile> download(const std::string& url,
                                             const std::filesystem::path& target,
                                             const ExpectedFile& expected, Progress& progress,
                                             const DownloadOptions& options = {});

}  // namespace roomwise::download
