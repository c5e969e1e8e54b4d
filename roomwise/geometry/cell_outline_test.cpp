#include "roomwise/geometry/cell_outline.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <string>

#include "roomwise/base/random.h"

namespace roomwise::geometry {
namespace {

CellSet cells_of(const std::vector<std::string>& rows) {
  CellSet cells{static_cast<int>(rows.front().size()), static_cast<int>(rows.size()), {}};
  for (const std::string& row : rows) {
    for (const char c : row) cells.has.push_back(c == '#');
  }
  return cells;
}

double area(const CellRing& ring) {
  double twice = 0;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Eigen::Vector2i &a = ring[i], &b = ring[(i + 1) % ring.size()];
    twice += a.x() * b.y() - b.x() * a.y();
  }
  return twice / 2;
}

// By the edges that a ray from the point to the right crosses.
bool is_within(const CellRing& ring, double x, double y) {
  bool within = false;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Eigen::Vector2i &a = ring[i], &b = ring[(i + 1) % ring.size()];
    if ((a.y() > y) != (b.y() > y) && a.x() > x) within = !within;
  }
  return within;
}

bool is_within(const CellPolygon& polygon, double x, double y) {
  bool within = is_within(polygon.outer, x, y);
  for (const CellRing& hole : polygon.holes) within = within && !is_within(hole, x, y);
  return within;
}

void expect_simple(const CellRing& ring) {
  std::set<std::pair<int, int>> corners;
  for (const Eigen::Vector2i& corner : ring) corners.insert({corner.x(), corner.y()});
  EXPECT_EQ(corners.size(), ring.size()) << "a corner is passed twice";
}

TEST(CellOutlines, ASquareHasFourCorners) {
  const auto polygons = cell_outlines(cells_of({"....", ".##.", ".##.", "...."}));
  ASSERT_EQ(polygons.size(), 1U);
  EXPECT_THAT(polygons[0].outer,
              ::testing::UnorderedElementsAre(Eigen::Vector2i(1, 1), Eigen::Vector2i(3, 1),
                                              Eigen::Vector2i(3, 3), Eigen::Vector2i(1, 3)));
  EXPECT_EQ(area(polygons[0].outer), 4) << "counter-clockwise";
  EXPECT_TRUE(polygons[0].holes.empty());
}

TEST(CellOutlines, NothingHasNone) {
  EXPECT_TRUE(cell_outlines(cells_of({"..", ".."})).empty());
  EXPECT_TRUE(cell_outlines({}).empty());
}

TEST(CellOutlines, CellsThatTouchByACornerAreTwoPolygons) {
  EXPECT_EQ(cell_outlines(cells_of({"#.", ".#"})).size(), 2U);
}

TEST(CellOutlines, HolesThatTouchByACornerAreTwoRings) {
  const auto polygons = cell_outlines(cells_of({"####", "#.##", "##.#", "####"}));
  ASSERT_EQ(polygons.size(), 1U);
  ASSERT_EQ(polygons[0].holes.size(), 2U);
  EXPECT_EQ(area(polygons[0].holes[0]), -1) << "clockwise";
}

TEST(CellOutlines, AHoleThatTouchesTheOutsideByACornerIsARingOfItsOwn) {
  const auto polygons = cell_outlines(cells_of({".##", "#.#", "###"}));
  ASSERT_EQ(polygons.size(), 1U);
  expect_simple(polygons[0].outer);
  EXPECT_EQ(polygons[0].holes.size(), 1U);
}

TEST(CellOutlines, HaveJustTheCellsWithinThem) {
  RandomStream random(7);
  for (int round = 0; round < 50; ++round) {
    CellSet cells{12, 9, std::vector<bool>(12 * 9)};
    for (std::size_t i = 0; i < cells.has.size(); ++i) cells.has[i] = random.uniform() < 0.6;
    const auto polygons = cell_outlines(cells);
    for (const CellPolygon& polygon : polygons) {
      EXPECT_GT(area(polygon.outer), 0);
      expect_simple(polygon.outer);
      for (const CellRing& hole : polygon.holes) {
        EXPECT_LT(area(hole), 0);
        expect_simple(hole);
      }
    }
    for (int row = 0; row < cells.rows; ++row) {
      for (int column = 0; column < cells.columns; ++column) {
        const auto count = std::ranges::count_if(polygons, [&](const CellPolygon& polygon) {
          return is_within(polygon, column + 0.5, row + 0.5);
        });
        EXPECT_EQ(count, cells.at(column, row) ? 1 : 0) << column << ' ' << row;
      }
    }
  }
}

}  // namespace
}  // namespace roomwise::geometry
