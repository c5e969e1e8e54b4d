#include "roomwise/download/part_file.h"

#include <fcntl.h>
#include <openssl/evp.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "roomwise/base/encodings.h"
#include "roomwise/base/file.h"
#include "roomwise/base/file_descriptor.h"

namespace roomwise::download {
namespace {

namespace fs = std::filesystem;
using Block = std::span<const std::uint8_t>;

Unexpected failed(const fs::path& path, const char* what) {
  return fail("{}: {}: {}", path.string(), what, std::strerror(errno));
}

// Hands on what is in the file, a block after the other: networks are larger than memory should be.
template <typename Take>
Expected<void> read_blocks(const fs::path& path, const Take& take) {
  const FileDescriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC)};
  if (file.value < 0) return failed(path, "cannot be opened");
  std::vector<std::uint8_t> block(std::size_t{1} << 20U);
  for (;;) {
    const ssize_t got = ::read(file.value, block.data(), block.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return failed(path, "cannot be read");
    if (got == 0) return {};
    ROOMWISE_RETURN_IF_ERROR(take(Block(block).first(static_cast<std::size_t>(got))));
  }
}

struct ContextFreer {
  void operator()(EVP_MD_CTX* context) const { EVP_MD_CTX_free(context); }
};

Expected<FetchedFile> measure(const fs::path& path) {
  const std::unique_ptr<EVP_MD_CTX, ContextFreer> context(EVP_MD_CTX_new());
  EVP_DigestInit_ex(context.get(), EVP_sha256(), nullptr);
  FetchedFile found;
  ROOMWISE_RETURN_IF_ERROR(read_blocks(path, [&](Block block) -> Expected<void> {
    EVP_DigestUpdate(context.get(), block.data(), block.size());
    found.bytes += block.size();
    return {};
  }));
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int length = 0;
  EVP_DigestFinal_ex(context.get(), digest.data(), &length);
  found.sha256 = hexadecimal(std::span(digest).first(length));
  return found;
}

Expected<void> compare(const fs::path& file, const FetchedFile& found,
                       const ExpectedFile& expected) {
  if (expected.bytes && found.bytes != *expected.bytes) {
    return fail("{}: has {} bytes; expected {}", file.string(), found.bytes, *expected.bytes);
  }
  if (!found.sha256.starts_with(expected.sha256_begin)) {
    return fail("{}: is not the file that was published: its SHA-256 is {}; expected {}{}",
                file.string(), found.sha256, expected.sha256_begin,
                expected.sha256_begin.size() < 64 ? "..." : "");
  }
  return {};
}

// Whether the open file still has that name: whoever held it before may have renamed it.
bool has_name(int descriptor, const fs::path& path) {
  struct stat opened {};
  struct stat named {};
  return ::fstat(descriptor, &opened) == 0 && ::stat(path.c_str(), &named) == 0 &&
         opened.st_dev == named.st_dev && opened.st_ino == named.st_ino;
}

}  // namespace

bool is_digest_begin(std::string_view text) {
  return text.size() <= 64 && std::ranges::all_of(text, [](char c) {
           return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
         });
}

Expected<FetchedFile> check_file(const fs::path& file, const ExpectedFile& expected) {
  ROOMWISE_TRY(FetchedFile found, measure(file));
  ROOMWISE_RETURN_IF_ERROR(compare(file, found, expected));
  return found;
}

PartFile::PartFile(fs::path target, int descriptor)
    : target_(std::move(target)), path_(target_.string() + ".part"), descriptor_(descriptor) {}

PartFile::PartFile(PartFile&& other) noexcept
    : target_(std::move(other.target_)),
      path_(std::move(other.path_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      named_(std::exchange(other.named_, false)) {}

PartFile::~PartFile() {
  if (descriptor_ < 0) return;
  const auto size = bytes();
  if (named_ && size && *size == 0) remove();
  ::close(descriptor_);
}

Expected<PartFile> PartFile::open(const fs::path& target) {
  std::error_code error;
  fs::create_directories(target.parent_path(), error);
  if (error) return fail("{}: cannot be made: {}", target.parent_path().string(), error.message());
  const fs::path path = target.string() + ".part";
  for (;;) {
    FileDescriptor file{::open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0644)};
    if (file.value < 0) return failed(path, "cannot be written");
    if (::flock(file.value, LOCK_EX | LOCK_NB) != 0) {
      if (errno != EWOULDBLOCK) return failed(path, "cannot be locked");
      return fail("{}: another program is fetching it; wait until it has ended", path.string());
    }
    if (has_name(file.value, path)) return PartFile(target, std::exchange(file.value, -1));
  }
}

Expected<std::uint64_t> PartFile::bytes() const {
  struct stat status {};
  if (::fstat(descriptor_, &status) != 0) return failed(path_, "cannot be read");
  return static_cast<std::uint64_t>(status.st_size);
}

std::string PartFile::origin() const {
  return read_text_file(origin_path()).value_or("");
}

Expected<void> PartFile::set_origin(std::string_view origin) {
  if (!origin.empty()) return write_file(origin_path(), origin);
  std::error_code ignored;
  fs::remove(origin_path(), ignored);
  return {};
}

Expected<void> PartFile::clear() {
  ROOMWISE_RETURN_IF_ERROR(set_origin(""));
  if (::ftruncate(descriptor_, 0) != 0) return failed(path_, "cannot be emptied");
  return {};
}

Expected<void> PartFile::append(Block bytes) {
  if (!write_whole(descriptor_, bytes)) return failed(path_, "cannot be written");
  return {};
}

Expected<void> PartFile::flush_to_disk() {
  if (::fsync(descriptor_) != 0) return failed(path_, "cannot be flushed to the disk");
  return {};
}

// The part is the last to go: whoever sees it gone may begin another with an ETag of its own.
void PartFile::remove() {
  std::error_code ignored;
  fs::remove(origin_path(), ignored);
  fs::remove(path_, ignored);
  named_ = false;
}

Expected<FetchedFile> PartFile::accept(const ExpectedFile& expected,
                                       const BeforeNaming& before_naming) {
  ROOMWISE_TRY(FetchedFile found, measure(path_));
  if (const auto as_expected = compare(path_, found, expected); !as_expected) {
    remove();
    return Unexpected(as_expected.error());
  }
  if (before_naming) ROOMWISE_RETURN_IF_ERROR(before_naming(found));
  ROOMWISE_RETURN_IF_ERROR(set_origin(""));
  std::error_code error;
  fs::rename(path_, target_, error);
  if (error) return fail("{}: cannot be put in place: {}", target_.string(), error.message());
  named_ = false;
  return found;
}

Expected<FetchedFile> copy_checked(const fs::path& source, const fs::path& target,
                                   const ExpectedFile& expected,
                                   const BeforeNaming& before_naming) {
  ROOMWISE_RETURN_IF_ERROR(check_file(source, expected));
  ROOMWISE_TRY(PartFile part, PartFile::open(target));
  ROOMWISE_RETURN_IF_ERROR(part.clear());
  const auto copied = read_blocks(source, [&](Block block) { return part.append(block); });
  if (!copied) {
    part.remove();
    return Unexpected(copied.error());
  }
  ROOMWISE_RETURN_IF_ERROR(part.flush_to_disk());
  return part.accept(expected, before_naming);
}

}  // namespace roomwise::download
