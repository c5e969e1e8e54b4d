#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "roomwise/base/file.h"

struct zip;  // libzip's

namespace roomwise::simulation {

// A zip archive of furniture (.sh3f), open for reading. Not thread-safe: every thread opens its
// own.
class FurnitureArchive {
 public:
  // Fails, naming the package that brings the archives, where the file is missing or damaged.
  [[nodiscard]] static Expected<FurnitureArchive> open(const std::filesystem::path& path);

  // The unpacked bytes of a file of the archive.
  [[nodiscard]] Expected<Bytes> read(const std::string& name) const;
  // The names of the files in a folder of the archive, without the folder.
  [[nodiscard]] std::vector<std::string> files_in(std::string_view folder) const;

 private:
  struct Close {
    void operator()(::zip* archive) const;
  };

  FurnitureArchive(std::filesystem::path path, ::zip* archive);

  std::filesystem::path path_;
  std::unique_ptr<::zip, Close> archive_;
};

// How every error of a missing or damaged archive ends.
constexpr std::string_view kInstallFurniture =
    "install Debian's package sweethome3d-furniture (apt install sweethome3d-furniture)";

}  // namespace roomwise::simulation
