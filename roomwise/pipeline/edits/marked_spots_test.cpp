#include "roomwise/pipeline/edits/marked_spots.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/pipeline/edits/undo_edit.h"
#include "roomwise/pipeline/stored/stored_edits.h"
#include "roomwise/pipeline/stored/stored_map.h"
#include "roomwise/pipeline/testing/mapped_room.h"

namespace roomwise::pipeline {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class MarkedSpots : public testing::MappedRoom {
 protected:
  Expected<home::EditId> mark(const std::string& name, const std::string& owner = "3",
                              const Eigen::Vector3d& where = {0.5, 0.1, 0.2}) {
    const auto place = spot_place(home_->keyframes().value(), where);
    return mark_spot(*home_, {0, name, owner, 1'700'000'000, place.value()});
  }
  std::vector<std::string> names() {
    std::vector<std::string> names;
    const auto spots = marked_spots(*home_).value();
    for (const MarkedSpot& one : spots) names.push_back(one.name);
    return names;
  }
  Eigen::Vector3d where(const std::string& name) {
    const auto spots = marked_spots(*home_).value();
    const auto found = std::ranges::find(spots, name, &MarkedSpot::name);
    return point_world(found->place, home_->keyframes().value()).value();
  }
};

TEST_F(MarkedSpots, AreKeptWithTheirOwnerAndPlace) {
  ASSERT_OK(mark("my chair"));
  ASSERT_OK(mark("", "3"));
  EXPECT_THAT(names(), ElementsAre("", "my chair"));
  EXPECT_LT((where("my chair") - Eigen::Vector3d(0.5, 0.1, 0.2)).norm(), 1e-9);
  const MarkedSpot spot = marked_spots(*home_)->back();
  EXPECT_TRUE(spot.is_known_to("3"));
  EXPECT_FALSE(spot.is_known_to("4"));
  EXPECT_EQ(spot.marked_s, 1'700'000'000);
}

TEST_F(MarkedSpots, MarkedAgainStandElsewhereAndOthersKeepTheirs) {
  ASSERT_OK(mark("my chair"));
  ASSERT_OK(mark("my chair", "4"));
  ASSERT_OK(mark("My Chair", "3", {1, 0, 0}));
  EXPECT_THAT(names(), ElementsAre("My Chair", "my chair"));
  EXPECT_LT((where("My Chair") - Eigen::Vector3d(1, 0, 0)).norm(), 1e-9);
}

TEST_F(MarkedSpots, MoveWithTheMap) {
  ASSERT_OK(mark("my chair"));
  const geometry::RigidTransform moved{Eigen::Quaterniond::Identity(), Eigen::Vector3d(0, 0, 2)};
  std::map<home::KeyframeId, home::KeyframePose> poses;
  const auto keyframes = home_->keyframes().value();
  for (const home::Keyframe& one : keyframes) {
    poses[one.id] = {moved * one.pose.world_from_keyframe, 0};
  }
  ASSERT_OK(home_->replace_poses(poses));
  EXPECT_LT((where("my chair") - Eigen::Vector3d(0.5, 0.1, 2.2)).norm(), 1e-9);
}

// The world's z points up; the upper storey is drawn `apart_m` beside the lower one.
fusion::GravityAlignedFrame two_storeys(double apart_m) {
  fusion::GravityAlignedFrame frame;
  frame.gravity_from_world = {Eigen::Quaterniond::Identity(), Eigen::Vector3d(0, 0, 1)};
  fusion::Storey upper;
  upper.floor_m = 2.5;
  upper.plan_from_gravity = {apart_m, 0};
  upper.plan_from_x_m = apart_m / 2;
  frame.storeys = fusion::Storeys({fusion::Storey{}, upper});
  return frame;
}

TEST_F(MarkedSpots, StayOnTheirStoreyWhereverItIsDrawn) {
  const auto keyframe = [](home::KeyframeId id, const Eigen::Vector3d& at_world) {
    home::Keyframe one;
    one.id = id;
    one.pose = {{Eigen::Quaterniond::Identity(), at_world}, 0};
    return one;
  };
  // Below, above the same place, and on the lower floor where the plan draws the upper one.
  const std::vector<home::Keyframe> keyframes{keyframe(0, {1, 0, 0.5}), keyframe(1, {1, 0, 3}),
                                              keyframe(2, {13, 0, 0.5})};
  const auto frame = two_storeys(12);
  const Eigen::Vector3d upstairs_plan(13.2, 0.1, 1.4);
  const auto place = spot_place_on_plan(keyframes, frame, upstairs_plan);
  ASSERT_OK(place);
  EXPECT_EQ(place->keyframe, 1U) << "it hangs where somebody walked upstairs";
  EXPECT_LT((*point_world(*place, keyframes) - Eigen::Vector3d(1.2, 0.1, 2.9)).norm(), 1e-9);
  EXPECT_LT((*point_on_plan(*place, keyframes, frame) - upstairs_plan).norm(), 1e-9);
  const auto wider = point_on_plan(*place, keyframes, two_storeys(20));
  ASSERT_TRUE(wider);
  EXPECT_LT((*wider - Eigen::Vector3d(21.2, 0.1, 1.4)).norm(), 1e-9)
      << "a further walk made the plan wider";
  const auto above = spot_place(keyframes, keyframes[1].pose.world_from_keyframe.translation);
  EXPECT_NEAR(point_on_plan(*above, keyframes, frame)->x(), 13, 1e-9) << "marked by its key-frame";
}

TEST_F(MarkedSpots, AreRenamedAndForgotten) {
  const auto chair = mark("my chair");
  ASSERT_OK(chair);
  ASSERT_OK(mark("stairs"));
  EXPECT_ERROR(rename_spot(*home_, *chair, "stairs"), "another place is called stairs");
  EXPECT_ERROR(rename_spot(*home_, *chair, ""), "the name is empty");
  ASSERT_OK(rename_spot(*home_, *chair, "my seat"));
  EXPECT_THAT(names(), ElementsAre("my seat", "stairs"));
  ASSERT_OK(forget_spot(*home_, *chair));
  EXPECT_TRUE(home_->owes_erasing().value()) << "until no byte of it is left";
  EXPECT_ERROR(forget_spot(*home_, *chair), "there is no spot");
  EXPECT_THAT(names(), ElementsAre("stairs"));
}

TEST_F(MarkedSpots, AreNotCalledAsAThingOrARoom) {
  ASSERT_OK(home_->replace_concepts(rooms::Concepts::standard()));
  EXPECT_ERROR(mark("chair"), "say whose or which it is");
  ASSERT_OK(home_->replace_rooms(std::vector<rooms::Room>{{"nook", "study"}}));
  EXPECT_ERROR(mark("nook"), "is a room of this home");
  EXPECT_ERROR(mark("my\nchair"), "cannot be spoken");
}

TEST_F(MarkedSpots, AreNoChangesOfThingsOrRooms) {
  const auto chair = mark("my chair");
  ASSERT_OK(chair);
  EXPECT_THAT(stored_edits(*home_).value(), IsEmpty());
  EXPECT_ERROR(undo_edit(*home_, *chair), "");
  EXPECT_THAT(marked_spots(*home_).value(), SizeIs(1));
}

TEST_F(MarkedSpots, LoseTheirPlaceWithTheOnlyWalkThatShowsIt) {
  ASSERT_OK(mark("my chair"));
  ASSERT_OK(forget_walk(*home_, home_->recordings()->front().id));
  const auto spots = marked_spots(*home_);
  ASSERT_OK(spots);
  ASSERT_THAT(*spots, SizeIs(1));
  EXPECT_EQ(point_world(spots->front().place, home_->keyframes().value()), std::nullopt);
}

}  // namespace
}  // namespace roomwise::pipeline
