#pragma once

#include <memory>
#include <numbers>
#include <string>

#include "laboratory/simulation/home/home_model.h"
#include "laboratory/simulation/render/renderer.h"
#include "roomwise/base/expected.h"

// Small homes for the renderer's tests.
namespace roomwise::simulation {

// A box of unit size in the object frame: its models are named "box".
inline TriangleMesh box_mesh(const Eigen::Vector3f& size, const SurfaceMaterial& material) {
  TriangleMesh mesh;
  mesh.materials = {material};
  for (int axis = 0; axis < 3; ++axis) {
    for (const float side : {-1.0F, 1.0F}) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      const auto first = static_cast<std::uint32_t>(mesh.positions.size());
      for (const auto& [a, b] :
           {std::pair{-1.0F, -1.0F}, {1.0F, -1.0F}, {1.0F, 1.0F}, {-1.0F, 1.0F}}) {
        Eigen::Vector3f corner = Eigen::Vector3f::Zero(), normal = Eigen::Vector3f::Zero();
        corner[axis] = side / 2;
        corner[u] = a / 2;
        corner[v] = b / 2;
        normal[axis] = side;
        corner = corner.cwiseProduct(size);
        corner.z() += size.z() / 2;
        mesh.positions.push_back(corner);
        mesh.normals.push_back(normal);
        mesh.texture_coordinates.emplace_back(a, b);
      }
      const std::uint32_t second = side > 0 ? 1 : 3, last = side > 0 ? 3 : 1;
      mesh.triangles.push_back({{first, first + second, first + 2}, 0});
      mesh.triangles.push_back({{first, first + 2, first + last}, 0});
    }
  }
  return mesh;
}

// The area of all triangles; faces that lie apart from each other or overlap show in it.
inline double area_of(const TriangleMesh& mesh) {
  double sum = 0;
  for (const TriangleMesh::Triangle& triangle : mesh.triangles) {
    const Eigen::Vector3f& origin = mesh.positions[triangle.corners[0]];
    const Eigen::Vector3f u = mesh.positions[triangle.corners[1]] - origin;
    const Eigen::Vector3f v = mesh.positions[triangle.corners[2]] - origin;
    sum += static_cast<double>(u.cross(v).norm()) / 2;
  }
  return sum;
}

inline Finish plain_finish(std::uint8_t value) {
  Finish finish;
  finish.color = finish.accent = {value, value, value};
  return finish;
}

// Rooms of 4 m x 4 m with their inner faces at x = 0 and 4, y = 0 and 4; the second, if there is
// one, lies beyond x = 4.12, behind a door in the middle of the wall. No light is on.
inline HomeModel square_rooms(std::size_t rooms) {
  HomeModel home;
  home.scenario = Scenario::kNight;
  for (std::size_t i = 0; i < rooms; ++i) {
    Room room;
    room.name = i == 0 ? "hall" : "study";
    const double left = 4.12 * static_cast<double>(i);
    room.interior = {{left, 0}, {left + 4, 4}};
    room.floor = room.walls = room.ceiling = plain_finish(200);
    home.rooms.push_back(room);
  }
  if (rooms > 1) {
    Door door;
    door.opening.center = {4.06, 2};
    door.opening.along_x = false;
    door.has_leaf = false;
    door.other_room = 1;
    home.doors.push_back(door);
  }
  return home;
}

inline Light ceiling_panel(const Eigen::Vector2d& place, double lumens) {
  Light light;
  light.position = {place.x(), place.y(), 2.57};
  light.radius_m = 0.3;
  light.lumens = lumens;
  light.color_temperature_k = 6500;
  light.is_on = light.is_ceiling_panel = true;
  return light;
}

inline PlacedObject box_object(const Eigen::Vector3d& place) {
  PlacedObject object;
  object.name = "box";
  object.kind = object.model = "box";
  object.world_from_object.translation = place;
  return object;
}

inline Expected<TriangleMesh> load_box(const std::string& model) {
  if (model != "box") return fail("no model '{}'", model);
  return box_mesh(Eigen::Vector3f(0.6F, 0.5F, 0.8F), SurfaceMaterial{});
}

// Looks from `eye` along a level direction given by its turn from x towards y.
inline geometry::RigidTransform level_view(const Eigen::Vector3d& eye, double turn_rad) {
  const Eigen::Vector3d forward(std::cos(turn_rad), std::sin(turn_rad), 0);
  const Eigen::Vector3d down = -Eigen::Vector3d::UnitZ();
  Eigen::Matrix3d world_from_camera;
  world_from_camera << down.cross(forward), down, forward;
  return geometry::RigidTransform::from_matrix(world_from_camera, eye);
}

inline geometry::PinholeCamera small_camera() {
  geometry::PinholeCamera camera;
  camera.fx = camera.fy = 66;
  camera.cx = 39.5;
  camera.cy = 29.5;
  camera.width = 80;
  camera.height = 60;
  return camera;
}

}  // namespace roomwise::simulation
