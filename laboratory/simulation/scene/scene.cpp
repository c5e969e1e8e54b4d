#include "laboratory/simulation/scene/scene.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "laboratory/simulation/furniture/tessellation.h"
#include "laboratory/simulation/home/openings.h"
#include "laboratory/simulation/scene/fittings.h"
#include "laboratory/simulation/scene/stair_fittings.h"

namespace roomwise::simulation {
namespace {

constexpr float kTexel = 0.05F;  // m
// Floors, walls and ceilings reach this far beyond their edges, into each other, so that no ray
// finds a crack between them.
constexpr float kOverlap = 0.01F;
constexpr float kLongestEdge = 0.12F, kLongestLevelEdge = 0.06F;

int texels_along(float length_m) {
  return std::max(1, static_cast<int>(std::ceil(length_m / kTexel)));
}

// All the models of a home share their textures' smaller copies.
class TextureStore {
 public:
  std::shared_ptr<const MipTexture> find(const SurfaceMaterial& material) {
    if (!material.texture) return nullptr;
    auto& texture = textures_[material.texture.get()];
    if (!texture) texture = std::make_shared<const MipTexture>(*material.texture);
    return texture;
  }

 private:
  std::map<const image::ColorImage*, std::shared_ptr<const MipTexture>> textures_;
};

void sort_unique(std::vector<float>& values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

Expected<void> check_mesh(const TriangleMesh& mesh, const PlacedObject& object) {
  const std::size_t corners = mesh.positions.size();
  if (mesh.normals.size() != corners || mesh.texture_coordinates.size() != corners) {
    return fail("model '{}' of '{}' has {} positions, {} normals and {} texture coordinates",
                object.model, object.name, corners, mesh.normals.size(),
                mesh.texture_coordinates.size());
  }
  for (const TriangleMesh::Triangle& triangle : mesh.triangles) {
    for (const std::uint32_t corner : triangle.corners) {
      if (corner >= corners) {
        return fail("model '{}' of '{}' has a triangle with corner {} of {}", object.model,
                    object.name, corner, corners);
      }
    }
    if (triangle.material >= mesh.materials.size()) {
      return fail("model '{}' of '{}' has a triangle with material {} of {}", object.model,
                  object.name, triangle.material, mesh.materials.size());
    }
  }
  return {};
}

}  // namespace

Eigen::Vector3f Patch::texel_center(int column, int row) const {
  return origin + (static_cast<float>(column) + 0.5F) * texel_width_m() * along +
         (static_cast<float>(row) + 0.5F) * texel_height_m() * up;
}

// holes: from, to along the patch, from, to upwards, m.
void Scene::add_patch(Patch patch, std::span<const std::array<float, 4>> holes) {
  patch.columns = texels_along(patch.width_m);
  patch.rows = texels_along(patch.height_m);
  patch.first_texel = texel_count_;
  texel_count_ += static_cast<std::size_t>(patch.columns) * static_cast<std::size_t>(patch.rows);
  const auto in_hole = [&](float x, float y) {
    return std::any_of(holes.begin(), holes.end(), [&](const std::array<float, 4>& hole) {
      return x > hole[0] && x < hole[1] && y > hole[2] && y < hole[3];
    });
  };
  for (int row = 0; row < patch.rows; ++row) {
    for (int column = 0; column < patch.columns; ++column) {
      patch.is_hole.push_back(in_hole((static_cast<float>(column) + 0.5F) * patch.texel_width_m(),
                                      (static_cast<float>(row) + 0.5F) * patch.texel_height_m()));
    }
  }

  // A grid whose lines run along the holes' edges; its cells share corners, so nothing gapes.
  std::vector<float> xs{-kOverlap, patch.width_m + kOverlap};
  std::vector<float> ys{-kOverlap, patch.height_m + kOverlap};
  for (const auto& [x_from, x_to, y_from, y_to] : holes) {
    for (const float x : {x_from, x_to}) xs.push_back(std::clamp(x, xs[0], xs[1]));
    for (const float y : {y_from, y_to}) ys.push_back(std::clamp(y, ys[0], ys[1]));
  }
  sort_unique(xs);
  sort_unique(ys);
  const auto first = static_cast<std::uint32_t>(positions_.size());
  for (const float y : ys) {
    for (const float x : xs) {
      positions_.emplace_back(patch.origin + x * patch.along + y * patch.up);
      normals_.push_back(patch.normal);
      uvs_.emplace_back(x, y);
    }
  }
  const auto stride = static_cast<std::uint32_t>(xs.size());
  const bool is_flipped = patch.along.cross(patch.up).dot(patch.normal) < 0;
  const auto index = static_cast<std::int32_t>(patches_.size());
  for (std::uint32_t j = 0; j + 1 < ys.size(); ++j) {
    for (std::uint32_t i = 0; i + 1 < xs.size(); ++i) {
      if (in_hole((xs[i] + xs[i + 1]) / 2, (ys[j] + ys[j + 1]) / 2)) continue;
      std::array<std::uint32_t, 4> corners{first + j * stride + i, first + j * stride + i + 1,
                                           first + (j + 1) * stride + i + 1,
                                           first + (j + 1) * stride + i};
      if (is_flipped) std::swap(corners[1], corners[3]);
      triangles_.push_back(
          {{corners[0], corners[1], corners[2]}, patch.appearance, index, 0, patch.normal, 1});
      triangles_.push_back(
          {{corners[0], corners[2], corners[3]}, patch.appearance, index, 0, patch.normal, 1});
    }
  }
  patches_.push_back(std::move(patch));
}

void Scene::add_shell(const HomeModel& home) {
  const auto height = static_cast<float>(home.ceiling_height_m);
  const auto add_look = [&](Appearance look) {
    appearances_.push_back(std::move(look));
    return static_cast<std::uint32_t>(appearances_.size() - 1);
  };
  const Eigen::Vector3f x = Eigen::Vector3f::UnitX(), y = Eigen::Vector3f::UnitY(),
                        z = Eigen::Vector3f::UnitZ();
  for (std::size_t room = 0; room < home.rooms.size(); ++room) {
    const Room& r = home.rooms[room];
    const Eigen::Vector3f corner(static_cast<float>(r.interior.min.x()),
                                 static_cast<float>(r.interior.min.y()),
                                 static_cast<float>(r.floor_m));
    const Eigen::Vector2f size = (r.interior.max - r.interior.min).cast<float>();
    const auto hole_of = [&](const std::optional<Rectangle>& open) {
      std::vector<std::array<float, 4>> holes;
      if (!open) return holes;
      // Up to walls it goes through the edge, as doors do.
      const auto low = [&](int axis) {
        const double from = open->min[axis] - r.interior.min[axis];
        return from < 0.01 ? -1.0F : static_cast<float>(from);
      };
      const auto high = [&](int axis) {
        const bool is_at_wall = open->max[axis] > r.interior.max[axis] - 0.01;
        return is_at_wall ? size[axis] + 1
                          : static_cast<float>(open->max[axis] - r.interior.min[axis]);
      };
      holes.push_back({low(0), high(0), low(1), high(1)});
      return holes;
    };
    add_patch({corner, x, y, z, size.x(), size.y(), add_look(Appearance::finish(r.floor))},
              hole_of(r.open_floor));
    add_patch({corner + height * z, x, y, -z, size.x(), size.y(),
               add_look(Appearance::finish(r.ceiling))},
              hole_of(r.open_ceiling));
    const std::uint32_t wall_look = add_look(Appearance::wall(r));
    for (const WallFace& face : wall_faces(home, room)) {
      std::vector<std::array<float, 4>> holes;
      for (const WallFace::Hole& hole : face.holes) {
        // A door's hole goes through the floor's edge, or a strip of wall would stay below it.
        holes.push_back({hole.from_m, hole.to_m, hole.is_door ? -1.0F : hole.bottom_m, hole.top_m});
      }
      add_patch({face.origin, face.along, z, face.normal, face.length_m, height, wall_look}, holes);
    }
  }
  for (const StairFace& face : stair_faces(home)) {
    add_patch({face.origin, face.along, face.up, face.normal, face.width_m, face.height_m,
               add_look(Appearance::finish(*face.finish))},
              {});
  }
}

void Scene::add_mesh(const TriangleMesh& mesh, std::uint32_t first_appearance, std::uint16_t object,
                     const geometry::RigidTransform& world_from_mesh) {
  const auto first = static_cast<std::uint32_t>(positions_.size());
  const Eigen::Matrix3f rotation = world_from_mesh.rotation_matrix().cast<float>();
  const Eigen::Vector3f translation = world_from_mesh.translation.cast<float>();
  for (const Eigen::Vector3f& position : mesh.positions) {
    positions_.emplace_back(rotation * position + translation);
  }
  for (const Eigen::Vector3f& normal : mesh.normals) normals_.emplace_back(rotation * normal);
  uvs_.insert(uvs_.end(), mesh.texture_coordinates.begin(), mesh.texture_coordinates.end());
  for (const TriangleMesh::Triangle& triangle : mesh.triangles) {
    const auto [a, b, c] = triangle.corners;
    const Eigen::Vector3f& origin = positions_[first + a];
    const Eigen::Vector3f cross =
        (positions_[first + b] - origin).cross(positions_[first + c] - origin);
    const float twice_area = cross.norm();
    if (!(twice_area > 1e-12F)) continue;  // a line: no ray meets it
    const Eigen::Vector2f& uv = mesh.texture_coordinates[a];
    const Eigen::Vector2f du = mesh.texture_coordinates[b] - uv;
    const Eigen::Vector2f dv = mesh.texture_coordinates[c] - uv;
    const float twice_uv_area = std::abs(du.x() * dv.y() - du.y() * dv.x());
    triangles_.push_back({{first + a, first + b, first + c},
                          first_appearance + triangle.material,
                          -1,
                          object,
                          cross / twice_area,
                          std::sqrt(twice_uv_area / twice_area)});
  }
}

void Scene::finish_triangles() {
  const auto is_opaque = [this](const SceneTriangle& triangle) {
    return appearances_[triangle.appearance].opacity() > 0.98F;
  };
  const auto clear = std::stable_partition(triangles_.begin(), triangles_.end(), is_opaque);
  opaque_count_ = static_cast<std::size_t>(clear - triangles_.begin());
}

Expected<Scene> Scene::build(const HomeModel& home,
                             std::span<const std::shared_ptr<const TriangleMesh>> meshes) {
  if (meshes.size() != home.objects.size()) {
    return fail("{} meshes were given for {} objects", meshes.size(), home.objects.size());
  }
  if (home.objects.size() >= 65535) return fail("a home holds at most 65,534 objects");
  Scene scene(home);
  scene.add_shell(home);

  Fittings fittings = make_fittings(home);
  const auto first_fitting = static_cast<std::uint32_t>(scene.appearances_.size());
  std::move(fittings.looks.begin(), fittings.looks.end(), std::back_inserter(scene.appearances_));
  scene.add_mesh(tessellate(std::move(fittings.mesh), kLongestEdge, kLongestEdge), first_fitting, 0,
                 geometry::RigidTransform::identity());

  TextureStore textures;
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    const TriangleMesh& mesh = *meshes[i];
    ROOMWISE_RETURN_IF_ERROR(check_mesh(mesh, home.objects[i]));
    const auto first = static_cast<std::uint32_t>(scene.appearances_.size());
    for (const SurfaceMaterial& material : mesh.materials) {
      scene.appearances_.push_back(Appearance::material(material, textures.find(material)));
    }
    scene.add_mesh(tessellate(mesh, kLongestEdge, kLongestLevelEdge), first,
                   static_cast<std::uint16_t>(i + 1), home.objects[i].world_from_object);
  }
  scene.finish_triangles();

