#include "roomwise/objects/changes/changes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/base/testing/testing.h"
#include "roomwise/objects/testing/test_room.h"

namespace roomwise::objects {
namespace {

using Eigen::Vector3d;
using testing::TestRoom;

const TestRoom::Thing kOldBed{"bed", {0.8, 1.2, 0.25}, {2.0, 1.4, 0.5}};
const TestRoom::Thing kOldChair{"chair", {-0.8, 0, 0.4}, {0.45, 0.45, 0.8}};

TestRoom::Thing moved(TestRoom::Thing thing, const Vector3d& by) {
  thing.center += by;
  return thing;
}

// Looks at all of a room that things stand in.
void look_at_all(TestRoom& room) {
  room.look_around({0, 0.4, 0.4}, 10, 2.3);
}

// A room by the walk that mapped it and by a visit; `find()` says what became of its things.
class ChangesTest : public ::testing::Test {
 protected:
  static std::vector<PlacedInstance> things_of(TestRoom& room) {
    std::vector<PlacedInstance> things;
    for (const Instance& instance : room.instances()) {
      things.push_back(placed_instance(instance, room.box_of(instance), room.keyframes(), kLevel));
    }
    return things;
  }
  static std::vector<DepthView> views_of(TestRoom& room) {
    std::vector<DepthView> views;
    for (const ObservedKeyframe& one : room.keyframes()) {
      views.push_back({one.world_from_camera, &one.camera, &one.coarse_depth, kCoarseDepthStep_px});
    }
    return views;
  }
  Changes find() {
    before_ = things_of(map_);
    now_ = things_of(visit_);
    return find_changes(before_, views_of(map_), now_, views_of(visit_), past_, {});
  }
  [[nodiscard]] const InstanceChange& state_of(const Changes& changes,
                                               const std::string& name) const {
    const auto at = std::ranges::find(before_, name, &PlacedInstance::name);
    EXPECT_NE(at, before_.end()) << name;
    return changes.before[static_cast<std::size_t>(at - before_.begin())];
  }

