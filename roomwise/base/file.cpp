#include "roomwise/base/file.h"

#include <fcntl.h>
#include <openssl/evp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "roomwise/base/encodings.h"
#include "roomwise/base/file_descriptor.h"

namespace roomwise {
namespace {

template <typename Container>
Expected<Container> read_whole(const std::filesystem::path& path) {
  // A pipe that nobody writes would be waited for otherwise.
  const FileDescriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)};
  if (file.value < 0) return fail("{}: cannot be opened: {}", path.string(), std::strerror(errno));
  struct stat status {};
  if (::fstat(file.value, &status) != 0) {
    return fail("{}: cannot be read: {}", path.string(), std::strerror(errno));
  }
  if (S_ISDIR(status.st_mode)) return fail("{}: is a folder; expected a file", path.string());
  if (!S_ISREG(status.st_mode)) {
    return fail("{}: is a pipe or a device, which may never end; give a file", path.string());
  }
  Container content(static_cast<std::size_t>(status.st_size), 0);
  std::size_t filled = 0;
  for (;;) {
    if (filled == content.size()) content.resize(content.size() + 4096);  // it may grow
    const ssize_t got = ::read(file.value, content.data() + filled, content.size() - filled);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return fail("{}: cannot be read: {}", path.string(), std::strerror(errno));
    if (got == 0) break;
    filled += static_cast<std::size_t>(got);
  }
  content.resize(filled);
  return content;
}

// A device or a pipe (/dev/stdout) takes the bytes; it must not be replaced by a file.
Expected<void> write_into(const std::filesystem::path& path, std::span<const std::uint8_t> bytes) {
  const FileDescriptor file{::open(path.c_str(), O_WRONLY | O_CLOEXEC)};
  if (file.value < 0 || !write_whole(file.value, bytes)) {
    return fail_with(code_of_write_error(errno), "{}: cannot be written: {}", path.string(),
                     std::strerror(errno));
  }
  return {};
}

Unexpected refuse_database(const std::filesystem::path& path) {
  return fail("{}: is a home or another database and is not overwritten; choose another name",
              path.string());
}

// What write_file() writes before it renames.
std::filesystem::path partial_of(std::filesystem::path path) {
  path += fmt::format(".partial-{}", ::getpid());
  return path;
}

}  // namespace

ErrorCode code_of_write_error(int error) {
  const bool is_full = error == ENOSPC || error == EDQUOT || error == EFBIG;
  return is_full ? ErrorCode::kDiskFull : ErrorCode::kFailed;
}

Expected<Bytes> read_file(const std::filesystem::path& path) {
  return read_whole<Bytes>(path);
}

Expected<std::string> read_text_file(const std::filesystem::path& path) {
  return read_whole<std::string>(path);
}

bool is_database(const std::filesystem::path& path) {
  constexpr std::string_view kMagic("SQLite format 3\0", 16);
  std::array<char, kMagic.size()> first{};
  const FileDescriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)};
  return file.value >= 0 && ::read(file.value, first.data(), first.size()) == std::ssize(first) &&
         std::string_view(first.data(), first.size()) == kMagic;
}

Expected<void> check_can_write(const std::filesystem::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0) {
    if (S_ISDIR(status.st_mode)) return fail("{}: is a folder; name a file", path.string());
    if (is_database(path)) return refuse_database(path);
    if (!S_ISREG(status.st_mode)) return {};
  }
  const std::filesystem::path partial = partial_of(path);
  const FileDescriptor file{
      ::open(partial.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644)};
  if (file.value < 0) return fail("{}: cannot be written: {}", path.string(), std::strerror(errno));
  ::unlink(partial.c_str());
  return {};
}

Expected<void> write_file(const std::filesystem::path& path, std::span<const std::uint8_t> bytes) {
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode)) {
    return write_into(path, bytes);
  }
  if (is_database(path)) return refuse_database(path);
  const std::filesystem::path partial = partial_of(path);
  const auto failed = [&](const char* what) {
    const int error = errno;
    ::unlink(partial.c_str());
    return fail_with(code_of_write_error(error), "{}: {}: {}", path.string(), what,
                     std::strerror(error));
  };
  FileDescriptor file{::open(partial.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644)};
  if (file.value < 0) return failed("cannot be written");
  if (!write_whole(file.value, bytes)) return failed("cannot be written");
  if (::fsync(file.value) != 0) return failed("cannot be flushed to the disk");
  if (::close(std::exchange(file.value, -1)) != 0) return failed("cannot be closed");
  if (::rename(partial.c_str(), path.c_str()) != 0) return failed("cannot be put in place");
  return {};
}

Expected<void> write_file(const std::filesystem::path& path, std::string_view text) {
  return write_file(path,
                    std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
}

std::string sha256_hex(std::span<const std::uint8_t> bytes) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int length = 0;
  EVP_Digest(bytes.data(), bytes.size(), digest.data(), &length, EVP_sha256(), nullptr);
  return hexadecimal(std::span(digest).first(length));
}

}  // namespace roomwise
