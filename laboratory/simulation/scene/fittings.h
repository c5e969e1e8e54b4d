#pragma once

#include <array>
#include <vector>

#include "laboratory/simulation/home/home_model.h"
#include "laboratory/simulation/scene/appearance.h"

namespace roomwise::simulation {

// Triangles whose materials are appearances: TriangleMesh::Triangle::material is an index into
// looks.
struct Fittings {
  TriangleMesh mesh;
  std::vector<Appearance> looks;

  std::uint32_t add_look(Appearance look);
  // A flat piece with corners origin, origin + u, origin + u + v, origin + v; uv runs from 0 to 1
  // along u and v. Its front is where u x v points.
  void add_quad(const Eigen::Vector3f& origin, const Eigen::Vector3f& u, const Eigen::Vector3f& v,
                std::uint32_t look);
  // A flat piece with these corners in turn, whose front is on the side of `front`.
  void add_slope(const std::array<Eigen::Vector3f, 4>& corners, const Eigen::Vector3f& front,
                 std::uint32_t look);
  // The box spanned by three edges at right angles, seen from outside.
  void add_box(const Eigen::Vector3f& origin, const Eigen::Vector3f& u, const Eigen::Vector3f& v,
               const Eigen::Vector3f& w, std::uint32_t look);
};

// Everything of a home that is built in but its floors, walls and ceilings: door frames and leaves,
// windows with sills and curtains, skirting boards, pictures, ceiling panels.
[[nodiscard]] Fittings make_fittings(const HomeModel& home);

}  // namespace roomwise::simulation
