#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

#include "roomwise/base/expected.h"

namespace roomwise::studies {

// SHA-256 of files, kept with their size and time of change, so that each task of a study need not
// read again what all of them are made with.
class KnownDigests {
 public:
  // As write() left them; none where that is not there or cannot be read.
  [[nodiscard]] static KnownDigests read(const std::filesystem::path& kept);
  [[nodiscard]] Expected<void> write(const std::filesystem::path& kept) const;

  // Of a file that is not known, or has changed since, it is worked out.
  [[nodiscard]] Expected<std::string> of(const std::filesystem::path& file);

 private:
  struct Known {
    std::uintmax_t bytes = 0;
    std::int64_t changed = 0;  // ticks of the file system's clock
    std::string sha256;
  };
  std::map<std::string, Known> files_;
};

}  // namespace roomwise::studies
