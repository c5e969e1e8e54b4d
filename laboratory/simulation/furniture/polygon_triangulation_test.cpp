#include "laboratory/simulation/furniture/polygon_triangulation.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace roomwise::simulation {
namespace {

using Polygon = std::vector<Eigen::Vector3f>;

// The areas of the triangles that turn as the polygon does, less those that do not.
double area(const Polygon& polygon, bool signed_by_turn) {
  double sum = 0;
  for (const auto& [a, b, c] : triangulate(polygon)) {
    const Eigen::Vector3f cross = (polygon[b] - polygon[a]).cross(polygon[c] - polygon[a]);
    sum += 0.5 * (signed_by_turn ? cross.z() : cross.norm());
  }
  return sum;
}

// Covered once, without gaps and without overlap.
void expect_covered(const Polygon& polygon, double expected) {
  EXPECT_EQ(triangulate(polygon).size(), polygon.size() - 2);
  EXPECT_NEAR(area(polygon, true), expected, 1e-5);
  EXPECT_NEAR(area(polygon, false), expected, 1e-5);
}

TEST(PolygonTriangulation, CoversConvexPolygons) {
  expect_covered({{0, 0, 0}, {2, 0, 0}, {2, 1, 0}}, 1);
  expect_covered({{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0}}, 2);
  expect_covered({{0, 0, 0}, {2, 0, 0}, {3, 1, 0}, {2, 2, 0}, {0, 2, 0}}, 5);
}

TEST(PolygonTriangulation, CoversConcavePolygons) {
  expect_covered({{0, 0, 0}, {2, 1, 0}, {4, 0, 0}, {2, 4, 0}}, 6);  // an arrow head
  expect_covered(
      {{0, 0, 0}, {3, 0, 0}, {3, 3, 0}, {2, 3, 0}, {2, 1, 0}, {1, 1, 0}, {1, 3, 0}, {0, 3, 0}},
      7);  // a U
  // A star, from each of its corners first.
  Polygon star;
  for (int i = 0; i < 10; ++i) {
    const double angle = i * 0.6283185307179586, radius = i % 2 == 0 ? 2 : 0.5;
    star.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0);
  }
  for (std::size_t i = 0; i < star.size(); ++i) {
    expect_covered(star, 10 * 0.5 * 2 * 0.5 * std::sin(0.6283185307179586));
    std::rotate(star.begin(), star.begin() + 1, star.end());
  }
}

TEST(PolygonTriangulation, CoversWhatIsAroundAHoleThatACutLeadsTo) {
  expect_covered({{0, 0, 0},
                  {4, 0, 0},
                  {4, 4, 0},
                  {0, 4, 0},
                  {0, 0, 0},
                  {1, 1, 0},
                  {1, 3, 0},
                  {3, 3, 0},
                  {3, 1, 0},
                  {1, 1, 0}},
                 12);
}

TEST(PolygonTriangulation, CoversPolygonsWithCornersOnAStraightSide) {
  expect_covered({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {0, 1, 0}}, 2);
}

TEST(PolygonTriangulation, TakesAnythingForAPolygon) {
  EXPECT_TRUE(triangulate({}).empty());
  EXPECT_TRUE(triangulate(Polygon{{0, 0, 0}, {1, 0, 0}}).empty());
  EXPECT_EQ(triangulate(Polygon(5, {1, 2, 3})).size(), 3U);  // all corners at one place
  EXPECT_EQ(triangulate(Polygon{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}).size(), 2U);
  EXPECT_EQ(triangulate(Polygon{{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}}).size(), 2U);
}

}  // namespace
}  // namespace roomwise::simulation
