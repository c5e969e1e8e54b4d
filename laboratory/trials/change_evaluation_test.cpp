#include "laboratory/trials/change_evaluation.h"

#include <gmock/gmock.h>

#include "laboratory/simulation/home/ground_truth.h"
#include "roomwise/home/testing/sample_home.h"
#include "roomwise/image/codec.h"
#include "roomwise/pipeline/stored/stored_map.h"
#include "roomwise/pipeline/testing/synthetic_walk.h"

namespace roomwise::trials {
namespace {

using Eigen::Vector3d;
using objects::ChangeState;
using simulation::ObjectTruth;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

// A home whose map lies turned and shifted against the truth of its walk, and what was true in that
// walk and in a later one.
class ChangeEvaluationTest : public ::testing::Test {
 protected:
  void SetUp() override {
    home_.emplace(home::Home::create(folder_ / "a.home").value());
    ROOMWISE_MUST(home_->add_recording(home::testing::sample_recording()));
    ROOMWISE_MUST(home_->add_network(home::testing::sample_network()));
    ROOMWISE_MUST(home_->replace_concepts(rooms::Concepts::standard()));
    for (home::KeyframeId id = 0; id < 8; ++id) {
      home::MapCommit step = home::testing::sample_commit(1, 1, id);
      const auto time_of = [](std::uint64_t frame) {
        return static_cast<TimestampNs>(frame + 1) * 100'000'000;
      };
      for (home::Frame& frame : step.frames) frame.timestamp_ns = time_of(frame.index);
      step.keyframes[0].timestamp_ns = time_of(step.keyframes[0].frame_index);
      step.keyframes[0].pose.component = 0;
      step.keyframes[0].images.color = picture_of(static_cast<int>(id));
      ROOMWISE_MUST(home_->commit(step));
    }
    std::filesystem::create_directories(mapped());
    std::filesystem::create_directories(visit());
    pipeline::testing::write_mapped_pictures(*home_, mapped());
    recording::Trajectory truth = pipeline::stored_trajectory(*home_).value();
    for (recording::StampedPose& pose : truth) {
      pose.world_from_camera = truth_from_world_ * pose.world_from_camera;
    }
    ROOMWISE_MUST(recording::write_trajectory(mapped() / "groundtruth.txt", truth));
  }
  static Bytes picture_of(int red) {
    return image::encode_png(image::ColorImage(2, 2, {static_cast<std::uint8_t>(red), 0, 0}));
  }
  std::filesystem::path mapped() { return folder_ / "mapped"; }
  std::filesystem::path visit() { return folder_ / "visit"; }

  // A cube of 0.4 m that so many frames show well.
  static ObjectTruth cube(const std::string& name, const std::string& label, double x_m,
                          std::uint64_t frames) {
    ObjectTruth object;
    object.name = name;
    object.kind = object.label = label;
    object.room = "hall";
    object.center_m = {x_m, 0, 0.2};
    object.size_m = Vector3d::Constant(0.4);
    for (std::uint64_t frame = 0; frame < frames; ++frame) {
      object.seen.push_back({frame, 4000, 0.01});
    }
    return object;
  }
  // Where the home says that something stands: at this place of the truth.
  std::optional<geometry::OrientedBox> box_at(double x_m) {
    const geometry::RigidTransform truth_from_box{Eigen::Quaterniond::Identity(), {x_m, 0, 0.2}};
    return geometry::OrientedBox{truth_from_world_.inverse() * truth_from_box,
                                 Vector3d::Constant(0.3)};
  }
  void say(const std::string& name, ChangeState state, std::optional<double> before_x_m,
           std::optional<double> now_x_m) {
    pipeline::ThingUpdate thing;
    thing.name = name;
    thing.state = state;
    thing.is_new = !before_x_m;
    if (before_x_m) thing.before = box_at(*before_x_m);
    if (now_x_m) thing.now = box_at(*now_x_m);
    update_.things.push_back(thing);
  }
  void say_unnamed(bool is_new, double x_m) {
    update_.unnamed.push_back({is_new, *box_at(x_m), "", "", false, {}});
  }
  // A plan with a door at this place of the truth that stands open so far.
  static void write_plan(const std::filesystem::path& folder, double open_rad) {
    simulation::HomeModel home;
    home.rooms.resize(1);
    home.rooms[0].name = "hall";
    simulation::Door door;
    door.opening.center = {10, 0};
    door.opening.width_m = 0.9;
    door.opening.top_m = 2;
    door.open_rad = open_rad;
    home.doors.push_back(door);
    ROOMWISE_MUST(simulation::write_floor_plan(folder / "floorplan.json", home));
  }
  Expected<ChangeEvaluation> evaluate(const std::vector<ObjectTruth>& before,
                                      const std::vector<ObjectTruth>& now) {
    ROOMWISE_RETURN_IF_ERROR(simulation::write_objects_truth(mapped() / "objects.json", before));
    ROOMWISE_RETURN_IF_ERROR(simulation::write_objects_truth(visit() / "objects.json", now));
    write_plan(mapped(), 1.4);
    write_plan(visit(), door_now_rad_);
    return evaluate_changes(*home_, mapped(), visit(), update_, 0.1);
  }

