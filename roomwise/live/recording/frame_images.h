#pragma once

#include <optional>

#include "roomwise/image/image.h"
#include "roomwise/service/protocol/messages.h"

namespace roomwise::live {

// A frame as it came, whole.
struct CameraFrame {
  double t_ms = 0;
  Bytes color;  // JPEG, PNG or WebP
  Bytes depth;  // 16-bit PNG, or empty
  // What version 2 of its header told (service::FrameMessage).
  std::optional<geometry::PinholeCamera> camera = std::nullopt;
  std::optional<service::ImageSize> depth_size = std::nullopt;
  std::optional<service::FramePose> pose = std::nullopt;
  double came_s = 0;  // when it came, by the computer's steady clock
};

// A frame's images as the camera of the device's hello takes them: of its size and intrinsics.
struct FrameImages {
  image::ColorImage color;
  std::optional<image::DepthImage> depth;  // in the camera's units
  // Whether they are the frame's own, pixel by pixel.
  bool color_is_as_sent = true, depth_is_as_sent = true;
};

// Reads the frame's images and, where the frame told of its own camera or of a depth image of
// another size, brings them to the hello's camera. Fails on images that cannot be read, that are
// not of the size that was told, and on depth from a camera without.
[[nodiscard]] Expected<FrameImages> images_of(const CameraFrame& frame,
                                              const service::DeviceCamera& camera);

}  // namespace roomwise::live
