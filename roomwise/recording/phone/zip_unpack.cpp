#include "roomwise/recording/phone/zip_unpack.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zip.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "roomwise/base/file.h"

namespace roomwise::recording {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kUnpackStep = std::size_t{1} << 20;
// No app's names come near it; folders within many folders could not be removed again.
constexpr std::ptrdiff_t kMaxNameParts = 32;
constexpr std::size_t kMaxNameBytes = 512;

struct DiscardArchive {
  void operator()(zip* archive) const { zip_discard(archive); }
};
using OpenArchive = std::unique_ptr<zip, DiscardArchive>;
struct CloseUnpacked {
  void operator()(zip_file_t* file) const { zip_fclose(file); }
};

struct Entry {
  zip_uint64_t index = 0;
  std::string name;
  std::uint64_t bytes = 0;
};

bool is_of_the_system(const fs::path& name) {
  return std::ranges::any_of(name, [](const fs::path& part) {
    return part == "__MACOSX" || part == ".DS_Store" || part.string().starts_with("._");
  });
}

bool leads_out(const std::string& name) {
  const fs::path path(name);
  return path.is_absolute() || name.find('\\') != std::string::npos ||
         std::ranges::find(path, "..") != path.end();
}

bool is_link(zip* archive, zip_uint64_t index) {
  zip_uint8_t system = 0;
  zip_uint32_t attributes = 0;
  const bool known = zip_file_get_external_attributes(archive, index, 0, &system, &attributes) == 0;
  return known && system == ZIP_OPSYS_UNIX && S_ISLNK(attributes >> 16U);
}

// A new file; all of its bytes or an error.
class UnpackedFile {
 public:
  explicit UnpackedFile(const fs::path& path)
      : path_(path),
        descriptor_(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644)) {
    if (descriptor_ < 0) error_ = errno;
  }
  ~UnpackedFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  UnpackedFile(const UnpackedFile&) = delete;
  UnpackedFile& operator=(const UnpackedFile&) = delete;

  [[nodiscard]] Expected<void> append(std::span<const std::uint8_t> bytes) {
    while (error_ == 0 && !bytes.empty()) {
      const ssize_t put = ::write(descriptor_, bytes.data(), bytes.size());
      if (put >= 0) {
        bytes = bytes.subspan(static_cast<std::size_t>(put));
      } else if (errno != EINTR) {
        error_ = errno;
      }
    }
    if (error_ == 0) return {};
    const ErrorCode code = code_of_write_error(error_);
    return fail_with(code, "{}: cannot be written: {}{}", path_.string(), std::strerror(error_),
                     code == ErrorCode::kDiskFull ? "; free some space, then try again" : "");
  }

 private:
  fs::path path_;
  int descriptor_;
  int error_ = 0;
};

class Unpacker {
 public:
  Unpacker(fs::path path, OpenArchive archive, const UnpackLimits& limits)
      : path_(std::move(path)), archive_(std::move(archive)), limits_(limits) {}

  // What is to be written, once all of it is known to be safe.
  [[nodiscard]] Expected<std::vector<Entry>> list() const {
    const zip_int64_t count = zip_get_num_entries(archive_.get(), 0);
    if (static_cast<std::uint64_t>(count) > limits_.max_files) {
      return fail_with(ErrorCode::kRefused, "{}: holds {} files; at most {} are unpacked",
                       path_.string(), count, limits_.max_files);
    }
    std::vector<Entry> entries;
    std::set<std::string> names;
    std::uint64_t bytes = 0;
    for (zip_uint64_t i = 0; i < static_cast<zip_uint64_t>(count); ++i) {
      ROOMWISE_TRY(Entry entry, entry_at(i));
      if (entry.name.ends_with('/') || is_of_the_system(entry.name)) continue;
      if (!names.insert(fs::path(entry.name).lexically_normal()).second) {
        return unsafe(fmt::format("names '{}' twice", entry.name));
      }
      if (entry.bytes > limits_.max_bytes - bytes) return too_large();
      bytes += entry.bytes;
      entries.push_back(std::move(entry));
    }
    ROOMWISE_RETURN_IF_ERROR(check_ratio(bytes));
    return entries;
  }

  [[nodiscard]] Expected<void> write(const Entry& entry, const fs::path& folder) const {
    const fs::path file_path = folder / entry.name;
    std::error_code error;
    fs::create_directories(file_path.parent_path(), error);
    if (error)
      return fail("{}: cannot be made: {}", file_path.parent_path().string(), error.message());
    UnpackedFile out(file_path);
    const std::unique_ptr<zip_file_t, CloseUnpacked> in(
        zip_fopen_index(archive_.get(), entry.index, 0));
    if (in == nullptr) {
      return broken(entry, zip_error_strerror(zip_get_error(archive_.get())));
    }
    std::vector<std::uint8_t> buffer(kUnpackStep);
    for (std::uint64_t written = 0;;) {
      const zip_int64_t read = zip_fread(in.get(), buffer.data(), buffer.size());
      if (read < 0) return broken(entry, "it is damaged; export it again");
      if (read == 0 && written == entry.bytes) return out.append({});
      if (read == 0 || static_cast<std::uint64_t>(read) > entry.bytes - written) {
        return unsafe(fmt::format("'{}' is not as long as the archive says", entry.name));
      }
      ROOMWISE_RETURN_IF_ERROR(out.append(std::span(buffer).first(static_cast<std::size_t>(read))));
      written += static_cast<std::uint64_t>(read);
    }
  }

