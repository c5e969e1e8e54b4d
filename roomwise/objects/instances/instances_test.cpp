#include "roomwise/objects/instances/instances.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <ranges>

#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/objects/testing/test_room.h"

namespace roomwise::objects {
namespace {

using Eigen::Vector3d;
using testing::TestRoom;

const TestRoom::Thing kBed{"bed", {0.5, 0.2, 0.25}, {2.0, 1.4, 0.5}};
const TestRoom::Thing kChair{"chair", {-0.5, 0, 0.4}, {0.45, 0.45, 0.8}};
const TestRoom::Thing kOtherChair{"chair", {0.2, 0, 0.4}, {0.45, 0.45, 0.8}};

TEST(FindInstances, OneBedSeenFromAllSidesIsOne) {
  TestRoom room;
  room.things = {kBed};
  room.look_around(kBed.center, 10, 2.2);
  const auto instances = room.instances();
  ASSERT_EQ(instances.size(), 1U);
  EXPECT_EQ(instances[0].name, "bed");
  EXPECT_EQ(instances[0].observations, 10);
  EXPECT_EQ(instances[0].expected, 10);
  EXPECT_GT(instances[0].probability, 0.3);
  const geometry::OrientedBox box = room.box_of(instances[0]);
  EXPECT_LT((box.center() - kBed.center).norm(), 0.06);
  const double longer = std::max(box.size_m.x(), box.size_m.y());
  const double shorter = std::min(box.size_m.x(), box.size_m.y());
  EXPECT_NEAR(longer, 2.0, 0.12);
  EXPECT_NEAR(shorter, 1.4, 0.12);
  EXPECT_NEAR(box.size_m.z(), 0.5, 0.06);
  const Vector3d error_m = box.world_from_box.inverse() * kBed.center;
  EXPECT_TRUE((error_m.cwiseAbs().array() < 2 * instances[0].sigma_m.array()).all());
  EXPECT_LT(instances[0].sigma_m.maxCoeff(), 0.15 * longer);
  const Vector3d up = box.world_from_box.rotation * Vector3d::UnitZ();
  EXPECT_GT(up.z(), 0.9999) << "the box stands upright";
}

TEST(FindInstances, TwoChairsBesideEachOtherStayTwo) {
  TestRoom room;
  room.things = {kChair, kOtherChair};
  room.look_around({-0.15, 0, 0.4}, 12);
  const auto instances = room.instances();
  ASSERT_EQ(instances.size(), 2U);
  std::vector<double> x;
  for (const Instance& instance : instances) {
    EXPECT_EQ(instance.name, "chair");
    x.push_back(room.box_of(instance).center().x());
  }
  std::ranges::sort(x);
  EXPECT_NEAR(x[0], kChair.center.x(), 0.08);
  EXPECT_NEAR(x[1], kOtherChair.center.x(), 0.08);
}

TEST(FindInstances, HangsOnNoOrder) {
  TestRoom room;
  room.things = {kChair, kOtherChair};
  room.look_around({-0.15, 0, 0.4}, 8);
  const auto before = room.instances();
  std::vector<ObservedKeyframe> shuffled = room.keyframes();
  for (ObservedKeyframe& keyframe : shuffled) std::ranges::reverse(keyframe.detections);
  RandomStream random(3, {});
  for (std::size_t i = shuffled.size(); i > 1; --i) {
    std::swap(shuffled[i - 1], shuffled[static_cast<std::size_t>(random.index(i))]);
  }
  const auto after = find_instances(shuffled, {Vector3d::UnitZ(), 0, true}, {});
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < after.size(); ++i) {
    EXPECT_EQ(after[i].keyframe_id, before[i].keyframe_id);
    EXPECT_EQ(after[i].observations, before[i].observations);
    EXPECT_NEAR(after[i].probability, before[i].probability, 1e-9);
    EXPECT_LT((after[i].box_keyframe.center() - before[i].box_keyframe.center()).norm(), 1e-4);
  }
}

TEST(FindInstances, ExpectsNothingOfKeyframesThatCannotSeeIt) {
  TestRoom room;
  room.things = {kChair, {"wall", {0.6, 0, 1.3}, {0.1, 4, 2.6}}};
  room.look_around(kChair.center, 4, 1.5, 2.5, 1);
  for (int i = 0; i < 6; ++i) {
    room.look({2.2, 0.1 * i, 1.4}, kChair.center, /*finds=*/false);  // behind the wall
    room.look({-2, 0.1 * i, 1.4}, {-2.9, 2, 1}, /*finds=*/false);    // looks away
  }
  const auto instances = room.instances();
  const auto chair = std::ranges::find(instances, "chair", &Instance::name);
  ASSERT_NE(chair, instances.end());
  EXPECT_EQ(chair->expected, 4);
}

TEST(FindInstances, TheMoreProbableNameOfOneThingStays) {
  TestRoom room;
  room.things = {kBed};
  room.look_around(kBed.center, 8, 2.2);
  const double alone = room.instances().at(0).probability;
  for (const double y : {1.2, 1.5, 1.8}) room.look({2.4, y, 1.4}, kBed.center, true, "sofa");
  const auto instances = room.instances();
  ASSERT_EQ(instances.size(), 1U);
  EXPECT_EQ(instances[0].name, "bed");
  EXPECT_GT(instances[0].names.at("bed"), instances[0].names.at("sofa"));
  EXPECT_NEAR(instances[0].names.at("bed") + instances[0].names.at("sofa"), 1, 1e-9);
  EXPECT_LT(instances[0].probability, alone) << "a rival speaks against it";
}

TEST(FindInstances, MorePicturesSpeakForAThing) {
  double before = 0;
  for (const int looks : {4, 8, 16}) {
    TestRoom room;
    room.things = {kBed};
    room.look_around(kBed.center, looks, 2.2);
    const auto instances = room.instances();
    ASSERT_EQ(instances.size(), 1U);
    EXPECT_GT(instances[0].probability, before) << looks;
    before = instances[0].probability;
    EXPECT_TRUE(room.instances(before + 1e-6).empty()) << "less is not told";
  }
}

TEST(FindInstances, ABoxInsideAnotherOfItsNameIsTheSameThingOnceMore) {
  TestRoom room;
  room.things = {kBed};
  room.look_around(kBed.center, 6, 2.2);
  for (ObservedKeyframe& keyframe : room.keyframes()) {
    Detection part = keyframe.detections.at(0);
    part.box.right -= 0.3F * (part.box.right - part.box.left);
    part.score = 0.5F;
    keyframe.detections.push_back(part);
  }
  const auto instances = room.instances();
  ASSERT_EQ(instances.size(), 1U);
  EXPECT_EQ(instances[0].observations, 6);
}

TEST(FindInstances, ALookAlikeTakesTheNameAwayAndIsNotToldItself) {
  TestRoom room;
  room.things = {{"radiator", {0, 0, 0.65}, {1.0, 0.3, 0.6}}};  // it hangs
  room.look_around({0, 0, 0.65}, 8, 2.0);
  for (const double y : {1.2, 1.5, 1.8}) room.look({1.2, y, 1.4}, {0, 0, 0.65}, true, "bench");
  EXPECT_TRUE(room.instances().empty());
}

TEST(FindInstances, WhereNoFloorIsKnownNothingIsTakenForIt) {
  TestRoom room;
  room.things = {{"book", {0, 0, 0.02}, {0.3, 0.2, 0.04}}};
  room.look_around({0, 0, 0}, 8, 0.9);
  InstanceOptions options;
  options.min_probability = 0;
  const auto flat = [&](bool is_floor_known) {
    return find_instances(room.keyframes(), {Vector3d::UnitZ(), 0, is_floor_known}, options);
  };
  EXPECT_TRUE(flat(true).empty()) << "lower than what is cut away with the floor";
  EXPECT_EQ(flat(false).size(), 1U) << "on a desk, say";
}

TEST(FindInstances, TwoOfOneNameInOnePlaceAreOne) {
  TestRoom room;
  room.things = {{"bed", {0, 0, 0.25}, {2.0, 1.4, 0.5}}, {"bed", {0.2, 0, 0.3}, {1.3, 1.1, 0.6}}};
  room.look_around({0, 0, 0.3}, 12, 2.2);
  const auto instances = room.instances();
  ASSERT_EQ(instances.size(), 1U);
  EXPECT_EQ(instances[0].observations, 12);
}

TEST(FindInstances, AThingOnAnotherStaysItself) {
  TestRoom room;
  room.things = {{"table", {0, 0, 0.35}, {1.2, 0.8, 0.7}},
                 {"vase", {0.1, 0, 0.85}, {0.15, 0.15, 0.3}}};
  room.look_around({0, 0, 0.6}, 10);
  const auto instances = room.instances();
  ASSERT_EQ(instances.size(), 2U);
  EXPECT_EQ(instances[0].name, "table");
  EXPECT_EQ(instances[1].name, "vase");
  EXPECT_LT((room.box_of(instances[1]).center() - Vector3d(0.1, 0, 0.85)).norm(), 0.05);
}

TEST(FindInstances, ALoopClosureJoinsWhatDriftHadSplit) {
  TestRoom room;
  room.things = {kChair};
  room.look_around(kChair.center, 5, 1.8, 0, 2);
  room.look_around(kChair.center, 5, 1.8, 2, 2);
  const std::vector<ObservedKeyframe> right = room.keyframes();
  // The second pass has drifted by a metre.
  for (std::size_t i = 5; i < 10; ++i) {
    room.keyframes()[i].world_from_camera.translation += Vector3d(1, 0.2, 0);
  }
  EXPECT_EQ(room.instances().size(), 2U);
  room.keyframes() = right;
  const auto instances = room.instances();
  ASSERT_EQ(instances.size(), 1U);
  EXPECT_EQ(instances[0].observations, 10);
  // The whole map moves: the things move with it, the same as seen from their key-frames.
  const geometry::RigidTransform moved{
      Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Vector3d::UnitZ())), {4, -2, 0}};
  for (ObservedKeyframe& keyframe : room.keyframes()) {
    keyframe.world_from_camera = moved * keyframe.world_from_camera;
  }
  const auto after = room.instances();
  ASSERT_EQ(after.size(), 1U);
  EXPECT_LT((room.box_of(after[0]).center() - moved * kChair.center).norm(), 0.08);
}

