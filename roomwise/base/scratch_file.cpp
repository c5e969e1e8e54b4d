#include "roomwise/base/scratch_file.h"

#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>

namespace roomwise {

Expected<ScratchFile> ScratchFile::create(const std::filesystem::path& folder) {
  std::string name = (folder / ".roomwise-scratch-XXXXXX").string();
  const int descriptor = mkstemp(name.data());
  if (descriptor < 0) {
    return fail("{}: no scratch file can be made there: {}", folder.string(), std::strerror(errno));
  }
  unlink(name.c_str());
  return ScratchFile(folder, descriptor);
}

ScratchFile::~ScratchFile() {
  if (descriptor_ >= 0) close(descriptor_);
}

Expected<std::uint64_t> ScratchFile::append(std::span<const std::uint8_t> bytes) {
  const std::uint64_t offset = size_;
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t written = pwrite(descriptor_, bytes.data() + done, bytes.size() - done,
                                   static_cast<off_t>(offset + done));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) {
      return fail("{}: the scratch file there cannot be written: {}; make room on that disk",
                  folder_.string(), std::strerror(errno));
    }
    done += static_cast<std::size_t>(written);
  }
  size_ += bytes.size();
  return offset;
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
