#include "roomwise/service/credentials/private_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "roomwise/base/file.h"
#include "roomwise/base/file_descriptor.h"

namespace roomwise::service {

Expected<void> write_private_file(const std::filesystem::path& path, std::string_view text) {
  const std::filesystem::path part = path.string() + ".part";
  ::unlink(part.c_str());  // an old one may have other rights
  const FileDescriptor file(::open(part.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600));
  const std::span bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  const bool written =
      file.value >= 0 && write_whole(file.value, bytes) && ::fsync(file.value) == 0;
  if (!written || ::rename(part.c_str(), path.c_str()) != 0) {
    return fail_with(code_of_write_error(errno), "{}: cannot be written: {}", path.string(),
                     std::strerror(errno));
  }
  return {};
}

}  // namespace roomwise::service
