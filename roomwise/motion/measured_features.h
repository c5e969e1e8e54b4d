#pragma once

#include <Eigen/Core>
#include <vector>

#include "roomwise/features/feature_extractor.h"
#include "roomwise/geometry/pinhole_camera.h"
#include "roomwise/image/image.h"

namespace roomwise::motion {

// The features of one RGB-D frame and what its depth image says of each.
struct MeasuredFeatures {
  features::Features features;
  std::vector<Eigen::Vector2d> pixels;  // of each key-point, the lens distortion taken out
  std::vector<Eigen::Vector3d> points;  // of each key-point in the camera frame, m; z = 0: no depth

  [[nodiscard]] std::size_t size() const { return features.size(); }
  [[nodiscard]] bool has_point(std::size_t i) const { return points[i].z() > 0; }
};

struct DepthRange {
  // Beyond this a structured-light camera's error (it grows with the square of the distance)
  // outweighs what a point tells of the motion, m.
  double farthest_m = 7.0;
  // Around a key-point the depths may differ by this part of the distance; more is the edge of a
  // thing, where depth and colour do not belong together.
  double max_relative_spread = 0.05;

  [[nodiscard]] Expected<void> validate() const;
};

// Depth at a key-point is the median of the measured pixels among the 3x3 around it.
[[nodiscard]] MeasuredFeatures measure_features(features::Features features,
                                                const image::DepthImage& depth,
                                                const geometry::PinholeCamera& camera,
                                                const DepthRange& range = {});

}  // namespace roomwise::motion
