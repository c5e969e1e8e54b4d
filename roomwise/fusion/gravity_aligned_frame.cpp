#include "roomwise/fusion/gravity_aligned_frame.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include "roomwise/mapping/graph/up_direction.h"

namespace roomwise::fusion {
namespace {

using Eigen::Vector3d;
using geometry::RigidTransform;

struct Plane {
  Vector3d normal = Vector3d::UnitZ();  // unit length
  double offset_m = 0;                  // normal . p = offset_m
};

// Of a triangle whose corners agree; where the noise of far measurements makes waves they do not,
// and of enough waves a few face any direction.
std::optional<Vector3d> flat_normal(const TriangleMesh& mesh,
                                    const std::array<std::uint32_t, 3>& triangle) {
  constexpr float kMinCosine = 0.98F;  // 11 degrees
  const Eigen::Vector3f& a = mesh.normals[triangle[0]];
  const Eigen::Vector3f& b = mesh.normals[triangle[1]];
  const Eigen::Vector3f& c = mesh.normals[triangle[2]];
  if (std::min({a.dot(b), b.dot(c), c.dot(a)}) < kMinCosine) return std::nullopt;
  return Vector3d((a + b + c).cast<double>().normalized());
}

// The normals of the flat triangles, piece by piece, as often as they are asked for.
class FlatNormals {
 public:
  explicit FlatNormals(const PiecewiseMesh& mesh) : mesh_(mesh) {}

  void visit(const std::function<void(std::span<const Vector3d>)>& visit) {
    std::vector<Vector3d> normals;
    const auto read = mesh_.for_each([&](const MeshPiece& piece) {
      normals.clear();
      for (const auto& triangle : piece.mesh.triangles) {
        if (const auto normal = flat_normal(piece.mesh, triangle)) normals.push_back(*normal);
      }
      visit(normals);
    });
    if (!read) outcome_ = read;
  }
  [[nodiscard]] const Expected<void>& outcome() const { return outcome_; }

