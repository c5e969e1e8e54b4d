#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace roomwise::simulation {

// Cuts a polygon into triangles that together cover it, as indices of its corners in its own
// direction. It may be concave, need not be quite flat, and may touch itself: a hole is often drawn
// by a cut that leads to it and back.
[[nodiscard]] std::vector<std::array<std::size_t, 3>> triangulate(
    std::span<const Eigen::Vector3f> polygon);

}  // namespace roomwise::simulation
