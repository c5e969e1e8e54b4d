#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace roomwise::fusion {

// A cube's corner i lies at (i & 1, i >> 1 & 1, i >> 2 & 1).
constexpr int kCubeCorners = 8;
constexpr int kCubeEdges = 12;
struct CubeEdge {
  int from, to;  // corners; `to` lies further along the axis
  int axis;
};
[[nodiscard]] const std::array<CubeEdge, kCubeEdges>& cube_edges();

// Which edges of a cube the triangles of a surface join, for each of the 256 ways in which its
// corners can lie inside (bit i: corner i lies behind the surface). Seen from the open side the
// edges of a triangle go round anticlockwise.
//
// After Lorensen and Cline, "Marching Cubes: A High Resolution 3D Surface Construction Algorithm",
// 1987, but worked out rather than tabulated: on each face the surface runs between the crossed
// edges so that corners inside that lie across from each other stay apart; the lines of all faces
// close to rings, and each ring is cut into triangles. What happens on a face depends on its four
// corners alone, so neighbouring cubes agree and the surface has no holes.
using CubeTriangles = std::vector<std::array<std::uint8_t, 3>>;
[[nodiscard]] const std::array<CubeTriangles, 256>& cube_triangles();

}  // namespace roomwise::fusion