  inline static const GroundPlane kLevel{Vector3d::UnitZ(), 0};
  TestRoom map_, visit_;
  std::vector<PlacedInstance> before_, now_, past_;
};

TEST_F(ChangesTest, NothingChangesWhereNothingMoved) {
  map_.things = visit_.things = {kOldBed, kOldChair};
  look_at_all(map_);
  visit_.look_around({0, 0.4, 0.4}, 7, 2.1, 0.3);
  const Changes changes = find();
  ASSERT_EQ(changes.before.size(), 2U);
  for (const InstanceChange& state : changes.before) {
    EXPECT_EQ(state.state, ChangeState::kThere);
    EXPECT_TRUE(state.now.has_value());
    EXPECT_LT(state.evidence.gone_share(), 0.1);
  }
  EXPECT_TRUE(changes.arrived.empty());
}

TEST_F(ChangesTest, WhatIsLookedThroughIsGone) {
  map_.things = {kOldBed, kOldChair};
  visit_.things = {kOldBed};
  look_at_all(map_);
  look_at_all(visit_);
  const Changes changes = find();
  EXPECT_EQ(state_of(changes, "chair").state, ChangeState::kRemoved);
  EXPECT_FALSE(state_of(changes, "chair").now);
  EXPECT_GT(state_of(changes, "chair").evidence.gone_share(), 0.9);
  EXPECT_GE(state_of(changes, "chair").evidence.views, 5);
  EXPECT_EQ(state_of(changes, "bed").state, ChangeState::kThere);
}

TEST_F(ChangesTest, WhatDepthStillSeesIsThereThoughNothingFindsIt) {
  map_.things = visit_.things = {kOldChair};
  look_at_all(map_);
  visit_.look_around({0, 0.4, 0.4}, 8, 2.3, 0, 6, /*finds=*/false);
  const Changes changes = find();
  EXPECT_EQ(state_of(changes, "chair").state, ChangeState::kThere);
  EXPECT_FALSE(state_of(changes, "chair").now);
}

TEST_F(ChangesTest, WhatWasNotInViewIsNotKnownToBeGone) {
  map_.things = {kOldChair};
  look_at_all(map_);
  for (int i = 0; i < 5; ++i) visit_.look({1.5, 0.2 * i, 1.4}, {2.9, 0.2 * i, 1.0});
  EXPECT_EQ(state_of(find(), "chair").state, ChangeState::kUnobserved);
}

TEST_F(ChangesTest, WhatIsHiddenIsNotKnownToBeGone) {
  map_.things = {kOldChair};
  look_at_all(map_);
  visit_.things = {{"wall", {0.2, 0, 1.3}, {0.1, 5.9, 2.6}}};
  for (int i = 0; i < 5; ++i) visit_.look({1.8, 0.2 * i - 0.4, 1.4}, kOldChair.center, false);
  EXPECT_EQ(state_of(find(), "chair").state, ChangeState::kUnobserved);
}

TEST_F(ChangesTest, OneLookIsNotEnough) {
  map_.things = {kOldChair};
  look_at_all(map_);
  visit_.look({1.0, 0, 1.4}, kOldChair.center);
  EXPECT_EQ(state_of(find(), "chair").state, ChangeState::kUnobserved);
  visit_.look({0.9, 0.6, 1.4}, kOldChair.center);
  EXPECT_EQ(state_of(find(), "chair").state, ChangeState::kRemoved);
}

TEST_F(ChangesTest, WhatStandsWhereNothingStoodIsNew) {
  map_.things = {kOldBed};
  visit_.things = {kOldBed, kOldChair};
  look_at_all(map_);
  look_at_all(visit_);
  const Changes changes = find();
  ASSERT_EQ(changes.arrived.size(), 1U);
  EXPECT_EQ(now_[changes.arrived[0].now].name, "chair");
  EXPECT_GT(changes.arrived[0].evidence.gone_share(), 0.9);
}

TEST_F(ChangesTest, WhatStoodThereWithoutANameIsNotNew) {
  map_.things = visit_.things = {kOldChair};
  map_.look_around({0, 0.4, 0.4}, 10, 2.3, 0, 6, /*finds=*/false);
  look_at_all(visit_);
  const Changes changes = find();
  EXPECT_EQ(now_.size(), 1U);
  EXPECT_TRUE(changes.arrived.empty());
}

TEST_F(ChangesTest, WhatIsCalledOtherwiseNowIsNotNew) {
  map_.things = {kOldBed};
  visit_.things = {{"sofa", kOldBed.center, kOldBed.size_m}};
  look_at_all(map_);
  look_at_all(visit_);
  const Changes changes = find();
  EXPECT_EQ(state_of(changes, "bed").state, ChangeState::kThere);
  EXPECT_TRUE(changes.arrived.empty());
}

TEST_F(ChangesTest, GoneHereAndNewThereIsMoved) {
  map_.things = {kOldBed, kOldChair};
  visit_.things = {kOldBed, moved(kOldChair, {0.3, -1.0, 0})};
  look_at_all(map_);
  look_at_all(visit_);
  const Changes changes = find();
  const InstanceChange& chair = state_of(changes, "chair");
  EXPECT_EQ(chair.state, ChangeState::kMoved);
  ASSERT_TRUE(chair.now);
  EXPECT_LT((now_[*chair.now].box_world.center() - visit_.things[1].center).norm(), 0.08);
  EXPECT_TRUE(changes.arrived.empty());
  EXPECT_EQ(state_of(changes, "bed").state, ChangeState::kThere);
}

TEST_F(ChangesTest, AShortPushIsAMove) {
  map_.things = {kOldChair};
  visit_.things = {moved(kOldChair, {0.2, 0.1, 0})};
  look_at_all(map_);
  look_at_all(visit_);
  const Changes changes = find();
  EXPECT_EQ(state_of(changes, "chair").state, ChangeState::kMoved);
  EXPECT_TRUE(changes.arrived.empty());
}

TEST_F(ChangesTest, APushOfWhatIsNotFoundAgainIsNoticedToo) {
  map_.things = {kOldChair};
  visit_.things = {moved(kOldChair, {0.15, 0.1, 0})};
  look_at_all(map_);
  visit_.look_around({0, 0.4, 0.4}, 8, 2.3, 0, 6, /*finds=*/false);
  const Changes changes = find();
  const InstanceChange& chair = state_of(changes, "chair");
  EXPECT_EQ(chair.state, ChangeState::kShifted);
  EXPECT_FALSE(chair.now);
  // Of what is left the next such visit looks through little.
  PlacedInstance left = before_[0];
  left.surface_world = remaining_surface(before_[0].surface_world, views_of(visit_));
  EXPECT_LT(left.surface_world.size(), before_[0].surface_world.size());
  const Changes again =
      find_changes(std::vector{left}, views_of(map_), now_, views_of(visit_), past_, {});
  EXPECT_EQ(again.before[0].state, ChangeState::kThere);
}

TEST_F(ChangesTest, WhatIsFixedToTheHouseIsNotPushed) {
  map_.things = {{"sink", kOldChair.center, kOldChair.size_m}};
  visit_.things = {moved(map_.things[0], {0.15, 0.1, 0})};
  look_at_all(map_);
  visit_.look_around({0, 0.4, 0.4}, 8, 2.3, 0, 6, /*finds=*/false);
  EXPECT_EQ(state_of(find(), "sink").state, ChangeState::kThere);
}

TEST_F(ChangesTest, OfTwoThatMovedEachTakesTheNearerPlace) {
  const TestRoom::Thing other = moved(kOldChair, {1.6, -1.0, 0});
  map_.things = {kOldChair, other};
  visit_.things = {moved(kOldChair, {0, 0.9, 0}), moved(other, {0, -0.8, 0})};
  look_at_all(map_);
  map_.look_around({0, -0.6, 0.4}, 6, 2.1, 0.2);
  look_at_all(visit_);
  visit_.look_around({0, -0.6, 0.4}, 6, 2.1, 0.2);
  const Changes changes = find();
  ASSERT_EQ(before_.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    ASSERT_EQ(changes.before[i].state, ChangeState::kMoved);
    EXPECT_LT(
        (now_[*changes.before[i].now].box_world.center() - before_[i].box_world.center()).norm(),
        1.1);
  }
  EXPECT_TRUE(changes.arrived.empty());
}

TEST_F(ChangesTest, WhatComesBackIsNewThoughTheMapShowsIt) {
  map_.things = visit_.things = {kOldChair};
  look_at_all(map_);
  look_at_all(visit_);
  // An earlier visit took it out of the home.
  past_ = things_of(map_);
  before_.clear();
  now_ = things_of(visit_);
  const Changes changes = find_changes(before_, views_of(map_), now_, views_of(visit_), past_, {});
  ASSERT_EQ(changes.arrived.size(), 1U);
  EXPECT_TRUE(find_changes({}, views_of(map_), now_, views_of(visit_), {}, {}).arrived.empty());
}

TEST(FreeSpaceEvidences, WhatNoViewDecidesCountsAsThereWhereTheWholeSurfaceIsAskedFor) {
  const FreeSpaceEvidence evidence{.points = 10, .decided = 5, .gone = 4, .views = 2};
  EXPECT_DOUBLE_EQ(evidence.gone_share(), 0.8);
  EXPECT_DOUBLE_EQ(evidence.gone_share_of_whole(), 0.4);
  EXPECT_DOUBLE_EQ(FreeSpaceEvidence{}.gone_share_of_whole(), 0);
}

TEST(MatchByNameAndPlace, TakesTheNearestOfTheNameEachOnce) {
  const auto thing = [](const std::string& name, double x) {
    return PlacedInstance{name, {{Eigen::Quaterniond::Identity(), {x, 0, 0}}, {0.5, 0.5, 1}}, {}};
  };
  const std::vector past{thing("chair", 0), thing("chair", 0.3), thing("sofa", 2)};
  const std::vector things{thing("table", 0), thing("chair", 0.25), thing("chair", 5)};
  const auto matches = match_by_name_and_place(past, things);
  EXPECT_FALSE(matches[0]) << "taken by the other";
  EXPECT_EQ(matches[1], 1U);
  EXPECT_FALSE(matches[2]);
}

TEST(ChangeOptions, NamesTheFieldThatIsWrong) {
  EXPECT_OK(ChangeOptions{}.validate());
  EXPECT_ERROR(ChangeOptions{.min_decided = 2}.validate(), "min_decided");
  EXPECT_ERROR(ChangeOptions{.min_views = 0}.validate(), "min_views");
  EXPECT_ERROR(ChangeOptions{.min_gone = -1}.validate(), "min_gone");
  EXPECT_ERROR(ChangeOptions{.min_moved_gone_share = 1.5}.validate(), "min_moved_gone_share");
  EXPECT_ERROR(ChangeOptions{.min_shifted_gone_share = 7}.validate(), "min_shifted_gone_share");
  EXPECT_ERROR(ChangeOptions{.min_moved_distance_m = -1}.validate(), "min_moved_distance_m");
  EXPECT_ERROR(ChangeOptions{.same_place = -0.1}.validate(), "same_place");
}

}  // namespace
}  // namespace roomwise::objects
