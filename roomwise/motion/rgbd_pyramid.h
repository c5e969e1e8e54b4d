#pragma once

#include <vector>

#include "roomwise/geometry/pinhole_camera.h"
#include "roomwise/image/image.h"

namespace roomwise::motion {

// An RGB-D image without lens distortion: brightness, and depth in mm (0: not measured, or near and
// far mixed).
struct PyramidLevel {
  geometry::PinholeCamera camera;
  image::GrayImage gray;
  image::DepthImage depth;
};

// An RGB-D frame made small, as an ideal camera sees it: what frames are compared by as wholes,
// where single features say too little.
struct RgbdPyramid {
  std::vector<PyramidLevel> levels;  // each half as large as the one before

  [[nodiscard]] bool empty() const { return levels.empty(); }
  // Whether depth was measured in that share of the smallest level's pixels.
  [[nodiscard]] bool has_depth(double min_share) const;
};

struct RgbdPyramidOptions {
  int shrink = 4;  // full size over that of the first level
  int levels = 3;
  double farthest_m = 7.0;  // depth beyond this is left out

  [[nodiscard]] Expected<void> validate() const;
};

// Brightness is the mean of the pixels that a small pixel covers, depth the mean of those near
// their median. The images must be of the camera's size.
[[nodiscard]] RgbdPyramid make_rgbd_pyramid(const image::GrayImage& gray,
                                            const image::DepthImage& depth,
                                            const geometry::PinholeCamera& camera,
                                            const RgbdPyramidOptions& options = {});

}  // namespace roomwise::motion