  roomwise::testing::ScratchFolder folder_;
  std::optional<home::Home> home_;
  geometry::RigidTransform truth_from_world_{
      Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Vector3d::UnitZ())), {3, -2, 1}};
  pipeline::HomeUpdate update_;
  double door_now_rad_ = 1.4;
};

TEST_F(ChangeEvaluationTest, WhatMovedCameAndWentIsNoticed) {
  say("sofa", ChangeState::kMoved, 0, 1);
  say("chair", ChangeState::kRemoved, 2, {});
  say("lamp", ChangeState::kThere, {}, 4);
  say("bed", ChangeState::kThere, 6, 6);
  const auto result = evaluate(
      {cube("sofa 1", "sofa", 0, 4), cube("chair 1", "chair", 2, 4), cube("bed 1", "bed", 6, 4)},
      {cube("sofa 1", "sofa", 1, 3), cube("lamp 1", "lamp", 4, 3), cube("bed 1", "bed", 6, 3)});
  ASSERT_OK(result);
  EXPECT_EQ(result->expected(), 3U);
  EXPECT_EQ(result->noticed(), 3U);
  EXPECT_EQ(result->known(), 2U) << "the lamp was not there to be known";
  EXPECT_EQ(result->known_noticed(), 2U);
  EXPECT_EQ(result->right, 3U);
  EXPECT_THAT(result->wrong, IsEmpty());
  EXPECT_EQ(result->unchanged, 1U);
  ASSERT_EQ(result->changes.size(), 3U);
  EXPECT_EQ(result->changes[0].name, "chair 1");
  EXPECT_EQ(result->changes[0].state, ChangeState::kRemoved);
  EXPECT_THAT(result->changes[0].noticed_as, ElementsAre("gone chair"));
  EXPECT_EQ(result->changes[1].name, "lamp 1");
  EXPECT_EQ(result->changes[1].state, std::nullopt);
  EXPECT_THAT(result->changes[1].noticed_as, ElementsAre("new lamp"));
  EXPECT_EQ(result->changes[2].name, "sofa 1");
  EXPECT_EQ(result->changes[2].state, ChangeState::kMoved);
  EXPECT_NEAR(result->changes[2].shift_m, 1, 1e-9);
  EXPECT_THAT(result->changes[2].noticed_as, ElementsAre("moved sofa"));
}

TEST_F(ChangeEvaluationTest, WhatIsSaidOfThingsThatStandAsTheyStoodIsWrong) {
  say("sofa", ChangeState::kMoved, 0, 0.05);
  say("chair", ChangeState::kRemoved, 20, {});
  const auto result = evaluate({cube("sofa 1", "sofa", 0, 4), cube("chair 1", "chair", 2, 4)},
                               {cube("sofa 1", "sofa", 0.05, 3)});
  ASSERT_OK(result);
  EXPECT_THAT(result->wrong, ElementsAre("moved sofa", "gone chair"))
      << "5 cm are no change, and the chair that went stood elsewhere";
  EXPECT_EQ(result->right, 0U);
  EXPECT_EQ(result->expected(), 1U);
  EXPECT_EQ(result->noticed(), 0U);
  EXPECT_EQ(result->known(), 0U) << "the home knew no chair there";
  EXPECT_FALSE(result->changes.at(0).was_known);
}

TEST_F(ChangeEvaluationTest, WhatTheHomeKnewAndSaysNothingOfIsNotNoticed) {
  say("sofa", ChangeState::kUnobserved, 0, 0);
  const auto result = evaluate({cube("sofa 1", "sofa", 0, 4)}, {});
  ASSERT_OK(result);
  EXPECT_EQ(result->known(), 1U);
  EXPECT_EQ(result->known_noticed(), 0U);
  EXPECT_EQ(result->unchanged, 1U);
}