  std::vector<RayCaster::Corners> corners;
  corners.reserve(scene.triangles_.size());
  for (const SceneTriangle& triangle : scene.triangles_) corners.push_back(triangle.corners);
  const std::span all(corners);
  ROOMWISE_TRY(scene.rays_, RayCaster::build(scene.positions_, all.first(scene.opaque_count_),
                                             all.subspan(scene.opaque_count_)));
  return scene;
}

Eigen::Vector2f Scene::uv_at(const RayHit& hit) const {
  const auto [a, b, c] = triangles_[hit.triangle].corners;
  return (1 - hit.u - hit.v) * uvs_[a] + hit.u * uvs_[b] + hit.v * uvs_[c];
}

Eigen::Vector3f Scene::normal_at(const RayHit& hit, const Eigen::Vector3f& direction) const {
  const SceneTriangle& triangle = triangles_[hit.triangle];
  const auto [a, b, c] = triangle.corners;
  Eigen::Vector3f normal =
      (1 - hit.u - hit.v) * normals_[a] + hit.u * normals_[b] + hit.v * normals_[c];
  // Models exist whose normals point the other way than their triangles turn.
  if (normal.dot(triangle.normal) < 0) normal = -normal;
  const float length = normal.norm();
  normal = length > 1e-3F ? Eigen::Vector3f(normal / length) : triangle.normal;
  return is_front(hit, direction) ? normal : Eigen::Vector3f(-normal);
}

SurfaceLook Scene::look_at(const RayHit& hit, const Eigen::Vector3f& point,
                           float footprint_m) const {
  const SceneTriangle& triangle = triangles_[hit.triangle];
  SurfacePlace place;
  place.footprint_m = footprint_m;
  if (triangle.patch >= 0) {
    const Patch& patch = patches_[static_cast<std::size_t>(triangle.patch)];
    place.plane_m = {patch.along.dot(point), patch.up.dot(point)};
  } else {
    place.uv = uv_at(hit);
    place.uv_per_m = triangle.uv_per_m;
  }
  return appearances_[triangle.appearance].look(place);
}

}  // namespace roomwise::simulation