 private:
  [[nodiscard]] Unexpected broken(const Entry& entry, std::string_view why) const {
    return fail_with(ErrorCode::kDamaged, "{}: {}: {}", path_.string(), entry.name, why);
  }
  // By whom it was made nobody knows: who hands it in again is refused again.
  [[nodiscard]] Unexpected unsafe(const std::string& why) const {
    return fail_with(ErrorCode::kRefused, "{}: {}; it is not safe", path_.string(), why);
  }
  [[nodiscard]] Unexpected too_large() const {
    return fail_with(
        ErrorCode::kDiskFull,
        "{}: would become more than the {} MB that there is room for; free some space, "
        "then try again",
        path_.string(), limits_.max_bytes / 1'000'000);
  }
  [[nodiscard]] Expected<Entry> entry_at(zip_uint64_t index) const {
    zip_stat_t stat;
    zip_stat_init(&stat);
    constexpr zip_uint64_t kNeeded = ZIP_STAT_NAME | ZIP_STAT_SIZE;
    if (zip_stat_index(archive_.get(), index, 0, &stat) != 0 || (stat.valid & kNeeded) != kNeeded) {
      return fail_with(ErrorCode::kDamaged, "{}: its list of files is damaged; export it again",
                       path_.string());
    }
    Entry entry{index, stat.name, stat.size};
    if (entry.name.empty() || leads_out(entry.name)) {
      return unsafe(fmt::format("names '{}', a file outside of the archive's folder", entry.name));
    }
    const fs::path path(entry.name);
    if (entry.name.size() > kMaxNameBytes ||
        std::distance(path.begin(), path.end()) > kMaxNameParts) {
      return unsafe(
          fmt::format("names a file that lies more than {} folders deep or has more than "
                      "{} letters",
                      kMaxNameParts - 1, kMaxNameBytes));
    }
    if (is_link(archive_.get(), index)) {
      return unsafe(fmt::format("'{}' is a link", entry.name));
    }
    return entry;
  }
  [[nodiscard]] Expected<void> check_ratio(std::uint64_t bytes) const {
    std::error_code error;
    const auto packed = static_cast<double>(fs::file_size(path_, error));
    if (error) return fail("{}: {}", path_.string(), error.message());
    if (static_cast<double>(bytes) <= limits_.max_ratio * packed) return {};
    return fail_with(
        ErrorCode::kRefused,
        "{}: would become {:.0f} times as large; recordings do not, so it is not unpacked",
        path_.string(), static_cast<double>(bytes) / packed);
  }

  fs::path path_;
  OpenArchive archive_;
  UnpackLimits limits_;
};

}  // namespace

Expected<void> UnpackLimits::validate() const {
  if (max_bytes == 0) return fail("max_bytes = 0 unpacks nothing");
  if (max_files == 0) return fail("max_files = 0 unpacks nothing");
  if (!(max_ratio >= 1)) return fail("max_ratio = {} must be at least 1", max_ratio);
  return {};
}

bool is_zip_file(const fs::path& path) {
  std::error_code ignored;
  if (!fs::is_regular_file(path, ignored)) return false;
  std::ifstream in(path, std::ios::binary);
  std::array<char, 4> head{};
  in.read(head.data(), head.size());
  const std::string_view text(head.data(), head.size());
  return in.good() &&
         (text == std::string_view("PK\3\4", 4) || text == std::string_view("PK\5\6", 4));
}

Expected<void> unpack_zip(const fs::path& archive, const fs::path& folder,
                          const UnpackLimits& limits, Progress& progress) {
  ROOMWISE_RETURN_IF_ERROR(limits.validate());
  int code = 0;
  OpenArchive opened(zip_open(archive.c_str(), ZIP_RDONLY, &code));
  if (opened == nullptr) {
    return fail_with(
        ErrorCode::kDamaged,
        "{}: cannot be read as a zip archive; it is damaged or not whole, export it again",
        archive.string());
  }
  const Unpacker unpacker(archive, std::move(opened), limits);
  ROOMWISE_TRY(const std::vector<Entry> entries, unpacker.list());
  std::error_code error;
  if (!fs::create_directories(folder, error)) {
    return fail("{}: cannot be made: {}", folder.string(),
                error ? error.message() : std::string("it is there already"));
  }
  progress.begin("unpacking", entries.size());
  for (std::size_t i = 0; i < entries.size(); ++i) {
    ROOMWISE_RETURN_IF_ERROR(progress.check("a recording was unpacked"));
    ROOMWISE_RETURN_IF_ERROR(unpacker.write(entries[i], folder));
    progress.advance(i + 1, "");
  }
  progress.end();
  return {};
}

}  // namespace roomwise::recording
