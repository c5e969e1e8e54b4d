#include "roomwise/geometry/drawing_direction.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>
#include <set>
#include <utility>
#include <vector>

namespace roomwise::geometry {
namespace {

using Eigen::Vector2d;

constexpr double kDegree_rad = std::numbers::pi / 180;

// The walls of a room of 6 m by 3 m whose longer side runs along `degrees`.
std::vector<Vector2d> walls_along(double degrees) {
  const Eigen::Rotation2Dd turn(degrees * kDegree_rad);
  std::vector<Vector2d> walls;
  for (double s = 0; s <= 1; s += 0.01) {
    for (const Vector2d& point :
         {Vector2d(6 * s, 0), Vector2d(6 * s, 3), Vector2d(0, 3 * s), Vector2d(6, 3 * s)}) {
      walls.emplace_back(turn * point);
    }
  }
  return walls;
}

TEST(DrawingDirection, IsAlongTheLongerSideFromWhereTheWalkBegins) {
  for (const double degrees : {0.0, 30.0, 75.0, 120.0, -100.0}) {
    const Eigen::Rotation2Dd turn(degrees * kDegree_rad);
    const auto walls = walls_along(degrees);
    const double from_left = drawing_direction_rad(walls, turn * Vector2d(1, 1.5));
    EXPECT_NEAR(std::remainder(from_left - degrees * kDegree_rad, 2 * std::numbers::pi), 0, 0.03)
        << degrees;
    const double from_right = drawing_direction_rad(walls, turn * Vector2d(5, 1.5));
    EXPECT_NEAR(std::abs(std::remainder(from_right - from_left, 2 * std::numbers::pi)),
                std::numbers::pi, 1e-6);
  }
}

TEST(DrawingDirection, OfCellsIsThatOfTheWallsAndNotOfTheGrid) {
  constexpr double kCell_m = 0.05;
  for (const double degrees : {20.0, 46.0}) {
    std::set<std::pair<int, int>> cells;
    for (const Vector2d& point : walls_along(degrees)) {
      // As thick as what is seen of walls.
      for (const double thick_m : {0.0, 0.04, 0.08}) {
        const Eigen::Array2d at = ((point.array() + thick_m) / kCell_m).floor();
        cells.emplace(static_cast<int>(at.x()), static_cast<int>(at.y()));
      }
    }
    std::vector<Vector2d> middles;
    for (const auto& [x, y] : cells) middles.push_back(kCell_m * Vector2d(x + 0.5, y + 0.5));
    const Vector2d begin = Eigen::Rotation2Dd(degrees * kDegree_rad) * Vector2d(1, 1.5);
    const double right_rad = drawing_direction_rad(middles, begin, kCell_m);
    EXPECT_NEAR(right_rad, degrees * kDegree_rad, 2.1 * kDegree_rad);
  }
}

TEST(DrawingDirection, OfNothingIsX) {
  EXPECT_EQ(drawing_direction_rad({}, {3, 4}), 0);
}

}  // namespace
}  // namespace roomwise::geometry
