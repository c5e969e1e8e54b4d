#include "roomwise/recording/v4l2/video_kernel.h"

#include <fcntl.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <filesystem>

#include "roomwise/recording/phone/numbered_files.h"

namespace roomwise::recording {
namespace {

class LinuxVideoKernel final : public VideoKernel {
 public:
  std::vector<std::string> devices() override {
    std::vector<std::string> paths;
    const auto files = numbered_files("/dev", "video", "");
    if (!files) return paths;
    for (const auto& [number, path] : *files) paths.push_back(path.string());
    return paths;
  }
  int open(const std::string& path) override {
    const int descriptor = ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
    return descriptor < 0 ? -errno : descriptor;
  }
  void close(int descriptor) override { ::close(descriptor); }
  int ioctl(int descriptor, unsigned long request, void* argument) override {
    for (;;) {
      const int answer = ::ioctl(descriptor, request, argument);
      if (answer >= 0) return answer;
      if (errno != EINTR) return -errno;
    }
  }
  const std::uint8_t* mmap(int descriptor, std::size_t size, std::uint32_t offset) override {
    // Drivers want memory for writing too, though nothing is written here.
    void* const memory = ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor,
                                static_cast<off_t>(offset));
    return memory == MAP_FAILED ? nullptr : static_cast<const std::uint8_t*>(memory);
  }
  void munmap(const std::uint8_t* memory, std::size_t size) override {
    ::munmap(const_cast<std::uint8_t*>(memory), size);
  }
  int poll(std::span<pollfd> waiting, int timeout_ms) override {
    const int ready = ::poll(waiting.data(), waiting.size(), timeout_ms);
    if (ready >= 0) return ready;
    return errno == EINTR ? 0 : -errno;
  }
  TimestampNs now_ns() override {
    return std::chrono::duration_cast<std::chrono::nanoseconds>(
               std::chrono::steady_clock::now().time_since_epoch())
        .count();
  }
};

}  // namespace

std::shared_ptr<VideoKernel> linux_video_kernel() {
  return std::make_shared<LinuxVideoKernel>();
}

}  // namespace roomwise::recording