 private:
  const PiecewiseMesh& mesh_;
  Expected<void> outcome_;
};

// The places of vertices that face up, in a deque, which does not grow by copying.
using Places = std::deque<Eigen::Vector3f>;

Expected<Places> level_vertices(const PiecewiseMesh& mesh, const Vector3d& up) {
  constexpr double kMinCosine = 0.95;  // 18 degrees: noise, ramps, a map that is bent
  Places places;
  ROOMWISE_RETURN_IF_ERROR(mesh.for_each([&](const MeshPiece& piece) {
    for (std::size_t i = 0; i < piece.own; ++i) {
      if (piece.mesh.normals[i].cast<double>().dot(up) < kMinCosine) continue;
      places.push_back(piece.mesh.vertices[i]);
    }
  }));
  return places;
}

double height_m(const Vector3d& up, const Eigen::Vector3f& place) {
  return up.dot(Vector3d(place.cast<double>()));
}

// The height of the floor below `highest_m`, to about a bin.
std::optional<double> floor_below_m(double highest_m, const Places& level, const Vector3d& up) {
  constexpr double kBin_m = 0.02;
  constexpr std::size_t kFewest = 200;  // vertices: 0.08 m^2 of floor at 2 cm
  double lowest_m = highest_m;
  for (const auto& place : level) lowest_m = std::min(lowest_m, height_m(up, place));
  const auto bin_of = [&](double at_m) {
    return static_cast<std::size_t>((at_m - lowest_m) / kBin_m);
  };
  std::vector<std::size_t> counts(bin_of(highest_m) + 3, 0);  // one empty bin on each side
  for (const auto& place : level) {
    const double at_m = height_m(up, place);
    if (at_m <= highest_m) ++counts[bin_of(at_m) + 1];
  }
  std::vector<std::size_t> around(counts.size(), 0);
  for (std::size_t i = 1; i + 1 < counts.size(); ++i) {
    around[i] = counts[i - 1] + counts[i] + counts[i + 1];
  }
  const std::size_t fullest = *std::ranges::max_element(around);
  if (fullest < kFewest) return std::nullopt;
  std::size_t floor = 1;
  while (around[floor] < fullest / 3 || around[floor] < around[floor + 1]) ++floor;
  return lowest_m + (static_cast<double>(floor) - 0.5) * kBin_m;
}

// The height of the floor under the lowest camera; where there is none, under all but the lowest
// tenth of the cameras: somebody may have held one low.
std::optional<double> floor_height_m(const Places& level, const Vector3d& up,
                                     std::span<const RigidTransform> cameras) {
  constexpr double kCameraAboveFloor_m = 0.3;
  if (level.empty() || cameras.empty()) return std::nullopt;
  std::vector<double> heights_m;
  for (const RigidTransform& camera : cameras) heights_m.push_back(up.dot(camera.translation));
  std::ranges::sort(heights_m);
  const auto under = [&](double camera_m) {
    return floor_below_m(camera_m - kCameraAboveFloor_m, level, up);
  };
  const auto floor_m = under(heights_m.front());
  return floor_m ? floor_m : under(heights_m[heights_m.size() / 10]);
}

// The plane through the places that lie near `plane`, where they spread far enough to tell of a
// tilt.
Plane fitted(const Plane& plane, const Places& places, double near_m) {
  constexpr double kMinSpread_m = 0.3;
  const auto visit_near = [&](const auto& visit) {
    for (const auto& place : places) {
      if (std::abs(height_m(plane.normal, place) - plane.offset_m) <= near_m)
        visit(Vector3d(place.cast<double>()));
    }
  };
  double count = 0;
  Vector3d mean = Vector3d::Zero();
  visit_near([&](const Vector3d& place) {
    mean += place;
    ++count;
  });
  if (count == 0) return plane;
  mean /= count;
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  visit_near([&](const Vector3d& place) { spread += (place - mean) * (place - mean).transpose(); });
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread / count);
  if (axes.eigenvalues()[1] < kMinSpread_m * kMinSpread_m) {
    return {plane.normal, plane.normal.dot(mean)};
  }
  Vector3d normal = axes.eigenvectors().col(0);
  if (normal.dot(plane.normal) < 0) normal = -normal;
  return {normal, normal.dot(mean)};
}

RigidTransform frame_on(const Plane& floor) {
  const Vector3d& z = floor.normal;
  // The world is the first camera's frame: it looked along z, and where that is upright, its
  // picture's top lay towards -y.
  const Vector3d looked = Vector3d::UnitZ() - z.z() * z;
  const Vector3d top = -Vector3d::UnitY() + z.y() * z;
  constexpr double kUpright = 0.2;
  const Vector3d x = (looked.norm() > kUpright ? looked : top).normalized();
  Eigen::Matrix3d rotation;
  rotation << x.transpose(), z.cross(x).transpose(), z.transpose();
  return RigidTransform::from_matrix(rotation, {0, 0, -floor.offset_m});
}

}  // namespace

Expected<GravityAlignedFrame> find_gravity_aligned_frame(
    const PiecewiseMesh& mesh_world, std::span<const RigidTransform> world_from_cameras,
    std::span<const Vector3d> gravity_up_world) {
  mapping::UpDirectionEstimator estimator;
  for (const Vector3d& up : gravity_up_world) estimator.add_gravity(up);
  for (const RigidTransform& camera : world_from_cameras) estimator.add_camera(camera);
  FlatNormals normals(mesh_world);
  const mapping::UpDirection up =
      estimator.estimate([&](const auto& visit) { normals.visit(visit); });
  ROOMWISE_RETURN_IF_ERROR(normals.outcome());
  GravityAlignedFrame frame;
  frame.has_up = up.support > 0 || up.is_by_gravity;
  Plane floor{up.up_world, 0};
  ROOMWISE_TRY(const Places level, level_vertices(mesh_world, up.up_world));
  const auto floor_m = floor_height_m(level, up.up_world, world_from_cameras);
  if (frame.has_up && floor_m) {
    frame.has_floor = true;
    floor.offset_m = *floor_m;
    // The first try may be tilted: it takes in more.
    for (const double near_m : {0.08, 0.05, 0.04, 0.04}) floor = fitted(floor, level, near_m);
  }
  frame.gravity_from_world = frame_on(floor);
  return frame;
}

}  // namespace roomwise::fusion
