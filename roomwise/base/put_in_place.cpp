#include "roomwise/base/put_in_place.h"

#include <fcntl.h>
#include <stdio.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "roomwise/base/file_descriptor.h"

namespace roomwise {

Expected<void> put_in_place(const std::filesystem::path& from, const std::filesystem::path& to) {
  if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) != 0) {
    if (errno == EEXIST) return fail("{}: exists already; choose another name", to.string());
    return fail("{}: cannot be put in place: {}", to.string(), std::strerror(errno));
  }
  const std::filesystem::path folder = std::filesystem::absolute(to).parent_path();
  const FileDescriptor descriptor{::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)};
  if (descriptor.value < 0 || ::fsync(descriptor.value) != 0) {
    return fail("{}: cannot be flushed to the disk: {}", folder.string(), std::strerror(errno));
  }
  return {};
}

}  // namespace roomwise
