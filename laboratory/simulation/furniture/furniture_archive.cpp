#include "laboratory/simulation/furniture/furniture_archive.h"

#include <zip.h>

#include <utility>

namespace roomwise::simulation {
namespace {

// More than any file of the archives holds (the largest is 20 MB): a damaged directory must not
// take all memory.
constexpr zip_uint64_t kMaxBytes = 256U << 20U;

std::string message_of(int code) {
  zip_error_t error;
  zip_error_init_with_code(&error, code);
  std::string message = zip_error_strerror(&error);
  zip_error_fini(&error);
  return message;
}

struct CloseFile {
  void operator()(zip_file_t* file) const { zip_fclose(file); }
};

}  // namespace

void FurnitureArchive::Close::operator()(::zip* archive) const {
  zip_discard(archive);
}

FurnitureArchive::FurnitureArchive(std::filesystem::path path, ::zip* archive)
    : path_(std::move(path)), archive_(archive) {}

Expected<FurnitureArchive> FurnitureArchive::open(const std::filesystem::path& path) {
  int code = 0;
  zip_t* archive = zip_open(path.c_str(), ZIP_RDONLY, &code);
  if (archive == nullptr) {
    return fail("{}: cannot be read as a zip archive of furniture ({}); {}", path.string(),
                message_of(code), kInstallFurniture);
  }
  return FurnitureArchive(path, archive);
}

Expected<Bytes> FurnitureArchive::read(const std::string& name) const {
  const auto broken = [&](std::string_view why) {
    return fail("{}: {}: {}; {}", path_.string(), name, why, kInstallFurniture);
  };
  zip_stat_t stat;
  if (zip_stat(archive_.get(), name.c_str(), 0, &stat) != 0) return broken("not in the archive");
  if ((stat.valid & ZIP_STAT_SIZE) == 0 || stat.size > kMaxBytes) return broken("damaged");
  const std::unique_ptr<zip_file_t, CloseFile> file(zip_fopen_index(archive_.get(), stat.index, 0));
  if (file == nullptr) return broken(zip_strerror(archive_.get()));
  Bytes bytes(static_cast<std::size_t>(stat.size));
  // libzip checks the sum of the bytes when it meets the file's end, so one byte more is asked for.
  std::uint8_t beyond_end = 0;
  if (zip_fread(file.get(), bytes.data(), stat.size) != static_cast<zip_int64_t>(stat.size) ||
      zip_fread(file.get(), &beyond_end, 1) != 0) {
    return broken("damaged");
  }
  return bytes;
}

std::vector<std::string> FurnitureArchive::files_in(std::string_view folder) const {
  const std::string prefix = std::string(folder) + "/";
  std::vector<std::string> names;
  const zip_int64_t count = zip_get_num_entries(archive_.get(), 0);
  for (zip_int64_t i = 0; i < count; ++i) {
    const char* entry = zip_get_name(archive_.get(), static_cast<zip_uint64_t>(i), 0);
    if (entry == nullptr) continue;
    const std::string_view name = entry;
    if (name.size() > prefix.size() && name.starts_with(prefix) && !name.ends_with('/')) {
      names.emplace_back(name.substr(prefix.size()));
    }
  }
  return names;
}

}  // namespace roomwise::simulation
