#include "roomwise/home/writer_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace roomwise::home {
namespace {

// Whether the path still names the file that is open: its last owner may have removed it between
// our open() and our flock().
bool names(const std::filesystem::path& path, int descriptor) {
  struct stat by_path {};
  struct stat by_descriptor {};
  return ::stat(path.c_str(), &by_path) == 0 && ::fstat(descriptor, &by_descriptor) == 0 &&
         by_path.st_ino == by_descriptor.st_ino && by_path.st_dev == by_descriptor.st_dev;
}

}  // namespace

Expected<WriterLock> WriterLock::take(const std::filesystem::path& path) {
  std::filesystem::path lock_path = path;
  lock_path += "-lock";
  for (;;) {
    const int descriptor = ::open(lock_path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    if (descriptor < 0) {
      return fail("{}: cannot be written: {} ({}); to write a home, its folder must be writable",
                  path.string(), std::strerror(errno), lock_path.string());
    }
    WriterLock lock(lock_path, descriptor);
    if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
      const int error = errno;
      ::close(std::exchange(lock.descriptor_, -1));
      if (error == EINTR) continue;
      if (error == EWOULDBLOCK) {
        return fail_with(ErrorCode::kRefused,
                         "{}: in use by another process that writes it; end that one and try again",
                         path.string());
      }
      return fail("{}: cannot be locked: {}", lock_path.string(), std::strerror(error));
    }
    if (names(lock_path, descriptor)) return lock;
    ::close(std::exchange(lock.descriptor_, -1));
  }
}

WriterLock::WriterLock(WriterLock&& other) noexcept
    : lock_path_(std::move(other.lock_path_)), descriptor_(std::exchange(other.descriptor_, -1)) {}

WriterLock::~WriterLock() {
  if (descriptor_ < 0) return;
  ::unlink(lock_path_.c_str());
  ::close(descriptor_);
}

}  // namespace roomwise::home
