#include "laboratory/simulation/furniture/tessellation.h"

#include <optional>
#include <unordered_map>

namespace roomwise::simulation {
namespace {

class EdgeSplitter {
 public:
  EdgeSplitter(TriangleMesh& mesh, float longest_edge_m, float longest_level_edge_m)
      : mesh_(mesh), longest_edge_m_(longest_edge_m), longest_level_edge_m_(longest_level_edge_m) {}

  // The vertex in the middle of an edge that is too long.
  std::optional<std::uint32_t> middle(std::uint32_t a, std::uint32_t b) {
    if (a > b) std::swap(a, b);
    const bool is_level = mesh_.normals[a].z() > 0.9F && mesh_.normals[b].z() > 0.9F;
    const float longest = is_level ? longest_level_edge_m_ : longest_edge_m_;
    if ((mesh_.positions[a] - mesh_.positions[b]).norm() <= longest) return std::nullopt;
    const std::uint64_t key = (std::uint64_t{a} << 32) | b;
    const auto next = static_cast<std::uint32_t>(mesh_.positions.size());
    const auto [entry, is_new] = middles_.try_emplace(key, next);
    if (is_new) add_between(a, b);
    return entry->second;
  }

 private:
  void add_between(std::uint32_t a, std::uint32_t b) {
    const Eigen::Vector3f normal = mesh_.normals[a] + mesh_.normals[b];
    const bool is_opposed = normal.norm() < 1e-3F;
    const Eigen::Vector3f position = (mesh_.positions[a] + mesh_.positions[b]) / 2;
    const Eigen::Vector3f middle_normal = is_opposed ? mesh_.normals[a] : normal.normalized();
    const Eigen::Vector2f uv = (mesh_.texture_coordinates[a] + mesh_.texture_coordinates[b]) / 2;
    mesh_.positions.push_back(position);
    mesh_.normals.push_back(middle_normal);
    mesh_.texture_coordinates.push_back(uv);
  }

  TriangleMesh& mesh_;
  float longest_edge_m_, longest_level_edge_m_;
  std::unordered_map<std::uint64_t, std::uint32_t> middles_;
};

}  // namespace

TriangleMesh tessellate(TriangleMesh mesh, float longest_edge_m, float longest_level_edge_m) {
  EdgeSplitter splitter(mesh, longest_edge_m, longest_level_edge_m);
  std::vector<TriangleMesh::Triangle> open = std::move(mesh.triangles);
  std::vector<TriangleMesh::Triangle> done;
  while (!open.empty()) {
    std::vector<TriangleMesh::Triangle> next;
    for (const TriangleMesh::Triangle& triangle : open) {
      const auto [a, b, c] = triangle.corners;
      const auto ab = splitter.middle(a, b), bc = splitter.middle(b, c), ca = splitter.middle(c, a);
      const auto add = [&](std::uint32_t p, std::uint32_t q, std::uint32_t r) {
        next.push_back({{p, q, r}, triangle.material});
      };
      if (!ab && !bc && !ca) {
        done.push_back(triangle);
      } else if (ab && bc && ca) {
        add(a, *ab, *ca), add(*ab, b, *bc), add(*ca, *bc, c), add(*ab, *bc, *ca);
      } else if (ab && bc) {
        add(*ab, b, *bc), add(a, *ab, *bc), add(a, *bc, c);
      } else if (bc && ca) {
        add(*bc, c, *ca), add(b, *bc, *ca), add(b, *ca, a);
      } else if (ca && ab) {
        add(*ca, a, *ab), add(c, *ca, *ab), add(c, *ab, b);
      } else if (ab) {
        add(a, *ab, c), add(*ab, b, c);
      } else if (bc) {
        add(b, *bc, a), add(*bc, c, a);
      } else {
        add(c, *ca, b), add(*ca, a, b);
      }
    }
    open = std::move(next);
  }
  mesh.triangles = std::move(done);
  return mesh;
}

}  // namespace roomwise::simulation
