#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "roomwise/geometry/pinhole_camera.h"
#include "roomwise/geometry/rigid_transform.h"
#include "roomwise/image/image.h"

namespace roomwise::recording {

// Depth as the colour camera would have measured it, where another camera did. Every measurement is
// moved there as the small rectangle that its pixel covers, so that a finer picture has no holes
// between them; of several that fall on a pixel the nearest counts (z-buffer). What a near thing
// hides from the depth camera stays unknown, but cracks of one pixel within a surface are closed.
class DepthRegistration {
 public:
  // Both cameras measure in color_camera.depth_units_per_metre.
  DepthRegistration(const geometry::PinholeCamera& depth_camera,
                    const geometry::PinholeCamera& color_camera,
                    const geometry::RigidTransform& color_from_depth);

  // The image must have the depth camera's size. O(pixels of both).
  [[nodiscard]] image::DepthImage apply(const image::DepthImage& depth) const;

 private:
  // A row of depth pixels in the colour picture.
  struct MovedRow {
    std::vector<float> x, y, z;  // px, px, units along the colour camera's axis
  };
  void move_row(std::span<const std::uint16_t> depths, std::size_t first, MovedRow& row) const;
  void draw_row(std::span<const std::uint16_t> depths, const MovedRow& row,
                image::DepthImage& registered) const;

  geometry::PinholeCamera color_camera_;
  // Of the depth camera's pixels, of length 1 along its axis, in colour's axes.
  std::vector<float> rays_x_, rays_y_, rays_z_;
  Eigen::Vector3f offset_;      // of the depth camera in the colour camera, units
  Eigen::Vector2f half_pixel_;  // of depth, in the colour picture at the same distance, px
};

}  // namespace roomwise::recording
