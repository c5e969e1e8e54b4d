#pragma once

#include <Eigen/Core>
#include <vector>

#include "roomwise/geometry/pinhole_camera.h"
#include "roomwise/geometry/point_cloud.h"
#include "roomwise/image/image.h"

namespace roomwise::mapping {

struct FrameCloudOptions {
  int pixel_step = 2;       // takes every so many pixels, across and down
  double farthest_m = 4.5;  // a structured-light camera measures too coarsely beyond
};

// Makes the coloured points that RGB-D frames of one camera see, in the camera frame, m. The rays
// of the pixels, the lens distortion taken out, are computed once.
class FrameCloudMaker {
 public:
  explicit FrameCloudMaker(const geometry::PinholeCamera& camera,
                           const FrameCloudOptions& options = {});

  // Both images must have the camera's size.
  [[nodiscard]] geometry::PointCloud make(const image::ColorImage& color,
                                          const image::DepthImage& depth) const;

 private:
  geometry::PinholeCamera camera_;
  FrameCloudOptions options_;
  std::vector<Eigen::Vector3f> rays_;  // z = 1; a row after the other, every pixel_step pixels
};

}  // namespace roomwise::mapping
