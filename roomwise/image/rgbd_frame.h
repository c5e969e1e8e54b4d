#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "roomwise/base/file.h"
#include "roomwise/base/timestamp.h"
#include "roomwise/geometry/device_motion.h"
#include "roomwise/geometry/pinhole_camera.h"
#include "roomwise/image/image.h"

namespace roomwise::image {

// A depth image that a device took between two pictures, shortly after a frame.
struct DepthView {
  TimestampNs timestamp_ns = 0;
  geometry::RigidTransform frame_from_view;  // of the camera frames, as the device felt its motion
  Bytes encoded_depth;                       // 16-bit PNG of the frame's size
};

// One moment of an RGB-D camera: a colour image and a depth image registered to it, of one size.
struct RgbdFrame {
  // The colour image's place in the recording's list (line of rgb.txt without comments), from 0. A
  // frame that the source had to leave out leaves a gap, so that labels by number stay true.
  std::uint64_t index = 0;
  TimestampNs timestamp_ns = 0;  // of the colour image
  ColorImage color;
  DepthImage depth;
  // The images as the camera or the recording gave them (JPEG or PNG; 16-bit PNG), kept so that
  // storing a frame loses nothing. Empty where the source gave raw pixels.
  Bytes encoded_color;
  Bytes encoded_depth;
  std::optional<geometry::DeviceMotion> device_motion = std::nullopt;  // where the device tells it
  std::vector<DepthView> depth_views = {};  // before the next picture, in the order of time
};

// The measured distance along the optical axis at a pixel, m; 0 where nothing was measured.
[[nodiscard]] inline double depth_m(const DepthImage& depth, const geometry::PinholeCamera& camera,
                                    int x, int y) {
  return depth.at(x, y) / camera.depth_units_per_metre;
}

}  // namespace roomwise::image