TEST_F(ChangeEvaluationTest, WhatWasHardlySeenIsNotExpected) {
  say("sofa", ChangeState::kRemoved, 0, {});
  const auto result = evaluate({cube("sofa 1", "sofa", 0, 3), cube("bed 1", "bed", 2, 4)},
                               {cube("bed 1", "bed", 3, 2)});
  ASSERT_OK(result);
  ASSERT_EQ(result->changes.size(), 2U);
  EXPECT_FALSE(result->changes[0].is_expected) << "two frames of the visit show the bed";
  EXPECT_FALSE(result->changes[1].is_expected) << "three frames of the first walk show the sofa";
  EXPECT_EQ(result->expected(), 0U);
  EXPECT_EQ(result->noticed(), 0U);
  EXPECT_EQ(result->right, 1U) << "an alarm is right all the same";
}

TEST_F(ChangeEvaluationTest, OfTwoChangesAnAlarmIsAboutThatOfItsName) {
  say("chair", ChangeState::kRemoved, 0, {});
  say("sofa", ChangeState::kRemoved, 5, {});
  const auto result = evaluate({cube("bed 1", "bed", 0, 4), cube("chair 1", "chair", 0.25, 4),
                                cube("ghost 1", "zebra", 5, 4)},
                               {});
  ASSERT_OK(result);
  ASSERT_EQ(result->changes.size(), 2U) << "the home has no word for the third";
  EXPECT_EQ(result->changes[0].name, "bed 1");
  EXPECT_THAT(result->changes[0].noticed_as, IsEmpty()) << "although it is nearer";
  EXPECT_THAT(result->changes[1].noticed_as, ElementsAre("gone chair"));
  EXPECT_EQ(result->right, 2U) << "something stood there, whatever it is called";
  EXPECT_THAT(result->wrong, IsEmpty());
}

TEST_F(ChangeEvaluationTest, WhatHasNoNameIsJudgedByWhatTrulyChangedThere) {
  say_unnamed(false, 0);    // the sofa moved from there
  say_unnamed(true, 1);     // to there
  say_unnamed(true, 4);     // a lamp came
  say_unnamed(false, 6);    // the bed stands as it stood
  say_unnamed(true, 10.5);  // nothing but a door
  say("bottle", ChangeState::kRemoved, 8, {});
  const std::vector before{cube("sofa 1", "sofa", 0, 4), cube("bed 1", "bed", 6, 4),
                           cube("bottle 1", "bottle", 8, 4)};
  const std::vector now{cube("sofa 1", "sofa", 1, 3), cube("bed 1", "bed", 6, 3),
                        cube("lamp 1", "lamp", 4, 3)};
  const auto shut = evaluate(before, now);
  ASSERT_OK(shut);
  EXPECT_EQ(shut->expected(), 3U);
  EXPECT_EQ(shut->noticed(), 1U) << "by its name";
  EXPECT_EQ(shut->noticed_with_unnamed(), 3U);
  EXPECT_EQ(shut->unnamed_right, 3U);
  EXPECT_EQ(shut->unnamed_doors, 0U) << "it was not turned";
  ASSERT_EQ(shut->unnamed_wrong.size(), 2U);
  EXPECT_THAT(shut->unnamed_wrong[0], ::testing::HasSubstr("gone 0.30 x 0.30 x 0.30 m at 6.00"));
  EXPECT_THAT(shut->unnamed_wrong[1], ::testing::HasSubstr("new"));
  door_now_rad_ = 0.2;
  const auto turned = evaluate(before, now);
  ASSERT_OK(turned);
  EXPECT_EQ(turned->unnamed_doors, 1U);
  EXPECT_EQ(turned->unnamed_wrong.size(), 1U);
}

TEST_F(ChangeEvaluationTest, ADoorIsWhereItsLeafStands) {
  say_unnamed(true, 10);   // in the opening
  say_unnamed(false, 10);  // there was no leaf: it stood open
  door_now_rad_ = 0.2;
  const auto nearly_shut = evaluate({}, {});
  ASSERT_OK(nearly_shut);
  EXPECT_EQ(nearly_shut->unnamed_doors, 1U);
  EXPECT_EQ(nearly_shut->unnamed_wrong.size(), 1U);
  door_now_rad_ = 0.9;
  const auto half_open = evaluate({}, {});
  ASSERT_OK(half_open);
  EXPECT_EQ(half_open->unnamed_doors, 0U) << "it stands aside of the middle";
  EXPECT_EQ(half_open->unnamed_wrong.size(), 2U);
}

TEST_F(ChangeEvaluationTest, AHomeOfAnotherWalkIsRefused) {
  ROOMWISE_MUST(write_file(mapped() / "0.png", picture_of(200)));
  EXPECT_ERROR(evaluate({}, {}), "was not mapped from");
}

}  // namespace
}  // namespace roomwise::trials
