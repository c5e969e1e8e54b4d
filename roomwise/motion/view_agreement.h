#pragma once

#include <cmath>

#include "roomwise/geometry/rigid_transform.h"
#include "roomwise/motion/rgbd_pyramid.h"

namespace roomwise::motion {

// How well two views agree at a pose. Shares are of the reference's measured pixels that fall into
// the current image where it measured depth.
struct ViewAgreement {
  double overlap = 0;       // of all measured pixels of the reference, how many those are
  double agreeing = 0;      // both depths are the same surface
  double seen_through = 0;  // the current view looks through the reference's surface
  double in_front = 0;      // the current view has something before it: hidden, or a wrong pose
};

// Compares the depths of the second level. An empty view has nothing in common with any.
[[nodiscard]] ViewAgreement compare_views(const RgbdPyramid& reference, const RgbdPyramid& current,
                                          const geometry::RigidTransform& reference_from_current);

// The level at which views are compared: fine enough, and quick. The view must not be empty.
[[nodiscard]] const PyramidLevel& compared_level(const RgbdPyramid& view);

// Depths at this distance that differ by no more are the same surface.
[[nodiscard]] inline double same_surface_m(double distance_m) {
  return 0.02 + 0.015 * distance_m * distance_m;
}

// A measured pixel of the reference and the pixel of the current view in which its point would be
// seen.
struct Correspondence {
  int x = 0, y = 0;         // of the reference
  Eigen::Vector3d point;    // in the current camera's frame
  int column = 0, row = 0;  // of the current view, not at its border
};

// Calls `take` for all of them; returns how many pixels the reference measured. Pixels at the
// reference's border are left out.
template <typename Take>
std::size_t for_each_correspondence(const PyramidLevel& reference, const PyramidLevel& current,
                                    const geometry::RigidTransform& reference_from_current,
                                    const Take& take) {
  const geometry::RigidTransform current_from_reference = reference_from_current.inverse();
  const geometry::PinholeCamera& camera = current.camera;
  std::size_t measured = 0;
  for (int y = 1; y + 1 < reference.depth.height(); ++y) {
    for (int x = 1; x + 1 < reference.depth.width(); ++x) {
      if (reference.depth.at(x, y) == 0) continue;
      ++measured;
      const Eigen::Vector3d point =
          current_from_reference *
          reference.camera.unproject_undistorted(
              {x, y}, reference.depth.at(x, y) / reference.camera.depth_units_per_metre);
      if (!(point.z() > 0.1)) continue;
      const Eigen::Vector2d pixel = camera.project_undistorted(point);
      const int column = static_cast<int>(std::lround(pixel.x()));
      const int row = static_cast<int>(std::lround(pixel.y()));
      if (column < 1 || row < 1 || column + 1 >= camera.width || row + 1 >= camera.height) continue;
      take(Correspondence{x, y, point, column, row});
    }
  }
  return measured;
}

}  // namespace roomwise::motion
