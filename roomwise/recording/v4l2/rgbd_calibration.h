#pragma once

#include <filesystem>
#include <optional>

#include "roomwise/base/expected.h"
#include "roomwise/geometry/pinhole_camera.h"
#include "roomwise/geometry/rigid_transform.h"

namespace roomwise::recording {

// A colour camera and the depth camera beside it.
struct RgbdCalibration {
  geometry::PinholeCamera color;
  std::optional<geometry::PinholeCamera> depth;  // absent where depth is registered to colour
  geometry::RigidTransform color_from_depth;
};

// A text file of lines that begin with a name; '#' begins a comment:
//   color fx fy cx cy width height [k1 k2 p1 p2 k3]    px
//   depth fx fy cx cy width height [k1 k2 p1 p2 k3]
//   depth_units_per_metre 1000
//   color_from_depth r11 r12 r13 x  r21 r22 r23 y  r31 r32 r33 z    m: points of the depth camera
//                                                                   to those of the colour camera
// depth and color_from_depth stand there both, or neither where the camera gives depth that is
// registered to colour. Fails, naming file and line, where something is missing, twice there, no
// number or impossible.
[[nodiscard]] Expected<RgbdCalibration> read_rgbd_calibration(const std::filesystem::path& path);

}  // namespace roomwise::recording
