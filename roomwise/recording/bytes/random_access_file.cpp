#include "roomwise/recording/bytes/random_access_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace roomwise::recording {

Expected<RandomAccessFile> RandomAccessFile::open(const std::filesystem::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) return fail("{}: cannot be read: {}", path.string(), std::strerror(errno));
  RandomAccessFile file(path, descriptor, 0);
  struct stat about {};
  if (::fstat(descriptor, &about) != 0 || !S_ISREG(about.st_mode)) {
    return fail("{}: is no regular file; give the file of a recording", path.string());
  }
  file.size_ = static_cast<std::uint64_t>(about.st_size);
  return file;
}

RandomAccessFile::~RandomAccessFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Expected<Bytes> RandomAccessFile::read(std::uint64_t offset, std::uint64_t size) const {
  if (!holds(offset, size)) {
    return fail("{}: ends at byte {}, within a part of {} bytes from byte {}; it was cut off",
                path_.string(), size_, size, offset);
  }
  Bytes bytes(static_cast<std::size_t>(size));
  ROOMWISE_RETURN_IF_ERROR(read(offset, std::span<std::uint8_t>(bytes)));
  return bytes;
}

Expected<void> RandomAccessFile::read(std::uint64_t offset, std::span<std::uint8_t> into) const {
  while (!into.empty()) {
    const ssize_t count =
        ::pread(descriptor_, into.data(), into.size(), static_cast<off_t>(offset));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return fail("{}: cannot be read: {}", path_.string(), std::strerror(errno));
    if (count == 0) return fail("{}: ends at byte {}; it was cut off", path_.string(), offset);
    into = into.subspan(static_cast<std::size_t>(count));
    offset += static_cast<std::uint64_t>(count);
  }
  return {};
}

}  // namespace roomwise::recording
