#include "roomwise/pipeline/exports/floor_places.h"

#include <gmock/gmock.h>

namespace roomwise::pipeline {
namespace {

using fusion::FloorCell;

// A floor of cells of 10 cm, '.' free and '#' occupied, the first line the last row.
fusion::FloorGrid grid_of(const std::vector<std::string>& lines) {
  image::Image<FloorCell> cells(static_cast<int>(lines.front().size()),
                                static_cast<int>(lines.size()));
  for (int row = 0; row < cells.height(); ++row) {
    const std::string& line = lines[lines.size() - 1 - static_cast<std::size_t>(row)];
    for (int column = 0; column < cells.width(); ++column) {
      const char c = line[static_cast<std::size_t>(column)];
      cells.at(column, row) = c == '.'   ? FloorCell::kFree
                              : c == '#' ? FloorCell::kOccupied
                                         : FloorCell::kUnknown;
    }
  }
  return {Eigen::Vector2d::Zero(), 0.1, std::move(cells)};
}

TEST(FloorPlaces, AreTheWidestPointsOfHalfMetresOfFloor) {
  const FloorPlaces found = floor_places(grid_of(std::vector<std::string>(10, "..........")), {});
  ASSERT_EQ(found.places.size(), 4U);
  EXPECT_EQ(found.edges.size(), 4U) << "places that touch by a side";
  EXPECT_FALSE(found.places.front().room);
}

TEST(FloorPlaces, AWallParts) {
  const FloorPlaces found =
      floor_places(grid_of(std::vector<std::string>(10, "..........#..........")), {});
  std::size_t left = 0;
  for (const FloorPlace& place : found.places) {
    EXPECT_GE(place.clearance_m, 0.22);
    if (place.middle_plan.x() < 1) ++left;
  }
  EXPECT_GT(left, 0U);
  EXPECT_LT(left, found.places.size());
  for (const auto& [one, other] : found.edges) {
    EXPECT_EQ(found.places[one].middle_plan.x() < 1, found.places[other].middle_plan.x() < 1);
    EXPECT_LT(one, other);
  }
}

TEST(FloorPlaces, WhatIsUnknownOrTooNarrowIsNone) {
  EXPECT_TRUE(floor_places(grid_of({"#...#", "#...#", "#...#"}), {}).places.empty());
  EXPECT_TRUE(floor_places(grid_of(std::vector<std::string>(10, "          ")), {}).places.empty());
}

}  // namespace
}  // namespace roomwise::pipeline
