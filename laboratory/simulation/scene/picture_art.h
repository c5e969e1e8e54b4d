#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace roomwise::simulation {

// The linear colour of a made-up painting or photograph at u, v in [0, 1] (v upwards): a mountain
// landscape, a seascape at dusk, a forest, coloured fields or circles, by seed.
[[nodiscard]] Eigen::Vector3f picture_color(std::uint64_t seed, float u, float v);

}  // namespace roomwise::simulation
