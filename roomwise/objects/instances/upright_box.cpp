#include "roomwise/objects/instances/upright_box.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace roomwise::objects {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double kOutermostShare = 0.015;
constexpr double kFlatRim_m = 0.03;  // so that flat things have an area, too

}  // namespace

std::pair<double, double> range_of(std::vector<double> values) {
  const auto cut =
      static_cast<std::ptrdiff_t>(kOutermostShare * static_cast<double>(values.size()));
  std::ranges::nth_element(values, values.begin() + cut);
  const double low = values[static_cast<std::size_t>(cut)];
  const auto last = values.end() - 1 - cut;
  std::ranges::nth_element(values, last);
  return {low, *last};
}

std::pair<double, double> range_along(std::span<const Vector3f> points, const Vector3d& axis) {
  std::vector<double> along;
  along.reserve(points.size());
  for (const Vector3f& point : points) along.push_back(axis.dot(point.cast<double>()));
  return range_of(std::move(along));
}

std::pair<Vector3d, Vector3d> level_axes(std::span<const Vector3f> points, const Vector3d& up) {
  constexpr int kSteps = 45;
  const Vector3d u = up.unitOrthogonal();
  const Vector3d v = up.cross(u);
  double smallest = std::numeric_limits<double>::infinity();
  std::pair<Vector3d, Vector3d> best{u, v};
  for (int step = 0; step < kSteps; ++step) {
    const double angle = step * (std::numbers::pi / 2) / kSteps;
    const Vector3d x = std::cos(angle) * u + std::sin(angle) * v;
    const Vector3d y = up.cross(x);
    const auto [low_x, high_x] = range_along(points, x);
    const auto [low_y, high_y] = range_along(points, y);
    const double area = (high_x - low_x + kFlatRim_m) * (high_y - low_y + kFlatRim_m);
    if (area >= smallest) continue;
    smallest = area;
    best = {x, y};
  }
  return best;
}

geometry::OrientedBox upright_box(std::span<const Vector3f> points, const Vector3d& up) {
  const auto [x, y] = level_axes(points, up);
  Eigen::Matrix3d axes;
  axes << x, y, up;
  Vector3d low, high;
  for (int i = 0; i < 3; ++i) std::tie(low[i], high[i]) = range_along(points, axes.col(i));
  return {geometry::RigidTransform::from_matrix(axes, axes * ((low + high) / 2)), high - low};
}

bool is_like_a_leaf(const geometry::OrientedBox& box_world, const GroundPlane& level) {
  const Eigen::Vector3d& size_m = box_world.size_m;
  const auto [thin_m, wide_m] = std::minmax(size_m.x(), size_m.y());
  const double top_m = level.height_m(box_world.center()) + size_m.z() / 2;
  return thin_m < 0.2 && wide_m > 0.35 && wide_m < kLeafWidth_m && size_m.z() > 1.1 && top_m > 1.6;
}

}  // namespace roomwise::objects
