#include "roomwise/mapping/graph/up_direction.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <tuple>
#include <utility>

#include "roomwise/image/rgbd_frame.h"

namespace roomwise::mapping {
namespace {

using Eigen::Vector3d;
using VisitNormals = UpDirectionEstimator::VisitNormals;

// The surface's normal at a pixel, towards the camera, from the points `reach` pixels to each side.
// Nothing where one of them was not measured or they do not lie in one plane (edges, round things).
std::optional<Vector3d> surface_normal(const image::DepthImage& depth,
                                       const geometry::PinholeCamera& camera, int x, int y,
                                       int reach, double max_depth_m) {
  const auto point = [&](int dx, int dy) -> std::optional<Vector3d> {
    const double z_m = image::depth_m(depth, camera, x + dx, y + dy);
    if (z_m <= 0 || z_m > max_depth_m) return std::nullopt;
    return camera.unproject({x + dx, y + dy}, z_m);
  };
  const auto centre = point(0, 0);
  const auto left = point(-reach, 0);
  const auto right = point(reach, 0);
  const auto above = point(0, -reach);
  const auto below = point(0, reach);
  if (!centre || !left || !right || !above || !below) return std::nullopt;

  const Vector3d across = (*right - *left).cross(*below - *above);
  const Vector3d normal = (across.dot(*centre) < 0 ? across : Vector3d(-across)).normalized();
  if (!normal.allFinite()) return std::nullopt;
  // About three times the noise of a structured-light camera at 3 m.
  constexpr double kMaxOffPlane = 0.01;  // of the depth
  for (const auto& side : {left, right, above, below}) {
    if (std::abs(normal.dot(*side - *centre)) > kMaxOffPlane * centre->z()) return std::nullopt;
  }
  return normal;
}

// The mean of the normals within `angle_rad` of `axis`, and how many there are. A normal of the
// opposite direction (a ceiling's) counts reversed.
std::pair<Vector3d, std::size_t> mean_about(const VisitNormals& visit, const Vector3d& axis,
                                            double angle_rad) {
  const double min_cosine = std::cos(angle_rad);
  Vector3d sum = Vector3d::Zero();
  std::size_t count = 0;
  visit([&](std::span<const Vector3d> normals) {
    for (const Vector3d& normal : normals) {
      const double cosine = axis.dot(normal);
      if (std::abs(cosine) < min_cosine) continue;
      sum += cosine < 0 ? Vector3d(-normal) : normal;
      ++count;
    }
  });
  return {count > 0 ? sum.normalized() : axis, count};
}

// The direction within `max_tilt_rad` of `axis` about which most normals lie, to about a cell of
// the voting plane; and how many there are.
std::pair<Vector3d, std::size_t> fullest_direction(const VisitNormals& visit, const Vector3d& axis,
                                                   double max_tilt_rad) {
  // Directions n are told apart by where axis + a * u + b * v meets them.
  const Vector3d u = axis.unitOrthogonal();
  const Vector3d v = axis.cross(u);
  const double extent = std::tan(max_tilt_rad);
  constexpr int kCells = 64;
  const auto cell_of = [&](double coordinate) {
    return static_cast<int>(std::floor((coordinate / extent + 1) / 2 * kCells));
  };
  image::Image<int> votes(kCells, kCells, 0);
  std::size_t count = 0;
  visit([&](std::span<const Vector3d> normals) {
    count += normals.size();
    for (const Vector3d& normal : normals) {
      const double along = axis.dot(normal);
      if (std::abs(along) < std::cos(max_tilt_rad)) continue;
      const int a = cell_of(u.dot(normal) / along);
      const int b = cell_of(v.dot(normal) / along);
      if (votes.contains(a, b)) ++votes.at(a, b);
    }
  });

  // A surface's normals spread over some cells: the fullest 5 x 5 cells win, the first on a tie.
  constexpr int kSpread = 2;
  int max_votes = -1;
  Vector3d fullest = axis;
  for (int b = kSpread; b < kCells - kSpread; ++b) {
    for (int a = kSpread; a < kCells - kSpread; ++a) {
      int sum = 0;
      for (int db = -kSpread; db <= kSpread; ++db) {
        for (int da = -kSpread; da <= kSpread; ++da) sum += votes.at(a + da, b + db);
      }
      if (sum <= max_votes) continue;
      max_votes = sum;
      const auto centre_of = [&](int cell) { return ((cell + 0.5) / kCells * 2 - 1) * extent; };
      fullest = (axis + centre_of(a) * u + centre_of(b) * v).normalized();
    }
  }
  return {fullest, count};
}

// The mean of directions; nothing where they are none or do not agree.
std::optional<Vector3d> agreed_direction(const std::vector<Vector3d>& directions) {
  // Half of them within 5 degrees or so: gravity is felt to one, and the map may be bent a little.
  constexpr double kMinCosine = 0.996;
  Vector3d sum = Vector3d::Zero();
  for (const Vector3d& direction : directions) sum += direction;
  if (!(sum.norm() > 0)) return std::nullopt;
  const Vector3d mean = sum.normalized();
  const auto agreeing = std::ranges::count_if(
      directions, [&](const Vector3d& one) { return one.dot(mean) >= kMinCosine; });
  if (2 * static_cast<std::size_t>(agreeing) < directions.size()) return std::nullopt;
  return mean;
}

}  // namespace

Expected<void> UpDirectionOptions::validate() const {
  if (grid_columns < 1) return fail("grid_columns is {}; expected 1 or more", grid_columns);
  if (!(max_depth_m > 0)) return fail("max_depth_m is {}; expected more than 0", max_depth_m);
  if (!(max_tilt_rad > 0 && max_tilt_rad < std::numbers::pi / 2)) {
    return fail("max_tilt_rad is {}; expected between 0 and pi/2", max_tilt_rad);
  }
  if (!(inlier_angle_rad > 0 && inlier_angle_rad < max_tilt_rad)) {
    return fail("inlier_angle_rad is {}; expected between 0 and max_tilt_rad", inlier_angle_rad);
  }
  if (min_inliers < 1) return fail("min_inliers is {}; expected 1 or more", min_inliers);
  if (!(min_support >= 0 && min_support <= 1)) {
    return fail("min_support is {}; expected between 0 and 1", min_support);
  }
  return {};
}

std::vector<Eigen::Vector3f> surface_normals(const image::DepthImage& depth,
                                             const geometry::PinholeCamera& camera,
                                             const UpDirectionOptions& options) {
  std::vector<Eigen::Vector3f> normals;
  const int step = std::max(1, depth.width() / options.grid_columns);
  const int reach = step;
  for (int y = reach; y + reach < depth.height(); y += step) {
    for (int x = reach; x + reach < depth.width(); x += step) {
      const auto normal = surface_normal(depth, camera, x, y, reach, options.max_depth_m);
      if (normal) normals.push_back(normal->cast<float>());
    }
  }
  return normals;
}

UpDirectionEstimator::UpDirectionEstimator(const UpDirectionOptions& options) : options_(options) {}

void UpDirectionEstimator::add(const geometry::RigidTransform& world_from_camera,
                               const image::DepthImage& depth,
                               const geometry::PinholeCamera& camera) {
  add_camera(world_from_camera);
  for (const Eigen::Vector3f& normal : surface_normals(depth, camera, options_))
    add_normal(world_from_camera.rotation * normal.cast<double>());
}

void UpDirectionEstimator::add_camera(const geometry::RigidTransform& world_from_camera) {
  camera_up_sum_ += world_from_camera.rotation * -Vector3d::UnitY();
}

UpDirection UpDirectionEstimator::estimate() const {
  return estimate([&](const auto& visit) { visit(normals_world_); });
}

UpDirection UpDirectionEstimator::estimate(const VisitNormals& visit_normals_world) const {
  UpDirection expected;
  if (camera_up_sum_.norm() > 0) expected.up_world = camera_up_sum_.normalized();
  if (const auto gravity = agreed_direction(gravity_world_)) {
    expected.up_world = *gravity;
    expected.is_by_gravity = true;
  }

  auto [up, count] =
      fullest_direction(visit_normals_world, expected.up_world, options_.max_tilt_rad);
  std::size_t inliers = 0;
  // The first mean is about the centre of a cell; a few more about the mean itself settle it.
  constexpr int kRefinements = 5;
  for (int i = 0; i < kRefinements; ++i) {
    std::tie(up, inliers) = mean_about(visit_normals_world, up, options_.inlier_angle_rad);
  }
  const double support = count == 0 ? 0 : static_cast<double>(inliers) / static_cast<double>(count);
  if (inliers < static_cast<std::size_t>(options_.min_inliers) || support < options_.min_support) {
    return expected;
  }
  return {up, support, expected.is_by_gravity};
}

}  // namespace roomwise::mapping
