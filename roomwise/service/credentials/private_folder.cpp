#include "roomwise/service/credentials/private_folder.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace roomwise::service {

Expected<void> make_private_folder(const std::filesystem::path& folder) {
  if (::mkdir(folder.c_str(), 0700) != 0 && errno != EEXIST) {
    return fail("{}: cannot be made: {}", folder.string(),
                std::error_code(errno, std::generic_category()).message());
  }
  struct stat status {};
  if (::lstat(folder.c_str(), &status) != 0 || !S_ISDIR(status.st_mode)) {
    return fail("{}: is no folder; move it away", folder.string());
  }
  if ((status.st_mode & 0077U) != 0 || status.st_uid != ::geteuid()) {
    return fail("{}: others may read it, and it holds keys; make it private: chmod -R go= {}",
                folder.string(), folder.string());
  }
  return {};
}

}  // namespace roomwise::service
