#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "roomwise/base/color.h"

namespace roomwise::fusion {

// A surface of triangles that share their vertices, metres. A vertex has a normal (unit length,
// towards the open space) and a colour; seen from the open side a triangle's corners go round
// anticlockwise.
struct TriangleMesh {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<Eigen::Vector3f> normals;
  std::vector<Rgb8> colors;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

}  // namespace roomwise::fusion
