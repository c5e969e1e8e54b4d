#include "roomwise/geometry/distance_transform.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "roomwise/base/random.h"

namespace roomwise::geometry {
namespace {

TEST(DistanceTransform, IsTheNearestOfAllCells) {
  RandomStream random(4);
  constexpr int kColumns = 23, kRows = 17;
  std::vector<double> cells(kColumns * kRows, kFarFromAll);
  for (int i = 0; i < 9; ++i) cells[random.index(cells.size())] = 0;
  const std::vector<double> distances = squared_distances(cells, kColumns, kRows);
  for (int i = 0; i < kColumns * kRows; ++i) {
    double nearest = kFarFromAll;
    for (int j = 0; j < kColumns * kRows; ++j) {
      if (cells[static_cast<std::size_t>(j)] != 0) continue;
      const double dx = i % kColumns - j % kColumns, dy = i / kColumns - j / kColumns;
      nearest = std::min(nearest, dx * dx + dy * dy);
    }
    EXPECT_EQ(distances[static_cast<std::size_t>(i)], nearest) << i;
  }
}

TEST(DistanceTransform, OfNothingIsFar) {
  for (const double distance : squared_distances(std::vector<double>(6, kFarFromAll), 3, 2)) {
    EXPECT_GE(distance, kFarFromAll);
  }
  EXPECT_TRUE(squared_distances({}, 0, 0).empty());
}

}  // namespace
}  // namespace roomwise::geometry
