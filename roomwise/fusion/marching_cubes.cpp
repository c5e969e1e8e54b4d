#include "roomwise/fusion/marching_cubes.h"

namespace roomwise::fusion {
namespace {

constexpr int kNoEdge = -1;

std::array<CubeEdge, kCubeEdges> make_edges() {
  std::array<CubeEdge, kCubeEdges> edges{};
  std::size_t count = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (int corner = 0; corner < kCubeCorners; ++corner) {
      if ((corner >> axis & 1) == 0) edges[count++] = {corner, corner | 1 << axis, axis};
    }
  }
  return edges;
}

int edge_between(int a, int b) {
  const auto& edges = cube_edges();
  for (int i = 0; i < kCubeEdges; ++i) {
    const CubeEdge& edge = edges[static_cast<std::size_t>(i)];
    if ((edge.from == a && edge.to == b) || (edge.from == b && edge.to == a)) return i;
  }
  return kNoEdge;
}

// A face's corners, anticlockwise as seen from outside the cube.
using Face = std::array<int, 4>;
std::array<Face, 6> make_faces() {
  std::array<Face, 6> faces{};
  std::size_t count = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const int u = 1 << (axis + 1) % 3, v = 1 << (axis + 2) % 3, far = 1 << axis;
    faces[count++] = {far, far | u, far | u | v, far | v};
    faces[count++] = {0, v, u | v, u};
  }
  return faces;
}

// Where the surface's line goes on each face: next[edge] is the edge that follows it round a ring.
// Each line cuts a run of inside corners off: it comes in by the edge before the run's first corner
// and leaves by that behind its last, so that the open side lies to its left as seen from outside
// the cube, and the ring goes round anticlockwise as seen from the open side.
std::array<int, kCubeEdges> lines_on_faces(int inside) {
  std::array<int, kCubeEdges> next{};
  next.fill(kNoEdge);
  for (const Face& face : make_faces()) {
    const auto is_inside = [&](std::size_t i) { return (inside >> face[i % 4] & 1) != 0; };
    for (std::size_t first = 0; first < 4; ++first) {
      if (!is_inside(first) || is_inside(first + 3)) continue;
      std::size_t last = first;
      while (is_inside(last + 1)) ++last;
      const int enters = edge_between(face[(first + 3) % 4], face[first]);
      const int leaves = edge_between(face[last % 4], face[(last + 1) % 4]);
      next[static_cast<std::size_t>(enters)] = leaves;
    }
  }
  return next;
}

CubeTriangles triangles_of(int inside) {
  CubeTriangles triangles;
  std::array<int, kCubeEdges> next = lines_on_faces(inside);
  for (std::size_t start = 0; start < kCubeEdges; ++start) {
    std::vector<std::uint8_t> ring;
    for (std::size_t edge = start; next[edge] != kNoEdge;) {
      ring.push_back(static_cast<std::uint8_t>(edge));
      const auto following = static_cast<std::size_t>(next[edge]);
      next[edge] = kNoEdge;
      edge = following;
    }
    for (std::size_t i = 2; i < ring.size(); ++i) {
      triangles.push_back({ring[0], ring[i - 1], ring[i]});
    }
  }
  return triangles;
}

}  // namespace

const std::array<CubeEdge, kCubeEdges>& cube_edges() {
  static const std::array<CubeEdge, kCubeEdges> kEdges = make_edges();
  return kEdges;
}

const std::array<CubeTriangles, 256>& cube_triangles() {
  static const std::array<CubeTriangles, 256> kTriangles = [] {
    std::array<CubeTriangles, 256> all;
    for (int inside = 0; inside < 256; ++inside) {
      all[static_cast<std::size_t>(inside)] = triangles_of(inside);
    }
    return all;
  }();
  return kTriangles;
}

}  // namespace roomwise::fusion
