#include "laboratory/simulation/furniture/polygon_triangulation.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace roomwise::simulation {
namespace {

// Cuts off one ear after another (G. H. Meisters, 1975), the one with the widest smallest angle
// first, so that slivers are rare.
class EarCutter {
 public:
  explicit EarCutter(std::span<const Eigen::Vector3f> polygon) {
    // Newell's normal: right for polygons that are not quite flat, too.
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Eigen::Vector3d from = (polygon[i] - polygon[0]).cast<double>();
      const Eigen::Vector3d to = (polygon[(i + 1) % polygon.size()] - polygon[0]).cast<double>();
      normal += from.cross(to);
    }
    const Eigen::Vector3d up =
        normal.norm() > 0 ? normal.normalized().eval() : Eigen::Vector3d::UnitZ().eval();
    const Eigen::Vector3d right = up.unitOrthogonal(), ahead = up.cross(right);
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Eigen::Vector3d corner = (polygon[i] - polygon[0]).cast<double>();
      corners_.emplace_back(corner.dot(right), corner.dot(ahead));
      left_.push_back(i);
    }
  }

  std::vector<std::array<std::size_t, 3>> cut() {
    std::vector<std::array<std::size_t, 3>> triangles;
    while (left_.size() > 3) {
      std::size_t best = 0;
      double best_quality = -std::numeric_limits<double>::infinity();
      for (std::size_t i = 0; i < left_.size(); ++i) {
        const double quality = quality_of(i);
        if (quality > best_quality) {
          best = i;
          best_quality = quality;
        }
      }
      triangles.push_back(ear_at(best));
      left_.erase(left_.begin() + static_cast<std::ptrdiff_t>(best));
    }
    if (left_.size() == 3) triangles.push_back(ear_at(1));
    return triangles;
  }

 private:
  [[nodiscard]] std::array<std::size_t, 3> ear_at(std::size_t i) const {
    const std::size_t count = left_.size();
    return {left_[(i + count - 1) % count], left_[i], left_[(i + 1) % count]};
  }

  // Twice the area, positive where the corners turn anticlockwise.
  static double turn(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
    return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
  }

  // Of the ear at a corner that is left: above 0 where it may be cut off; then the height of its
  // triangle against its longest side. Below 0 otherwise: the least bad is taken where a polygon
  // that crosses itself has no ear.
  [[nodiscard]] double quality_of(std::size_t i) const {
    const auto [before, tip, after] = ear_at(i);
    const Eigen::Vector2d &a = corners_[before], &b = corners_[tip], &c = corners_[after];
    const double longest =
        std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
    if (!(longest > 0)) return 2;  // a corner that is there three times
    const double area = turn(a, b, c);
    if (area <= 0) return area / longest - (area < 0 ? 1 : 0);
    for (const std::size_t other : left_) {
      const Eigen::Vector2d& p = corners_[other];
      // A corner at the same place is where the polygon touches itself.
      if (p == a || p == b || p == c) continue;
      if (turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0) return -0.5;
    }
    return area / longest;
  }

  std::vector<Eigen::Vector2d> corners_;  // in the polygon's plane
  std::vector<std::size_t> left_;         // of the polygon, in its order
};

}  // namespace

std::vector<std::array<std::size_t, 3>> triangulate(std::span<const Eigen::Vector3f> polygon) {
  if (polygon.size() < 3) return {};
  if (polygon.size() == 3) return {{0, 1, 2}};
  return EarCutter(polygon).cut();
}

}  // namespace roomwise::simulation
