#include "laboratory/simulation/home/free_space.h"

#include <gtest/gtest.h>

#include <numbers>

namespace roomwise::simulation {
namespace {

constexpr double kCell = FreeSpace::kCellSize;

// A room of 4 x 3 m.
std::vector<Rectangle> room() {
  return {Rectangle{{0, 0}, {4, 3}}};
}
Footprint block(double x, double y, double half_x, double half_y, double yaw = 0) {
  Footprint footprint;
  footprint.center = {x, y};
  footprint.half_size = {half_x, half_y};
  footprint.yaw_rad = yaw;
  footprint.top_m = 1;
  return footprint;
}

TEST(FreeSpace, ClearanceIsTheDistanceToWallsAndThings) {
  const std::vector<Footprint> things{block(3, 1.5, 0.5, 0.5)};
  const FreeSpace space(room(), things);
  EXPECT_NEAR(space.clearance_m(Eigen::Vector2d(0.7, 1.5)), 0.7, kCell);
  EXPECT_NEAR(space.clearance_m(Eigen::Vector2d(2.0, 1.5)), 0.5, kCell);
  EXPECT_NEAR(space.clearance_m(Eigen::Vector2d(2.2, 0.7)), std::hypot(0.3, 0.3), 2 * kCell);
  EXPECT_EQ(space.clearance_m(Eigen::Vector2d(3, 1.5)), 0);
  EXPECT_EQ(space.clearance_m(Eigen::Vector2d(-3, 1.5)), 0);
}

TEST(FreeSpace, ClearanceOfATurnedThing) {
  const std::vector<Footprint> things{block(2, 1.5, 0.5, 0.1, std::numbers::pi / 4)};
  const FreeSpace space(room(), things);
  const double diagonal = std::sqrt(0.5);
  const Eigen::Vector2d beside =
      Eigen::Vector2d(2, 1.5) + 0.6 * Eigen::Vector2d(-diagonal, diagonal);
  EXPECT_NEAR(space.clearance_m(beside), 0.5, kCell);
}

TEST(FreeSpace, AWayGoesAroundAThing) {
  const std::vector<Footprint> things{block(2, 1, 0.2, 1)};  // leaves 1 m at the top
  const FreeSpace space(room(), things);
  const auto way = space.path({0.6, 0.6}, {3.4, 0.6}, 0.3);
  ASSERT_TRUE(way);
  double highest = 0;
  for (const Eigen::Vector2d& point : *way) {
    EXPECT_GE(space.clearance_m(point), 0.3);
    highest = std::max(highest, point.y());
  }
  EXPECT_GT(highest, 2.25);
  EXPECT_LT((way->front() - Eigen::Vector2d(0.6, 0.6)).norm(), kCell);
  EXPECT_LT((way->back() - Eigen::Vector2d(3.4, 0.6)).norm(), kCell);
  for (std::size_t i = 1; i < way->size(); ++i) {
    EXPECT_LT(((*way)[i] - (*way)[i - 1]).norm(), 1.5 * kCell);
  }
}

TEST(FreeSpace, ThereIsNoWayThroughATooNarrowGap) {
  const std::vector<Footprint> things{block(2, 1.25, 0.2, 1.25)};  // leaves 0.5 m
  const FreeSpace space(room(), things);
  EXPECT_FALSE(space.path({0.6, 0.6}, {3.4, 0.6}, 0.3));
  EXPECT_TRUE(space.path({0.6, 0.6}, {3.4, 0.6}, 0.15));
  const std::vector<bool> reached = space.reachable_from({0.6, 0.6}, 0.3);
  for (int row = 0; row < space.rows(); ++row) {
    for (int column = 0; column < space.columns(); ++column) {
      if (!reached[static_cast<std::size_t>(row * space.columns() + column)]) continue;
      EXPECT_LT(space.cell_center(column, row).x(), 2);
    }
  }
}

TEST(FreeSpace, AThinLeafIsABarrier) {
  const std::vector<Footprint> things{block(2, 1.5, 0.02, 1.5, 0.001)};
  const FreeSpace space(room(), things);
  EXPECT_FALSE(space.path({0.6, 0.6}, {3.4, 0.6}, 0.05));
}

}  // namespace
}  // namespace roomwise::simulation
