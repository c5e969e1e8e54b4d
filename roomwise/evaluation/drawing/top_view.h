#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "roomwise/base/expected.h"
#include "roomwise/geometry/point_cloud.h"
#include "roomwise/image/image.h"

namespace roomwise::evaluation {

struct TopViewOptions {
  int longer_side_px = 1200;  // the picture's width
  double cut_above_m = 0.2;   // points higher than that over the cameras (the ceiling) are left out
  double point_size_m = 0.03;     // side of a point's square, somewhat more than the cloud's voxels
  double margin_m = 0.3;          // empty ground around the map
  Rgb8 ground = {242, 242, 239};  // where nothing was measured
  // What lies to the right, level; absent: as geometry::drawing_direction_rad finds it in the
  // cloud.
  std::optional<Eigen::Vector3d> right_world = {};

  [[nodiscard]] Expected<void> validate() const;
};

// A picture of a map from above, and where the map's points lie in it.
struct TopView {
  image::ColorImage picture;
  double pixels_per_metre = 0;
  Eigen::Matrix<double, 2, 3> pixel_from_world_linear = Eigen::Matrix<double, 2, 3>::Zero();
  Eigen::Vector2d pixel_from_world_offset = Eigen::Vector2d::Zero();

  [[nodiscard]] Eigen::Vector2d to_px(const Eigen::Vector3d& point_world) const {
    return pixel_from_world_linear * point_world + pixel_from_world_offset;
  }
};

// Draws the cloud as it is seen from high above (orthographic along `up_world`, unit length), the
// ceiling cut away, turned so that walls run along the picture's sides, the map's longer side lies
// across and the walk begins in the left half. `cameras` are the places of the cameras in the
// world, in the order of the walk; they always lie inside the picture, while single points far from
// all others may fall outside. Fails without points or cameras.
[[nodiscard]] Expected<TopView> render_top_view(const geometry::PointCloud& cloud,
                                                std::span<const Eigen::Vector3d> cameras,
                                                const Eigen::Vector3d& up_world,
                                                const TopViewOptions& options = {});

}  // namespace roomwise::evaluation
