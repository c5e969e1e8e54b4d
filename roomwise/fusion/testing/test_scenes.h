#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "roomwise/base/random.h"
#include "roomwise/base/thread_pool.h"
#include "roomwise/fusion/frame_fusion.h"
#include "roomwise/fusion/frame_surface.h"
#include "roomwise/fusion/triangle_mesh.h"

// Shapes with known surfaces and what a depth camera sees of them, for tests: not part of the
// product.
namespace roomwise::fusion::testing {

using Eigen::Vector3d;
using geometry::RigidTransform;

struct Shape {
  // How far along the ray the shape is first met from outside; infinity where it is not.
  std::function<double(const Vector3d& origin, const Vector3d& direction)> meet;
  std::function<double(const Vector3d& point)> distance_m;  // to its surface, negative inside
  Rgb8 color{200, 150, 100};
};

constexpr double kMissed = std::numeric_limits<double>::infinity();

// The points with normal . p < offset are inside.
inline Shape half_space(const Vector3d& normal, double offset_m, Rgb8 color = {200, 150, 100}) {
  return {[=](const Vector3d& origin, const Vector3d& direction) {
            const double closing = -normal.dot(direction);
            const double far = (normal.dot(origin) - offset_m) / closing;
            return closing > 0 && far > 0 ? far : kMissed;
          },
          [=](const Vector3d& point) { return normal.dot(point) - offset_m; }, color};
}

inline Shape sphere(const Vector3d& center, double radius_m, Rgb8 color = {100, 150, 200}) {
  return {[=](const Vector3d& origin, const Vector3d& direction) {
            const Vector3d from_center = origin - center;
            const double a = direction.squaredNorm(), b = from_center.dot(direction);
            const double root = b * b - a * (from_center.squaredNorm() - radius_m * radius_m);
            if (root < 0) return kMissed;
            const double near = (-b - std::sqrt(root)) / a;
            return near > 0 ? near : kMissed;
          },
          [=](const Vector3d& point) { return (point - center).norm() - radius_m; }, color};
}

inline Shape box(const Vector3d& low, const Vector3d& high, Rgb8 color = {100, 200, 100}) {
  return {[=](const Vector3d& origin, const Vector3d& direction) {
            const Eigen::Array3d a = (low - origin).array() / direction.array();
            const Eigen::Array3d b = (high - origin).array() / direction.array();
            const double enter = a.min(b).maxCoeff(), leave = a.max(b).minCoeff();
            return enter > 0 && enter < leave ? enter : kMissed;
          },
          [=](const Vector3d& point) {
            const Eigen::Array3d beyond = (low - point).array().max((point - high).array());
            return beyond.max(0.0).matrix().norm() + std::min(0.0, beyond.maxCoeff());
          },
          color};
}

using Scene = std::vector<Shape>;

inline double distance_m(const Scene& scene, const Vector3d& point) {
  double nearest_m = kMissed;
  for (const Shape& shape : scene) nearest_m = std::min(nearest_m, shape.distance_m(point));
  return nearest_m;
}

inline geometry::PinholeCamera small_camera() {
  return {260, 260, 159.5, 119.5, 320, 240, {}, 5000};
}

struct Picture {
  image::ColorImage color;
  image::DepthImage depth;
};

// noise_at_1m_m: sigma of the inverse depth, 1/m.
inline Picture render(const Scene& scene, const RigidTransform& world_from_camera,
                      const geometry::PinholeCamera& camera, double noise_at_1m_m = 0,
                      std::uint64_t seed = 1) {
  RandomStream random(seed);
  Picture picture{{camera.width, camera.height}, {camera.width, camera.height}};
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Vector3d ray = world_from_camera.rotation * camera.unproject({x, y}, 1.0);
      double nearest_m = kMissed;
      for (const Shape& shape : scene) {
        const double z_m = shape.meet(world_from_camera.translation, ray);
        if (z_m >= nearest_m) continue;
        nearest_m = z_m;
        picture.color.at(x, y) = shape.color;
      }
      const double z_m = 1 / (1 / nearest_m + noise_at_1m_m * random.normal());
      if (!(z_m < 12)) continue;
      picture.depth.at(x, y) =
          static_cast<std::uint16_t>(std::lround(z_m * camera.depth_units_per_metre));
    }
  }
  return picture;
}

