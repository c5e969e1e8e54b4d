#include "roomwise/recording/phone/zip_file.h"

#include <zip.h>

#include <algorithm>

namespace roomwise::recording {
namespace {

constexpr std::size_t kZipStep = std::size_t{1} << 18;

std::string zip_message(int code) {
  zip_error_t error;
  zip_error_init_with_code(&error, code);
  std::string message = zip_error_strerror(&error);
  zip_error_fini(&error);
  return message;
}

struct CloseEntry {
  void operator()(zip_file_t* file) const { zip_fclose(file); }
};

bool climbs(const std::filesystem::path& name) {
  return name.is_absolute() || std::ranges::find(name, "..") != name.end();
}

}  // namespace

void ZipFile::Close::operator()(zip* archive) const {
  zip_discard(archive);
}

Expected<ZipFile> ZipFile::open(const std::filesystem::path& path) {
  std::error_code ignored;
  if (std::filesystem::exists(path, ignored) && !std::filesystem::is_regular_file(path, ignored)) {
    return fail("{}: is no regular file; give a zip archive", path.string());
  }
  int code = 0;
  zip_t* archive = zip_open(path.c_str(), ZIP_RDONLY, &code);
  if (archive == nullptr) {
    return fail("{}: cannot be read as a zip archive ({}); copy it again", path.string(),
                zip_message(code));
  }
  ZipFile file(path, archive);
  for (zip_int64_t i = 0; i < zip_get_num_entries(archive, 0); ++i) {
    const char* name = zip_get_name(archive, static_cast<zip_uint64_t>(i), 0);
    if (name != nullptr && climbs(name)) {
      return fail("{}: names '{}', a file outside of the archive's folder; it is not safe",
                  path.string(), name);
    }
  }
  return file;
}

bool ZipFile::contains(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  return zip_name_locate(archive_.get(), name.c_str(), 0) >= 0;
}

Expected<Bytes> ZipFile::read(const std::string& name, std::size_t max_size) const {
  const std::lock_guard lock(mutex_);
  const auto broken = [&](std::string_view why) {
    return fail("{}: {}: {}", path_.string(), name, why);
  };
  const std::unique_ptr<zip_file_t, CloseEntry> file(zip_fopen(archive_.get(), name.c_str(), 0));
  if (file == nullptr) return broken("is not in the archive, or damaged");
  Bytes bytes;
  for (std::size_t filled = 0;;) {
    if (filled > max_size) return broken(fmt::format("has more than {} bytes", max_size));
    bytes.resize(std::min(filled + std::max(kZipStep, filled), max_size + 1));
    const zip_int64_t count = zip_fread(file.get(), bytes.data() + filled, bytes.size() - filled);
    if (count < 0) return broken("is damaged; copy the recording again");
    filled += static_cast<std::size_t>(count);
    if (count > 0) continue;
    bytes.resize(filled);
    return bytes;
  }
}

}  // namespace roomwise::recording
