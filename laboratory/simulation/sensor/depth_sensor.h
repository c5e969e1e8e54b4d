#pragma once

#include <Eigen/Core>

#include "laboratory/simulation/sensor/sensor.h"
#include "roomwise/base/thread_pool.h"

namespace roomwise::simulation {

// The depth image that a structured-light sensor measures of a frame. rays: of every pixel, at
// depth 1.
[[nodiscard]] image::DepthImage measure_depth(const RenderedFrame& frame,
                                              const geometry::PinholeCamera& camera,
                                              const image::Image<Eigen::Vector2f>& rays,
                                              const SensorOptions& options, std::uint64_t index,
                                              ThreadPool& pool);

}  // namespace roomwise::simulation