// A camera at `eye` that looks at `target`, its picture's top towards `up`.
inline RigidTransform looking_at(const Vector3d& eye, const Vector3d& target,
                                 const Vector3d& up = Vector3d::UnitZ()) {
  Eigen::Matrix3d rotation;
  rotation.col(2) = (target - eye).normalized();
  rotation.col(0) = rotation.col(2).cross(up).normalized();
  rotation.col(1) = rotation.col(2).cross(rotation.col(0));
  return RigidTransform::from_matrix(rotation, eye);
}

// From all sides of a point, two rings and the poles.
inline std::vector<RigidTransform> all_round(const Vector3d& target, double distance_m) {
  std::vector<RigidTransform> cameras;
  for (const double height : {-0.6, 0.6}) {
    for (int i = 0; i < 8; ++i) {
      const double angle = std::numbers::pi * i / 4;
      const Vector3d out(std::cos(angle), std::sin(angle), height);
      cameras.push_back(looking_at(target + distance_m * out.normalized(), target));
    }
  }
  for (const double side : {-1.0, 1.0}) {
    cameras.push_back(
        looking_at(target + distance_m * side * Vector3d::UnitZ(), target, Vector3d::UnitX()));
  }
  return cameras;
}

inline TsdfVolume fuse(const Scene& scene, const std::vector<RigidTransform>& cameras,
                       ThreadPool& pool, const TsdfOptions& options = {}, double noise_at_1m_m = 0,
                       const geometry::PinholeCamera& camera = small_camera()) {
  TsdfVolume field(options);
  const FrameSurfaceMaker maker(camera);
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const Picture picture = render(scene, cameras[i], camera, noise_at_1m_m, i);
    const auto fused =
        integrate_frame(field, maker.make(picture.color, picture.depth), cameras[i], pool);
    if (!fused) throw std::runtime_error(fused.error().message);
  }
  return field;
}

// The field of a scene as it is, without any camera, in the blocks from `low` to `high`.
inline TsdfVolume true_field(const Scene& scene, int low, int high,
                             const TsdfOptions& options = {}) {
  TsdfVolume field(options);
  for (int i = 0; i < (high - low) * (high - low) * (high - low); ++i) {
    const int n = high - low;
    const Eigen::Vector3i place = Eigen::Vector3i(i % n, i / n % n, i / n / n).array() + low;
    auto block = std::make_unique<VoxelBlock>();
    for (int v = 0; v < kBlockVoxels; ++v) {
      const Eigen::Vector3i voxel = kBlockSide * place + Eigen::Vector3i(v % 8, v / 8 % 8, v / 64);
      const double share =
          distance_m(scene, voxel.cast<double>() * options.voxel_size_m) / options.truncation_m();
      block->voxels[static_cast<std::size_t>(v)] = {
          static_cast<std::int32_t>(
              std::lround(100 * kStepsPerTruncation * std::clamp(share, -1., 1.))),
          100};
    }
    field.insert(place, std::move(block));
  }
  return field;
}

// How often each edge between two vertices is passed in that direction by a triangle.
inline std::map<std::pair<std::uint32_t, std::uint32_t>, int> directed_edges(
    const TriangleMesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& triangle : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) ++edges[{triangle[i], triangle[(i + 1) % 3]}];
  }
  return edges;
}

// Every edge has a triangle on each side, which agree what is outside.
inline bool is_closed(const TriangleMesh& mesh) {
  const auto edges = directed_edges(mesh);
  for (const auto& [edge, count] : edges) {
    const auto back = edges.find({edge.second, edge.first});
    if (count != 1 || back == edges.end() || back->second != 1) return false;
  }
  return true;
}

// Vertices less edges plus triangles, of a closed mesh: 2 for a sphere.
inline long euler_characteristic(const TriangleMesh& mesh) {
  return static_cast<long>(mesh.vertices.size()) -
         static_cast<long>(directed_edges(mesh).size() / 2) +
         static_cast<long>(mesh.triangles.size());
}

}  // namespace roomwise::fusion::testing
