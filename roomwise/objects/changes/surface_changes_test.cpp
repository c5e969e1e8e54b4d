#include "roomwise/objects/changes/surface_changes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/base/testing/testing.h"
#include "roomwise/objects/testing/test_room.h"

namespace roomwise::objects {
namespace {

using Eigen::Vector3d;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using testing::TestRoom;

const TestRoom::Thing kTable{"table", {0.8, 0.6, 0.35}, {1.2, 0.8, 0.7}};
const TestRoom::Thing kBox{"box", {-0.6, 0, 0.25}, {0.4, 0.4, 0.5}};

// A room by the walk that mapped it and by a visit; nothing finds anything in it by name.
class SurfaceChangesTest : public ::testing::Test {
 protected:
  static void look_at_all(TestRoom& room, double first_rad = 0) {
    room.look_around({0, 0.2, 0.4}, 10, 2.3, first_rad, 2 * std::numbers::pi, /*finds=*/false);
  }
  static std::vector<DepthView> views_of(TestRoom& room) {
    std::vector<DepthView> views;
    for (const ObservedKeyframe& one : room.keyframes()) {
      views.push_back({one.world_from_camera, &one.camera, &one.coarse_depth, kCoarseDepthStep_px});
    }
    return views;
  }
  [[nodiscard]] std::vector<SurfaceChange> find(const SurfaceChangeOptions& options = {}) {
    return find_surface_changes(views_of(map_), views_of(visit_), {Vector3d::UnitZ(), 0}, options,
                                pool_);
  }

  ThreadPool pool_{2};
  TestRoom map_, visit_;
};

TEST_F(SurfaceChangesTest, NothingChangesWhereAllStandsAsItStood) {
  map_.things = visit_.things = {kTable, kBox};
  look_at_all(map_);
  look_at_all(visit_, 0.3);
  EXPECT_THAT(find(), IsEmpty());
}

TEST_F(SurfaceChangesTest, WhatWentAndWhatCameHaveTheirPlaces) {
  const TestRoom::Thing elsewhere{"box", {-0.6, 1.4, 0.25}, {0.4, 0.4, 0.5}};
  map_.things = {kTable, kBox};
  visit_.things = {kTable, elsewhere};
  look_at_all(map_);
  look_at_all(visit_, 0.3);
  const auto changes = find();
  ASSERT_THAT(changes, SizeIs(2));
  for (const SurfaceChange& change : changes) {
    const TestRoom::Thing& thing = change.is_new ? elsewhere : kBox;
    EXPECT_LT((change.box_world.center() - thing.center).norm(), 0.1) << change.is_new;
    Vector3d edges = change.box_world.size_m;
    std::sort(edges.begin(), edges.end());
    EXPECT_NEAR(edges[2], 0.5, 0.1) << "down to the floor";
    EXPECT_NEAR(edges[0], 0.4, 0.1);
    EXPECT_GE(change.evidence.gone_share(), 0.9);
    EXPECT_GE(change.evidence.views, 2);
  }
  EXPECT_NE(changes[0].is_new, changes[1].is_new);
}

TEST_F(SurfaceChangesTest, WhatStandsOnATableIsNotTheTable) {
  const TestRoom::Thing vase{"vase", {0.8, 0.6, 0.85}, {0.25, 0.25, 0.3}};
  map_.things = {kTable};
  visit_.things = {kTable, vase};
  look_at_all(map_);
  look_at_all(visit_);
  const auto changes = find();
  ASSERT_THAT(changes, SizeIs(1));
  EXPECT_TRUE(changes[0].is_new);
  EXPECT_LT((changes[0].box_world.center() - vase.center).norm(), 0.1);
}

TEST_F(SurfaceChangesTest, WhatOneWalkDidNotLookAtHasNotChanged) {
  map_.things = {kTable, kBox};
  visit_.things = {kTable};
  look_at_all(map_);
  for (int i = 0; i < 5; ++i) visit_.look({1.5, 0.2 * i, 1.4}, {2.9, 0.2 * i, 1.0}, false);
  EXPECT_THAT(find(), IsEmpty()) << "the visit looks at the wall only";
}

TEST_F(SurfaceChangesTest, WhatIsHiddenHasNotChanged) {
  map_.things = {kBox};
  look_at_all(map_);
  // Behind a wall that is as near as things are seen from.
  visit_.things = {{"wall", {0.2, 0, 1.3}, {0.1, 5.9, 2.6}}};
  for (int i = 0; i < 5; ++i) visit_.look({1.8, 0.2 * i - 0.4, 1.4}, kBox.center, false);
  for (const SurfaceChange& change : find()) {
    EXPECT_TRUE(change.is_new) << "the wall is; what stands behind it may be there still";
  }
}

TEST_F(SurfaceChangesTest, ASinglePictureShowsNoChange) {
  map_.things = {kTable, kBox};
  visit_.things = {kTable};
  look_at_all(map_);
  visit_.look({0.6, -1.6, 1.4}, kBox.center, false);
  EXPECT_THAT(find(), IsEmpty());
  EXPECT_THAT(find({.min_through = 1}), SizeIs(1));
}

TEST_F(SurfaceChangesTest, WhatIsSmallIsLeftOut) {
  map_.things = {kTable, {"vase", {0.8, 0.6, 0.82}, {0.22, 0.22, 0.24}}};
  visit_.things = {kTable};
  look_at_all(map_);
  look_at_all(visit_);
  EXPECT_THAT(find(), SizeIs(1));
  EXPECT_THAT(find({.min_size_m = 0.4}), IsEmpty());
  EXPECT_THAT(find({.min_cells = 400}), IsEmpty());
}

TEST_F(SurfaceChangesTest, TheOrderOfViewsIsNoMatter) {
  map_.things = {kTable, kBox};
  visit_.things = {kTable};
  look_at_all(map_);
  look_at_all(visit_);
  auto before = views_of(map_), now = views_of(visit_);
  const auto one = find_surface_changes(before, now, {Vector3d::UnitZ(), 0}, {}, pool_);
  std::ranges::reverse(before);
  std::ranges::reverse(now);
  const auto other = find_surface_changes(before, now, {Vector3d::UnitZ(), 0}, {}, pool_);
  ASSERT_EQ(one.size(), other.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].is_new, other[i].is_new);
    EXPECT_LT((one[i].box_world.center() - other[i].box_world.center()).norm(), 1e-4);
  }
}

TEST_F(SurfaceChangesTest, WithoutViewsNothingChanged) {
  map_.things = {kBox};
  look_at_all(map_);
  EXPECT_THAT(find(), IsEmpty());
}

TEST(SurfaceChangeOptions, SaysWhatIsNoValue) {
  EXPECT_OK(SurfaceChangeOptions{}.validate());
  EXPECT_ERROR(SurfaceChangeOptions{.max_range_m = 0.1}.validate(), "max_range_m is 0.1");
  EXPECT_ERROR(SurfaceChangeOptions{.min_shown = 0}.validate(), "min_shown");
  EXPECT_ERROR(SurfaceChangeOptions{.min_through = 0}.validate(), "min_through");
  EXPECT_ERROR((SurfaceChangeOptions{.min_size_m = std::nan("")}.validate()), "min_size_m");
}

}  // namespace
}  // namespace roomwise::objects
