#include "roomwise/geometry/drawing_direction.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <vector>

namespace roomwise::geometry {
namespace {

using Eigen::Vector2d;

constexpr double kDegree_rad = std::numbers::pi / 180;

// How far the points gather in lines along the axes of the plane turned by `angle_rad`: walls along
// an axis fall into few places of the other.
double gathering(std::span<const Vector2d> points, double angle_rad) {
  constexpr double kBin_m = 0.05;
  double squares = 0;
  for (const double turn_rad : {0.0, std::numbers::pi / 2}) {
    const Vector2d axis(std::cos(angle_rad + turn_rad), std::sin(angle_rad + turn_rad));
    std::map<long, double> counts;
    for (const Vector2d& point : points) ++counts[std::lround(axis.dot(point) / kBin_m)];
    for (const auto& [bin, count] : counts) squares += count * count;
  }
  return squares;
}

// Evenly over a cell about its middle, the same for the same place in the order (Roberts' R2).
Vector2d in_cell(std::size_t i) {
  const Vector2d share = static_cast<double>(i) * Vector2d(0.7548776662466927, 0.5698402909980532);
  return share.array() - share.array().floor() - 0.5;
}

double direction_of_walls_rad(std::span<const Vector2d> points, double cell_m) {
  constexpr std::size_t kEnough = 20'000;
  std::vector<Vector2d> some;
  for (std::size_t i = 0; i < points.size(); i += 1 + points.size() / kEnough) {
    some.push_back(points[i] + cell_m * in_cell(some.size()));
  }
  double best_rad = 0, best = -1;
  for (int degrees = 0; degrees < 90; ++degrees) {
    const double value = gathering(some, degrees * kDegree_rad);
    if (value <= best) continue;
    best = value;
    best_rad = degrees * kDegree_rad;
  }
  return best_rad;
}

// All but the outermost of the values: single points may be faults.
std::pair<double, double> extent_of(std::vector<double> values) {
  constexpr double kOutermost = 0.002;
  std::ranges::sort(values);
  const auto at = [&](double share) {
    return values[static_cast<std::size_t>(
        std::lround(share * static_cast<double>(values.size() - 1)))];
  };
  return {at(kOutermost), at(1 - kOutermost)};
}

}  // namespace

double drawing_direction_rad(std::span<const Vector2d> points, const Vector2d& begin,
                             double cell_m) {
  if (points.empty()) return 0;
  const double along_rad = direction_of_walls_rad(points, cell_m);
  const auto along = [&](double angle_rad) {
    const Vector2d axis(std::cos(angle_rad), std::sin(angle_rad));
    std::vector<double> values;
    values.reserve(points.size());
    for (const Vector2d& point : points) values.push_back(axis.dot(point));
    const auto [low, high] = extent_of(std::move(values));
    const double start = axis.dot(begin);
    return std::pair(std::min(low, start), std::max(high, start));
  };
  const double across_rad = along_rad + std::numbers::pi / 2;
  const auto [low, high] = along(along_rad);
  const auto [low_across, high_across] = along(across_rad);
  const bool is_longer = high - low >= high_across - low_across;
  const double right_rad = is_longer ? along_rad : across_rad;
  const double middle = is_longer ? (low + high) / 2 : (low_across + high_across) / 2;
  const bool begins_right = Vector2d(std::cos(right_rad), std::sin(right_rad)).dot(begin) > middle;
  return std::remainder(right_rad + (begins_right ? std::numbers::pi : 0), 2 * std::numbers::pi);
}

}  // namespace roomwise::geometry
