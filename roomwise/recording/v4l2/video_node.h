#pragma once

#include <linux/videodev2.h>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/recording/v4l2/video_kernel.h"

namespace roomwise::recording {

// A device that is open while this lives.
class OpenVideoNode {
 public:
  // Fails, saying the mend, where it is not there, may not be opened, or is in use.
  [[nodiscard]] static Expected<OpenVideoNode> open(std::shared_ptr<VideoKernel> kernel,
                                                    std::string path);
  ~OpenVideoNode();
  OpenVideoNode(OpenVideoNode&& other) noexcept;
  OpenVideoNode& operator=(OpenVideoNode&&) = delete;

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] int descriptor() const { return descriptor_; }
  [[nodiscard]] VideoKernel& kernel() const { return *kernel_; }
  // 0, or minus errno.
  template <typename Argument>
  [[nodiscard]] int ask(unsigned long request, Argument& argument) const {
    return kernel_->ioctl(descriptor_, request, &argument);
  }
  // "/dev/video2: was unplugged", of an errno that a call on it gave.
  [[nodiscard]] Unexpected failed(std::string_view doing, int error) const;

 private:
  OpenVideoNode(std::shared_ptr<VideoKernel> kernel, std::string path, int descriptor)
      : kernel_(std::move(kernel)), path_(std::move(path)), descriptor_(descriptor) {}

  std::shared_ptr<VideoKernel> kernel_;
  std::string path_;
  int descriptor_;
};

// Sizes of pictures, px: one, or all of a range by steps.
struct VideoSizes {
  std::uint32_t min_width = 0, max_width = 0, step_width = 1;
  std::uint32_t min_height = 0, max_height = 0, step_height = 1;

  [[nodiscard]] bool contains(int width, int height) const;
};

struct VideoFormat {
  std::uint32_t pixels = 0;  // V4L2_PIX_FMT_...
  std::vector<VideoSizes> sizes;
};

// What a device says of itself.
struct VideoNode {
  std::string path;
  std::string name;                  // of the camera: "Intel(R) RealSense(TM) Depth Camera 435"
  std::string bus;                   // where it is plugged in: nodes of one camera have the same
  std::vector<VideoFormat> formats;  // none where it gives no pictures

  // The first of `pixels` that it has, whatever the size.
  [[nodiscard]] const VideoFormat* format_of(std::span<const std::uint32_t> pixels) const;
  // The same of pictures of a size.
  [[nodiscard]] std::optional<std::uint32_t> pixels_of_size(std::span<const std::uint32_t> pixels,
                                                            int width, int height) const;
  // "YUYV 640x480, 1280x720; MJPG 1920x1080".
  [[nodiscard]] std::string describe_formats() const;
};

// Fails where OpenVideoNode::open() does, and where the file is no video device.
[[nodiscard]] Expected<VideoNode> look_at_video_node(const std::shared_ptr<VideoKernel>& kernel,
                                                     const std::string& path);

// "YUYV" of V4L2_PIX_FMT_YUYV.
[[nodiscard]] std::string name_of_pixels(std::uint32_t pixels);

}  // namespace roomwise::recording