TEST(FindLevel, FindsTheFloor) {
  TestRoom room;
  room.things = {kBed};
  for (int i = 0; i < 8; ++i) {
    room.look({-1.5, 0.2 * i, 1.4}, {1, 0.3 * i, 0.2});
  }
  const geometry::RigidTransform tilted{
      Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Vector3d(1, 0.2, 0).normalized())), {1, 2, 3}};
  const Vector3d up = tilted.rotation * Vector3d::UnitZ();
  for (ObservedKeyframe& keyframe : room.keyframes()) {
    keyframe.world_from_camera = tilted * keyframe.world_from_camera;
  }
  const GroundPlane level = fit_ground_plane(room.keyframes());
  EXPECT_GT(level.up_world.dot(up), 0.9995);
  EXPECT_NEAR(level.height_m(tilted * Vector3d(0, 0, 0)), 0, 0.04);
  EXPECT_NEAR(level.height_m(tilted * Vector3d(0, 0, 1)), 1, 0.05);
}

TEST(InstanceOptions, NamesTheFieldThatIsWrong) {
  EXPECT_OK(InstanceOptions{}.validate());
  InstanceOptions options;
  options.min_score = 2;
  EXPECT_ERROR(options.validate(), "min_score");
  options = {};
  options.max_range_m = 0;
  EXPECT_ERROR(options.validate(), "max_range_m");
  options = {};
  options.min_observations = 0;
  EXPECT_ERROR(options.validate(), "min_observations");
  options = {};
  options.min_probability = -1;
  EXPECT_ERROR(options.validate(), "min_probability");
}

}  // namespace
}  // namespace roomwise::objects
