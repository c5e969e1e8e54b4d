#pragma once

#include <poll.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "roomwise/base/timestamp.h"

namespace roomwise::recording {

// What a live camera asks of Linux; a test puts a made-up driver in its place. Each call is the
// system call of its name and answers what that answers, or minus errno where it fails.
class VideoKernel {
 public:
  virtual ~VideoKernel() = default;

  // The paths of the video devices (/dev/video0), by their numbers.
  [[nodiscard]] virtual std::vector<std::string> devices() = 0;
  // For reading and writing, never waiting: the descriptor.
  [[nodiscard]] virtual int open(const std::string& path) = 0;
  virtual void close(int descriptor) = 0;
  // Begun again where a signal interrupts it.
  [[nodiscard]] virtual int ioctl(int descriptor, unsigned long request, void* argument) = 0;
  // Shared with the driver, to be read; null where it fails.
  [[nodiscard]] virtual const std::uint8_t* mmap(int descriptor, std::size_t size,
                                                 std::uint32_t offset) = 0;
  virtual void munmap(const std::uint8_t* memory, std::size_t size) = 0;
  // How many are ready. 0 also where a signal interrupts it.
  [[nodiscard]] virtual int poll(std::span<pollfd> waiting, int timeout_ms) = 0;
  // The clock of the drivers' time stamps (CLOCK_MONOTONIC).
  [[nodiscard]] virtual TimestampNs now_ns() = 0;
};

[[nodiscard]] std::shared_ptr<VideoKernel> linux_video_kernel();

}  // namespace roomwise::recording
