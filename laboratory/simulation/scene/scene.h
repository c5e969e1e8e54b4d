#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "laboratory/simulation/home/home_model.h"
#include "laboratory/simulation/scene/appearance.h"
#include "laboratory/simulation/scene/outside.h"
#include "laboratory/simulation/scene/ray_caster.h"
#include "roomwise/base/expected.h"

namespace roomwise::simulation {

// A floor, a ceiling or a room's wall: a rectangle whose light is kept in a grid of texels.
struct Patch {
  Eigen::Vector3f origin, along, up;  // a corner and two unit vectors
  Eigen::Vector3f normal;             // into the room
  float width_m = 0, height_m = 0;    // along `along` and `up`
  std::uint32_t appearance = 0;
  int columns = 1, rows = 1;
  std::size_t first_texel = 0;
  std::vector<bool> is_hole = {};  // a texel a place; true: in an opening

  [[nodiscard]] Eigen::Vector3f texel_center(int column, int row) const;
  // Among the texels of all patches.
  [[nodiscard]] std::size_t texel_index(int column, int row) const {
    return first_texel + static_cast<std::size_t>(row * columns + column);
  }
  [[nodiscard]] float texel_width_m() const { return width_m / static_cast<float>(columns); }
  [[nodiscard]] float texel_height_m() const { return height_m / static_cast<float>(rows); }
};

struct SceneTriangle {
  std::array<std::uint32_t, 3> corners;
  std::uint32_t appearance = 0;
  std::int32_t patch = -1;   // index into patches; -1: light is kept at the corners
  std::uint16_t object = 0;  // 1 + index into HomeModel::objects; 0: none
  Eigen::Vector3f normal;    // of the plane, unit length
  float uv_per_m = 0;        // how fast texture coordinates change along it
};

// A home as triangles with their looks.
class Scene {
 public:
  // `meshes` are the models of home.objects in their order, in the object frame.
  [[nodiscard]] static Expected<Scene> build(
      const HomeModel& home, std::span<const std::shared_ptr<const TriangleMesh>> meshes);

  [[nodiscard]] const std::vector<Eigen::Vector3f>& positions() const { return positions_; }
  [[nodiscard]] const std::vector<Eigen::Vector3f>& normals() const { return normals_; }
  [[nodiscard]] const std::vector<SceneTriangle>& triangles() const { return triangles_; }
  [[nodiscard]] const std::vector<Appearance>& appearances() const { return appearances_; }
  [[nodiscard]] const std::vector<Patch>& patches() const { return patches_; }
  [[nodiscard]] std::size_t texel_count() const { return texel_count_; }
  [[nodiscard]] const RayCaster& rays() const { return *rays_; }
  [[nodiscard]] const Outside& outside() const { return outside_; }
  // Triangles from here on let light through.
  [[nodiscard]] std::size_t opaque_count() const { return opaque_count_; }

  // Where the triangle's corners lie for texture, at the hit's weights.
  [[nodiscard]] Eigen::Vector2f uv_at(const RayHit& hit) const;
  // The shading normal, on the side that `direction` comes from.
  [[nodiscard]] Eigen::Vector3f normal_at(const RayHit& hit,
                                          const Eigen::Vector3f& direction) const;
  [[nodiscard]] bool is_front(const RayHit& hit, const Eigen::Vector3f& direction) const {
    return triangles_[hit.triangle].normal.dot(direction) <= 0;
  }
  // `footprint_m`: the width on the surface that one sample stands for.
  [[nodiscard]] SurfaceLook look_at(const RayHit& hit, const Eigen::Vector3f& point,
                                    float footprint_m) const;

 private:
  explicit Scene(const HomeModel& home) : outside_(home) {}
  void add_shell(const HomeModel& home);
  void add_patch(Patch patch, std::span<const std::array<float, 4>> holes);
  void add_mesh(const TriangleMesh& mesh, std::uint32_t first_appearance, std::uint16_t object,
                const geometry::RigidTransform& world_from_mesh);
  void finish_triangles();

  std::vector<Eigen::Vector3f> positions_, normals_;
  std::vector<Eigen::Vector2f> uvs_;
  std::vector<SceneTriangle> triangles_;  // opaque ones first
  std::vector<Appearance> appearances_;
  std::vector<Patch> patches_;
  std::size_t texel_count_ = 0, opaque_count_ = 0;
  Outside outside_;
  std::unique_ptr<RayCaster> rays_;
};

}  // namespace roomwise::simulation
