#pragma once

#include <Eigen/Core>
#include <optional>

#include "roomwise/geometry/pinhole_camera.h"
#include "roomwise/image/image.h"

namespace roomwise::objects {

// The point that the centre of the picture sees, in the camera frame, m: the paper's place of an
// object. Its distance is the median of what was measured in the central 9x9 pixels; absent where
// less than a quarter of them was measured.
[[nodiscard]] std::optional<Eigen::Vector3d> center_point(const image::DepthImage& depth,
                                                          const geometry::PinholeCamera& camera);

}  // namespace roomwise::objects
