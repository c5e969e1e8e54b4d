#pragma once

#include <Eigen/Core>
#include <span>

#include "roomwise/fusion/gravity_aligned_frame.h"
#include "roomwise/home/home.h"

namespace roomwise::pipeline {

// Fails where somebody gives a place that no camera saw from where walks went: more than 10 m from
// the box around the key-frames of the largest component. It names that box. A home without a map
// has none.
[[nodiscard]] Expected<void> check_near_map(std::span<const home::Keyframe> keyframes,
                                            const fusion::GravityAlignedFrame& frame,
                                            const Eigen::Vector3d& point_plan);

}  // namespace roomwise::pipeline
