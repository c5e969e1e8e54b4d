#include "roomwise/base/scratch_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>

namespace roomwise {

Expected<ScratchFile> ScratchFile::create(const std::filesystem::path& folder) {
  // Without a name from the start, where the file system can do that.
  int descriptor = open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (descriptor < 0 && (errno == EOPNOTSUPP || errno == EISDIR || errno == EINVAL)) {
    std::string name = (folder / ".roomwise-scratch-XXXXXX").string();
    descriptor = mkostemp(name.data(), O_CLOEXEC);
    if (descriptor >= 0 && unlink(name.c_str()) != 0) {
      const int why = errno;
      close(descriptor);
      return fail("{}: cannot be removed: {}", name, std::strerror(why));
    }
  }
  if (descriptor < 0) {
    return fail("{}: no scratch file can be made there: {}", folder.string(), std::strerror(errno));
  }
  return ScratchFile(folder, descriptor);
}

ScratchFile::~ScratchFile() {
  if (descriptor_ >= 0) close(descriptor_);
}

Expected<std::uint64_t> ScratchFile::append(std::span<const std::uint8_t> bytes) {
  const std::uint64_t offset = size_;
  ROOMWISE_RETURN_IF_ERROR(overwrite(offset, bytes));
  size_ += bytes.size();
  return offset;
}

Expected<void> ScratchFile::overwrite(std::uint64_t offset, std::span<const std::uint8_t> bytes) {
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t written = pwrite(descriptor_, bytes.data() + done, bytes.size() - done,
                                   static_cast<off_t>(offset + done));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) {
      return fail_with(code_of_write_error(errno),
                       "{}: the scratch file there cannot be written: {}; make room on that disk",
                       folder_.string(), std::strerror(errno));
    }
    done += static_cast<std::size_t>(written);
  }
  return {};
}

Expected<Bytes> ScratchFile::read(std::uint64_t offset, std::size_t size) const {
  Bytes bytes(size);
  for (std::size_t done = 0; done < size;) {
    const ssize_t count =
        pread(descriptor_, bytes.data() + done, size - done, static_cast<off_t>(offset + done));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) {
      return fail("{}: the scratch file there cannot be read at {}: {}", folder_.string(),
                  offset + done, count == 0 ? "it ends before" : std::strerror(errno));
    }
    done += static_cast<std::size_t>(count);
  }
  return bytes;
}

}  // namespace roomwise
