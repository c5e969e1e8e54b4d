#include "roomwise/mapping/backend/refinement_windows.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace roomwise::mapping {
namespace {

using geometry::RigidTransform;

// A key-frame each half metre along a corridor, and as many on the way back.
std::vector<RigidTransform> there_and_back(std::size_t count) {
  std::vector<RigidTransform> poses;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t place = std::min(i, count - 1 - i);
    poses.push_back({Eigen::Quaterniond::Identity(), {0.5 * static_cast<double>(place), 0, 0}});
  }
  return poses;
}

TEST(RefinementWindows, EveryKeyframeIsMovedInOneWindow) {
  const auto poses = there_and_back(100);
  const std::vector<std::size_t> groups(100, 0);
  std::multiset<KeyframeId> moved;
  for (const RefinementWindow& window : refinement_windows(poses, groups, 16, 8)) {
    EXPECT_LE(window.own.size(), 16U);
    EXPECT_LE(window.around.size(), 8U);
    EXPECT_TRUE(std::ranges::is_sorted(window.own));
    EXPECT_TRUE(std::ranges::is_sorted(window.around));
    moved.insert(window.own.begin(), window.own.end());
  }
  EXPECT_EQ(moved.size(), 100U);
  EXPECT_EQ(std::set<KeyframeId>(moved.begin(), moved.end()).size(), 100U);
}

TEST(RefinementWindows, BothVisitsOfAPlaceAreInOneWindow) {
  const auto windows =
      refinement_windows(there_and_back(100), std::vector<std::size_t>(100, 0), 20, 10);
  ASSERT_GE(windows.size(), 5U);
  EXPECT_THAT(windows[0].own, ::testing::IsSupersetOf({0U, 1U, 2U, 97U, 98U, 99U}));
}

TEST(RefinementWindows, ThoseAroundShowTheSameAndAreNotItsOwn) {
  const auto poses = there_and_back(100);
  for (const RefinementWindow& window :
       refinement_windows(poses, std::vector<std::size_t>(100, 0), 20, 10)) {
    for (const KeyframeId id : window.around) {
      EXPECT_THAT(window.own, ::testing::Not(::testing::Contains(id)));
      EXPECT_TRUE(std::ranges::any_of(window.own, [&](KeyframeId own) {
        return (poses[own].inverse() * poses[id]).distance_m() <= 3;
      }));
    }
  }
}

TEST(RefinementWindows, ComponentsShowNothingOfEachOther) {
  std::vector<std::size_t> groups(100, 0);
  std::fill(groups.begin() + 50, groups.end(), 1);
  for (const RefinementWindow& window : refinement_windows(there_and_back(100), groups, 10, 10)) {
    for (const KeyframeId id : window.around) EXPECT_EQ(groups[id], groups[window.own.front()]);
  }
}

TEST(RefinementWindows, PlacesApartFillOneWindow) {
  std::vector<RigidTransform> poses;
  for (int i = 0; i < 30; ++i) poses.push_back({Eigen::Quaterniond::Identity(), {9.0 * i, 0, 0}});
  const auto windows = refinement_windows(poses, std::vector<std::size_t>(30, 0), 10, 10);
  ASSERT_EQ(windows.size(), 3U);
  EXPECT_EQ(windows[1].own.front(), 10U);
  EXPECT_TRUE(windows[1].around.empty());
}

TEST(RefinementWindows, AnEmptyMapHasNone) {
  EXPECT_TRUE(refinement_windows({}, {}, 10, 10).empty());
}

}  // namespace
}  // namespace roomwise::mapping
