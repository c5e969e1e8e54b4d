#include "roomwise/home/home.h"

#include <limits>

#include "roomwise/home/schema.h"
#include "roomwise/home/testing/sample_home.h"

namespace roomwise::home {
namespace {

using ::roomwise::testing::ScratchFolder;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Pair;
using ::testing::SizeIs;

// Equal to the bit.
void expect_same(const geometry::RigidTransform& a, const geometry::RigidTransform& b) {
  EXPECT_EQ(a.rotation.coeffs(), b.rotation.coeffs());
  EXPECT_EQ(a.translation, b.translation);
}

// A home with a recording and a network, both numbered 1.
class HomeTest : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(home_.add_recording(testing::sample_recording()).value(), 1);
    ASSERT_EQ(home_.add_network(testing::sample_network()).value(), 1);
  }
  void commit_keyframes(KeyframeId count) {
    for (KeyframeId id = 0; id < count; ++id) {
      ASSERT_OK(home_.commit(testing::sample_commit(1, 1, id)));
    }
  }

  ScratchFolder folder_;
  Home home_ = Home::create(folder_ / "a.home").value();
};

TEST_F(HomeTest, WhatWasLearnedIsForgottenAndTheRestStays) {
  commit_keyframes(2);
  ASSERT_OK(home_.replace_rooms(std::vector<rooms::Room>{{"kitchen", "kitchen"}}));
  ASSERT_OK(home_.put_room_classifier({"net", "c0ffee", {1, 2}, "{}"}));
  ASSERT_OK(home_.replace_keyframe_rooms({{0, {{"kitchen", 1}}}}));
  ASSERT_OK(home_.replace_picture_features("c0ffee", "1",
                                           std::vector<PictureFeatures>{{"abc", 0, 0, {0.25F}}}));
  ASSERT_OK(home_.forget_learned_rooms());
  EXPECT_FALSE(home_.room_classifier().value());
  EXPECT_THAT(home_.keyframe_rooms().value(), IsEmpty());
  EXPECT_THAT(home_.picture_features("c0ffee", "1").value(), IsEmpty());
  EXPECT_THAT(home_.rooms().value(), SizeIs(1));
  EXPECT_THAT(home_.keyframes().value(), SizeIs(2));
}

TEST_F(HomeTest, WhatWasRemovedIsErasedFromTheFiles) {
  commit_keyframes(2);
  const Bytes& picture = testing::sample_images(1).color;
  const std::string trace(picture.begin(), picture.begin() + 200);
  const auto has_trace = [&] {
    std::string bytes;
    for (const char* name : {"a.home", "a.home-wal"}) {
      bytes += read_text_file(folder_ / name).value_or("");
    }
    return bytes.find(trace) != std::string::npos;
  };
  EXPECT_TRUE(has_trace());
  ASSERT_OK(home_.remove_recording(1));
  ASSERT_OK(home_.erase_removed());
  EXPECT_FALSE(has_trace());
  EXPECT_OK(home_.verify());
}

TEST_F(HomeTest, OwesErasingUntilItHasSucceeded) {
  commit_keyframes(2);
  const std::string digest = home_.content_digest().value();
  EXPECT_FALSE(home_.owes_erasing().value());
  ASSERT_OK(home_.owe_erasing());
  EXPECT_EQ(home_.content_digest().value(), digest);
  EXPECT_TRUE(home_.settings()->empty()) << "it is no setting of the map";
  EXPECT_ERROR(home_.put_setting(kErasingSetting, "1"), "no setting of a map");
  {
    const Home reader = Home::open_read_only(folder_ / "a.home").value();
    Statement reading =
        const_cast<Home&>(reader).database().prepare("SELECT keyframe_id FROM keyframes").value();
    ASSERT_TRUE(reading.step().value());
    EXPECT_ERROR(home_.erase_removed(), "another program reads the home");
  }
  { const Home closed = std::move(home_); }
  Home again = Home::open(folder_ / "a.home").value();
  EXPECT_TRUE(again.owes_erasing().value());
  ASSERT_OK(again.erase_removed());
  EXPECT_FALSE(again.owes_erasing().value());
}

TEST_F(HomeTest, KeepsWhatWasWorkedOutUntilItIsWorkedOutAnew) {
  EXPECT_FALSE(home_.derived_data("floor").value());
  const std::string digest = home_.content_digest().value();
  ASSERT_OK(home_.put_derived_data({"floor", "one", {1, 2}}));
  const DerivedData anew{"floor", "two", {3}};
  ASSERT_OK(home_.put_derived_data(anew));
  EXPECT_EQ(home_.derived_data("floor").value(), anew);
  for (const std::size_t size : {std::size_t{0}, std::size_t{9'000'000}, std::size_t{5}}) {
    DerivedData other{"floor", "three", Bytes(size, 8)};
    if (size > 0) other.data.back() = 9;
    ASSERT_OK(home_.put_derived_data(other));
    EXPECT_EQ(home_.derived_data("floor").value(), other) << size;
  }
  EXPECT_EQ(home_.content_digest().value(), digest) << "it follows from the rest";
}

TEST_F(HomeTest, KeepsSettings) {
  ASSERT_OK(home_.put_setting("features", "orb"));
  ASSERT_OK(home_.put_setting("seed", "1"));
  ASSERT_OK(home_.put_setting("seed", "18446744073709551615"));
  EXPECT_THAT(home_.settings().value(),
              ElementsAre(Pair("features", "orb"), Pair("seed", "18446744073709551615")));
}

TEST_F(HomeTest, KeepsRecordings) {
  Recording live = testing::sample_recording();
  live.name = "Xtion";
  live.frame_count.reset();
  EXPECT_EQ(home_.add_recording(live).value(), 2);
  commit_keyframes(3);
  ASSERT_OK(home_.finish_recording(2));

  const auto recordings = home_.recordings().value();
  ASSERT_THAT(recordings, SizeIs(2));
  EXPECT_EQ(recordings[0].id, 1);
  EXPECT_EQ(recordings[0].recording.name, "walk");
  EXPECT_EQ(recordings[0].recording.folder, "../recordings/walk");
  EXPECT_EQ(recordings[0].recording.camera, testing::sample_camera());
  EXPECT_EQ(recordings[0].recording.frame_count, 40U);
  EXPECT_EQ(recordings[0].next_frame_index, 7U);
  EXPECT_FALSE(recordings[0].finished);
  EXPECT_EQ(recordings[1].recording.frame_count, std::nullopt);
  EXPECT_EQ(recordings[1].next_frame_index, 0U);
  EXPECT_TRUE(recordings[1].finished);
  EXPECT_ERROR(home_.finish_recording(3), "no recording 3");
}

TEST_F(HomeTest, RefusesACameraThatCannotBe) {
  Recording recording = testing::sample_recording();
  recording.camera.fx = -1;
  EXPECT_ERROR(home_.add_recording(recording), "a.home: camera of recording 'walk'");
}

TEST_F(HomeTest, KeepsTheStepsOfAMap) {
  commit_keyframes(3);
  EXPECT_EQ(home_.next_keyframe_id().value(), 3U);

  const auto keyframes = home_.keyframes().value();
  ASSERT_THAT(keyframes, SizeIs(3));
  EXPECT_EQ(keyframes[2].id, 2U);
  EXPECT_EQ(keyframes[2].recording, 1);
  EXPECT_EQ(keyframes[2].frame_index, 6U);
  EXPECT_EQ(keyframes[2].timestamp_ns, 1'305'031'229'000'000'006);
  EXPECT_EQ(keyframes[1].pose.component, 1U);
  expect_same(keyframes[2].pose.world_from_keyframe, testing::sample_pose(2));
  EXPECT_EQ(home_.images(2).value(), testing::sample_images(2));
  EXPECT_ERROR(home_.images(3), "no key-frame 3");

  const auto views = home_.depth_views().value();
  ASSERT_THAT(views, SizeIs(3));
  EXPECT_EQ(views[2].keyframe, 2U);
  EXPECT_EQ(views[2].recording, 1);
  expect_same(views[2].keyframe_from_view, testing::sample_pose(0.1));
  EXPECT_EQ(home_.depth_view_image(views[2].id).value(), testing::sample_images(2).depth);
  EXPECT_ERROR(home_.depth_view_image(99), "no depth image 99");

  const auto frames = home_.frames(1).value();
  ASSERT_THAT(frames, SizeIs(7));
  EXPECT_EQ(frames[4].index, 4U);
  EXPECT_EQ(frames[4].timestamp_ns, 5);
  ASSERT_TRUE(frames[4].place);
  EXPECT_EQ(frames[4].place->keyframe, 1U);
  expect_same(frames[4].place->keyframe_from_camera, testing::sample_pose(0.01));
  ASSERT_TRUE(frames[4].motion);
  expect_same(frames[4].motion->device.world_from_camera, testing::sample_pose(0.7));
  EXPECT_EQ(frames[4].motion->device.up_camera, Eigen::Vector3d(0, -0.6, 0.8));
  EXPECT_EQ(frames[4].motion->use, scene::MotionUse::kAlone);
  EXPECT_FALSE(frames[5].motion);
  EXPECT_FALSE(frames[5].place);
  EXPECT_EQ(frames[5].no_pose_reason, "too few matches");

  const auto edges = home_.edges().value();
  ASSERT_THAT(edges, SizeIs(2));
  const auto expected = testing::sample_edge(1, 2, false);
  EXPECT_EQ(edges[1].from, 1U);
  EXPECT_EQ(edges[1].to, 2U);
  EXPECT_FALSE(edges[1].is_robust);
  EXPECT_FALSE(edges[1].is_device_motion);
  expect_same(edges[1].from_from_to, expected.from_from_to);
  EXPECT_EQ(edges[1].information, expected.information);
}

TEST_F(HomeTest, AStepMayHaveNoKeyframeOrSeveral) {
  MapCommit two = testing::sample_commit(1, 1, 0);
  MapCommit second = testing::sample_commit(1, 1, 1);
  two.keyframes.push_back(second.keyframes[0]);
  two.edges = {testing::sample_edge(0, 1, false), testing::sample_edge(0, 1, true)};
  two.next_frame_index = 4;
  ASSERT_OK(home_.commit(two));
  EXPECT_THAT(home_.keyframes().value(), SizeIs(2));
  EXPECT_TRUE(home_.edges().value()[1].is_robust);

  ASSERT_OK(home_.commit({.recording = 1,
                          .keyframes = {},
                          .edges = {},
                          .frames = {{9, 1, std::nullopt, "dark"}},
                          .next_frame_index = 12}));
  EXPECT_EQ(home_.recordings().value()[0].next_frame_index, 12U);
}

TEST_F(HomeTest, AStepThatDoesNotContinueIsRefusedWhole) {
  commit_keyframes(2);
  const std::string before = home_.content_digest().value();
  const auto refused = [&](const std::function<void(MapCommit&)>& spoil, const std::string& why) {
    MapCommit step = testing::sample_commit(1, 1, 2);
    spoil(step);
    EXPECT_ERROR(home_.commit(step), why);
    EXPECT_EQ(home_.content_digest().value(), before) << why;
  };
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  refused([](MapCommit& step) { step.recording = 9; }, "no recording 9");
  refused([](MapCommit& step) { step.keyframes[0].id = 5; }, "must have the number 2, not 5");
  refused([](MapCommit& step) { step.keyframes[0].images.color.clear(); }, "without its encoded");
  refused([](MapCommit& step) { step.frames[0].index = 3; }, "frame 3 is stored already");
  refused([](MapCommit& step) { std::swap(step.frames[0], step.frames[1]); }, "out of order");
  refused([](MapCommit& step) { step.next_frame_index = 6; }, "next frame is said to be 6");
  refused([](MapCommit& step) { step.frames[0].place->keyframe = 77; },
          "contradicts what is stored");
  refused([](MapCommit& step) { step.edges[0].from = 77; }, "contradicts what is stored");
  refused([](MapCommit& step) { step.edges[0].information(1, 2) = 4; }, "not symmetric");
  refused([=](MapCommit& step) { step.frames[0].motion->device.up_camera->x() = kNan; },
          "the device's motion");
  refused([=](MapCommit& step) { step.edges[0].from_from_to.translation.x() = kNan; },
          "not finite");
  refused(
      [=](MapCommit& step) { step.frames[0].place->keyframe_from_camera.translation.x() = kNan; },
      "pose of frame 4 is not finite");
  refused([=](MapCommit& step) { step.keyframes[0].pose.world_from_keyframe.rotation.x() = kNan; },
          "pose of key-frame 2 is not finite");
  refused([](MapCommit& step) { step.keyframes[0].predictions[0].second.features.pop_back(); },
          "has 2 features, but its network gives 3");
  refused([](MapCommit& step) { step.keyframes[0].predictions[0].first = 8; }, "no network 8");
}

TEST_F(HomeTest, PosesAreReplaced) {
  commit_keyframes(3);
  ASSERT_OK(home_.replace_poses({{1, {testing::sample_pose(9), 5}}}));
  const auto keyframes = home_.keyframes().value();
  expect_same(keyframes[1].pose.world_from_keyframe, testing::sample_pose(9));
  EXPECT_EQ(keyframes[1].pose.component, 5U);
  expect_same(keyframes[2].pose.world_from_keyframe, testing::sample_pose(2));

  EXPECT_ERROR(home_.replace_poses({{0, {testing::sample_pose(4), 0}}, {3, {}}}), "no key-frame 3");
  expect_same(home_.keyframes().value()[0].pose.world_from_keyframe, testing::sample_pose(0));
}

TEST_F(HomeTest, KeepsNetworksAndWhatTheySee) {
  commit_keyframes(2);
  EXPECT_EQ(home_.add_network(testing::sample_network()).value(), 1) << "known already";
  const Network trunk{.name = "trunk", .fingerprint = "beef", .labels = {}, .feature_size = 2};
  ASSERT_EQ(home_.add_network(trunk).value(), 2);
  EXPECT_THAT(home_.networks().value(),
              ElementsAre(Pair(1, testing::sample_network()), Pair(2, trunk)));
  Network relabelled = testing::sample_network();
  relabelled.labels.push_back("stove");
  EXPECT_ERROR(home_.add_network(relabelled), "other labels");
  relabelled = {.name = "x", .fingerprint = "x", .labels = {"\xff"}, .feature_size = 1};
  EXPECT_ERROR(home_.add_network(relabelled), "not UTF-8");

  ASSERT_OK(home_.put_prediction(1, 2, {.features = {1.5F, 2.5F}, .scores = {}}));
  ASSERT_OK(home_.put_prediction(1, 2, {.features = {3.5F, 4.5F}, .scores = {}}));
  EXPECT_THAT(home_.prediction(1, 2).value()->features, ElementsAre(3.5F, 4.5F));
  EXPECT_THAT(home_.prediction(1, 2).value()->scores, IsEmpty());
  EXPECT_FALSE(home_.prediction(0, 2).value());
  const auto predictions = home_.predictions(1).value();
  ASSERT_THAT(predictions, SizeIs(2));
  EXPECT_EQ(predictions.at(1).features, testing::sample_prediction(1).features);
  EXPECT_EQ(predictions.at(1).scores, testing::sample_prediction(1).scores);
}

TEST_F(HomeTest, KeepsSightings) {
  commit_keyframes(2);
  ASSERT_OK(home_.put_observations(
      1, std::vector<objects::ObjectScore>{{"stove", 0.4}, {"bed", 0.4}, {"lamp", 0.6}}));
  ASSERT_OK(home_.put_observations(0, {}));
  const auto observations = home_.observations().value();
  ASSERT_THAT(observations, SizeIs(1));
  const auto& of_1 = observations.at(1);
  ASSERT_THAT(of_1, SizeIs(3));
  EXPECT_EQ(of_1[0].object, "lamp");
  EXPECT_EQ(of_1[0].score, 0.6);
  EXPECT_EQ(of_1[1].object, "bed");
  EXPECT_EQ(of_1[2].object, "stove");
}

TEST_F(HomeTest, KeepsObjectsInTheirOrder) {
  commit_keyframes(2);
  const std::vector<objects::ConfirmedObject> objects{
      {"lamp", 1, 0.9, 4, std::nullopt}, {"bed", 0, 1.0 / 3, 7, Eigen::Vector3d(0.1, -0.2, 2.5)}};
  ASSERT_OK(home_.replace_confirmed_objects(objects));
  ASSERT_OK(home_.replace_confirmed_objects(objects));
  const auto stored = home_.confirmed_objects().value();
  ASSERT_THAT(stored, SizeIs(2));
  EXPECT_EQ(stored[0].name, "lamp");
  EXPECT_EQ(stored[0].position_keyframe, std::nullopt);
  EXPECT_EQ(stored[1].keyframe_id, 0U);
  EXPECT_EQ(stored[1].score, 1.0 / 3);
  EXPECT_EQ(stored[1].observations, 7);
  EXPECT_EQ(stored[1].position_keyframe, objects[1].position_keyframe);

  EXPECT_ERROR(
      home_.replace_confirmed_objects(std::vector<objects::ConfirmedObject>{{"bed", 9, 1, 4, {}}}),
      "contradicts");
  EXPECT_THAT(home_.confirmed_objects().value(), SizeIs(2)) << "the earlier ones are still there";
}

TEST_F(HomeTest, KeepsConcepts) {
  rooms::Concepts concepts = rooms::Concepts::standard();
  concepts.objects_of_room_type["hall"] = {};
  ASSERT_OK(concepts.vocabulary.add("chair", {"rocking chair", "folding chair"}));
  ASSERT_OK(home_.replace_concepts(rooms::Concepts::standard()));
  ASSERT_OK(home_.replace_concepts(concepts));
  EXPECT_EQ(home_.concepts().value().vocabulary.objects(), concepts.vocabulary.objects());
  EXPECT_EQ(home_.concepts().value().objects_of_room_type, concepts.objects_of_room_type);

  rooms::Concepts impossible = concepts;
  impossible.objects_of_room_type["hall"] = {"coat stand"};
  EXPECT_ERROR(home_.replace_concepts(impossible), "'hall' is said to have a 'coat stand'");
  EXPECT_EQ(home_.concepts().value().objects_of_room_type, concepts.objects_of_room_type);
}

TEST_F(HomeTest, KeepsRoomsAndTheirRanges) {
  const std::vector<rooms::Room> rooms{{"Anna's room", "bedroom"}, {"kitchen", "kitchen"}};
  ASSERT_OK(home_.replace_rooms(rooms));
  EXPECT_EQ(home_.rooms().value(), rooms);
  const std::vector<recording::RoomRange> ranges{{0, 4, "kitchen", 1}, {7, 9, "kitchen", 2}};
  ASSERT_OK(home_.replace_room_ranges(1, ranges));
  EXPECT_EQ(home_.room_ranges(1).value().ranges(), ranges);

  EXPECT_ERROR(home_.replace_room_ranges(1, {{0, 4, "attic", 1}}), "'attic', which is no room");
  EXPECT_ERROR(home_.replace_room_ranges(1, {{0, 4, "kitchen", 1}, {4, 5, "kitchen", 1}}),
               "overlap");
  EXPECT_EQ(home_.room_ranges(1).value().ranges(), ranges);

  EXPECT_ERROR(home_.replace_rooms(std::vector<rooms::Room>{{"Anna's room", "bedroom"}}),
               "room 'kitchen' cannot go");
  EXPECT_EQ(home_.rooms().value(), rooms);
  // Another type, and one room less that no frame belongs to.
  ASSERT_OK(home_.replace_rooms(std::vector<rooms::Room>{{"kitchen", "kitchenette"}}));
  EXPECT_THAT(home_.rooms().value(), ElementsAre(rooms::Room{"kitchen", "kitchenette"}));
  EXPECT_EQ(home_.room_ranges(1).value().ranges(), ranges);
}

TEST_F(HomeTest, TheNewestRoomClassifierCounts) {
  EXPECT_FALSE(home_.room_classifier().value());
  const RoomClassifierRecord first{"trunk", "beef", {1, 2, 3}, "{}"};
  const RoomClassifierRecord other{"net", "c0ffee", {4}, "{}"};
  const RoomClassifierRecord again{"trunk", "beef", {5, 0}, R"({"held_out":0.9})"};
  ASSERT_OK(home_.put_room_classifier(first));
  ASSERT_OK(home_.put_room_classifier(other));
  EXPECT_EQ(home_.room_classifier().value(), other);
  ASSERT_OK(home_.put_room_classifier(again));
  EXPECT_EQ(home_.room_classifier().value(), again);
  EXPECT_EQ(home_.database().get<int>("SELECT count(*) FROM room_classifiers").value(), 2);
}

TEST_F(HomeTest, KeepsTheRoomsOfKeyframes) {
  commit_keyframes(2);
  ASSERT_OK(home_.replace_keyframe_rooms({{0, {{"hall", 1.0}}}}));
  const std::map<KeyframeId, std::vector<rooms::RoomScore>> rooms{
      {0, {{"kitchen", 0.75}, {"hall", 0.25}}}, {1, {{"hall", 1.0}}}};
  ASSERT_OK(home_.replace_keyframe_rooms(rooms));
  EXPECT_EQ(home_.keyframe_rooms().value(), rooms);
}

TEST_F(HomeTest, TimesOfSeveralRunsAddUp) {
  ASSERT_OK(home_.add_stage_timings({{"features", {4, 0.5, 0.25}}}));
  ASSERT_OK(home_.add_stage_timings({{"features", {1, 0.5, 0.25}}, {"loops", {2, 1.0, 1.0}}}));
  const auto stages = home_.stage_timings().value();
  ASSERT_THAT(stages, SizeIs(2));
  EXPECT_EQ(stages.at("features").calls, 5U);
  EXPECT_EQ(stages.at("features").wall_s, 1.0);
  EXPECT_EQ(stages.at("features").cpu_s, 0.5);
}

TEST_F(HomeTest, RemovingARecordingTakesAllThatCameFromIt) {
  commit_keyframes(3);
  ASSERT_OK(home_.replace_rooms(std::vector<rooms::Room>{{"kitchen", "kitchen"}}));
  ASSERT_OK(home_.replace_room_ranges(1, {{0, 4, "kitchen", 1}}));
  ASSERT_OK(home_.replace_confirmed_objects(
      std::vector<objects::ConfirmedObject>{{"bed", 0, 0.5, 4, {}}}));
  ASSERT_OK(home_.replace_keyframe_rooms({{0, {{"kitchen", 0.75}}}}));
  // Another walk, placed by a key-frame of the first one.
  ASSERT_EQ(home_.add_recording(testing::sample_recording()).value(), 2);
  ASSERT_OK(home_.commit({.recording = 2,
                          .keyframes = {},
                          .edges = {},
                          .frames = {{0, 1, FramePlace{1, testing::sample_pose(1)}, ""}},
                          .next_frame_index = 1}));

  ASSERT_OK(home_.remove_recording(1));
  EXPECT_THAT(home_.recordings().value(), SizeIs(1));
  EXPECT_THAT(home_.keyframes().value(), IsEmpty());
  EXPECT_THAT(home_.depth_views().value(), IsEmpty());
  EXPECT_THAT(home_.edges().value(), IsEmpty());
  EXPECT_THAT(home_.frames(1).value(), IsEmpty());
  EXPECT_THAT(home_.predictions(1).value(), IsEmpty());
  EXPECT_THAT(home_.observations().value(), IsEmpty());
  EXPECT_THAT(home_.keyframe_rooms().value(), IsEmpty());
  EXPECT_THAT(home_.confirmed_objects().value(), IsEmpty());
  EXPECT_THAT(home_.room_ranges(1).value().ranges(), IsEmpty());
  const auto frames = home_.frames(2).value();
  ASSERT_THAT(frames, SizeIs(1));
  EXPECT_FALSE(frames[0].place);
  EXPECT_THAT(frames[0].no_pose_reason, ::testing::HasSubstr("removed"));
  EXPECT_OK(home_.verify());
  EXPECT_ERROR(home_.remove_recording(1), "no recording 1");
}

TEST_F(HomeTest, RemovingTheFirstOfTwoWalksLeavesTheOtherNumberedFromZero) {
  ASSERT_OK(home_.add_network(testing::sample_network()));
  ASSERT_EQ(home_.add_recording(testing::sample_recording()).value(), 2);
  ASSERT_EQ(home_.add_recording(testing::sample_recording()).value(), 3);
  // Each walk's key-frames as the sample's, but for their numbers.
  const auto commit = [&](RecordingId walk, KeyframeId first, KeyframeId count) {
    for (KeyframeId i = 0; i < count; ++i) {
      MapCommit step = testing::sample_commit(walk, 1, i);
      step.keyframes[0].id += first;
      for (auto& edge : step.edges) edge.from += first, edge.to += first;
      for (Frame& frame : step.frames)
        if (frame.place) frame.place->keyframe += first;
      ASSERT_OK(home_.commit(step));
    }
  };
  commit(1, 0, 2);
  commit(2, 2, 3);
  commit(3, 5, 2);
  ASSERT_OK(
      home_.commit({.recording = 3,
                    .keyframes = {},
                    .edges = {testing::sample_edge(1, 6, true), testing::sample_edge(4, 6, true)},
                    .frames = {},
                    .next_frame_index = 4}));
  ASSERT_OK(home_.replace_confirmed_objects(
      std::vector<objects::ConfirmedObject>{{"bed", 5, 0.5, 4, {}}}));
  ASSERT_OK(home_.put_derived_data({"floor", "c0ffee", {1}}));

  ASSERT_OK(home_.remove_recording(1));
  const auto keyframes = home_.keyframes().value();
  ASSERT_THAT(keyframes, SizeIs(5));
  for (KeyframeId id = 0; id < 5; ++id) {
    EXPECT_EQ(keyframes[id].id, id);
    EXPECT_EQ(keyframes[id].recording, id < 3 ? 2 : 3);
    EXPECT_EQ(home_.images(id).value(), testing::sample_images(id < 3 ? id : id - 3));
    EXPECT_TRUE(home_.prediction(id, 1).value());
  }
  const auto edges = home_.edges().value();
  ASSERT_THAT(edges, SizeIs(4)) << "that from the walk that is gone went with it";
  EXPECT_EQ(edges[3].from, 2U);
  EXPECT_EQ(edges[3].to, 4U);
  EXPECT_EQ(home_.frames(3).value().back().place->keyframe, 4U);
  EXPECT_EQ(home_.confirmed_objects().value()[0].keyframe_id, 3U);
  EXPECT_FALSE(home_.derived_data("floor").value());
  EXPECT_OK(home_.verify());
}

TEST_F(HomeTest, CulledKeyframesLeaveNoGapAndFramesHangOnOthers) {
  commit_keyframes(5);
  ASSERT_OK(home_.put_derived_data({"floor", "c0ffee", {1}}));
  const auto frames = home_.frames(1).value();
  KeyframeCulling culling;
  culling.culled = {1, 3};
  culling.edges = {testing::sample_edge(0, 2, true), testing::sample_edge(2, 4, true)};
  const std::string before = home_.content_digest().value();
  EXPECT_ERROR(home_.cull_keyframes(culling),
               "key-frame 1 cannot be taken out: the place of a frame");
  EXPECT_EQ(home_.content_digest().value(), before);
  for (const Frame& frame : frames) {
    if (frame.place && (frame.place->keyframe == 1 || frame.place->keyframe == 3)) {
      culling.places.push_back(
          {1, frame.index, {frame.place->keyframe - 1, testing::sample_pose(2)}});
    }
  }
  ASSERT_OK(home_.cull_keyframes(culling));
  const auto keyframes = home_.keyframes().value();
  ASSERT_THAT(keyframes, SizeIs(3));
  for (KeyframeId id = 0; id < 3; ++id) {
    EXPECT_EQ(keyframes[id].id, id);
    EXPECT_EQ(home_.images(id).value(), testing::sample_images(2 * id));
    EXPECT_TRUE(home_.prediction(id, 1).value());
  }
  const auto edges = home_.edges().value();
  ASSERT_THAT(edges, SizeIs(2));
  EXPECT_EQ(edges[1].from, 1U);
  EXPECT_EQ(edges[1].to, 2U);
  const auto after = home_.frames(1).value();
  ASSERT_EQ(after.size(), frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    ASSERT_EQ(after[i].place.has_value(), frames[i].place.has_value());
    if (!after[i].place) continue;
    EXPECT_EQ(after[i].place->keyframe, frames[i].place->keyframe / 2);
  }
  EXPECT_OK(home_.verify());
}

TEST_F(HomeTest, KeyframesOnWhichThingsHangAreNotCulled) {
  commit_keyframes(3);
  Edit note;
  note.what = "note";
  note.change = note.before = "{}";
  EditPlace stove;
  stove.keyframe = 1;
  note.places = {stove};
  ASSERT_OK(home_.add_edit(note));
  EXPECT_THAT(home_.held_keyframes().value(), ElementsAre(1U));
  KeyframeCulling culling;
  culling.culled = {1};
  const auto frames = home_.frames(1).value();
  for (const Frame& frame : frames) {
    if (frame.place && frame.place->keyframe == 1)
      culling.places.push_back({1, frame.index, {0, testing::sample_pose(2)}});
  }
  EXPECT_ERROR(home_.cull_keyframes(culling), "something that is kept hangs on it");
  EXPECT_THAT(home_.keyframes().value(), SizeIs(3));
}

TEST_F(HomeTest, SeveralWritesAreOneWhenAskedFor) {
  commit_keyframes(2);
  const std::string before = home_.content_digest().value();
  const auto finish = [&](KeyframeId object_keyframe) {
    return home_.atomically([&]() -> Expected<void> {
      ROOMWISE_RETURN_IF_ERROR(home_.replace_poses({{1, {testing::sample_pose(9), 0}}}));
      ROOMWISE_RETURN_IF_ERROR(home_.finish_recording(1));
      return home_.replace_confirmed_objects(
          std::vector<objects::ConfirmedObject>{{"bed", object_keyframe, 0.5, 4, std::nullopt}});
    });
  };
  EXPECT_ERROR(finish(99), "contradicts");
  EXPECT_EQ(home_.content_digest().value(), before);
  EXPECT_OK(finish(1));
  EXPECT_TRUE(home_.recordings().value()[0].finished);
}

TEST_F(HomeTest, DigestIsOfTheContentNotOfItsHistory) {
  ScratchFolder folder;
  Home a = Home::create(folder / "a.home").value();
  testing::fill(a);

  // The same in another order, in one transaction, with detours.
  Home b = Home::create(folder / "b.home").value();
  const auto fill_b = [&]() -> Expected<void> {
    ROOMWISE_RETURN_IF_ERROR(b.replace_concepts(rooms::Concepts::standard()));
    ROOMWISE_RETURN_IF_ERROR(
        b.put_room_classifier({"net", "c0ffee", {1, 2, 0, 3}, R"({"held_out":0.9})"}));
    ROOMWISE_RETURN_IF_ERROR(b.add_network(testing::sample_network()).map([](auto) {}));
    ROOMWISE_RETURN_IF_ERROR(b.add_recording(testing::sample_recording()).map([](auto) {}));
    for (KeyframeId id = 0; id < 4; ++id) {
      MapCommit step = testing::sample_commit(1, 1, id);
      step.keyframes[0].predictions.clear();
      step.keyframes[0].observations = {{"bed", 0.1}};
      step.keyframes[0].pose = {};
      ROOMWISE_RETURN_IF_ERROR(b.commit(step));
    }
    for (const KeyframeId id : {3U, 1U, 0U, 2U}) {
      ROOMWISE_RETURN_IF_ERROR(b.put_prediction(id, 1, testing::sample_prediction(id)));
      ROOMWISE_RETURN_IF_ERROR(
          b.put_observations(id, std::vector<objects::ObjectScore>{{"bed", 0.5}, {"lamp", 0.9}}));
      ROOMWISE_RETURN_IF_ERROR(
          b.replace_poses({{id, {testing::sample_pose(static_cast<double>(id)), id % 2}}}));
    }
    ROOMWISE_RETURN_IF_ERROR(b.replace_rooms(
        std::vector<rooms::Room>{{"kitchen", "kitchen"}, {"Anna's room", "bedroom"}}));
    ROOMWISE_RETURN_IF_ERROR(
        b.replace_keyframe_rooms({{0, {{"Anna's room", 0.2}, {"kitchen", 0.8}}}}));
    ROOMWISE_RETURN_IF_ERROR(
        b.replace_room_ranges(1, {{0, 4, "kitchen", 1}, {5, 9, "Anna's room", 1}}));
    ROOMWISE_RETURN_IF_ERROR(b.replace_confirmed_objects(std::vector<objects::ConfirmedObject>{
        {"bed", 1, 0.5, 4, Eigen::Vector3d(0.1, -0.2, 2.5)}, {"lamp", 2, 0.9, 4, std::nullopt}}));
    const std::vector<std::string> labels{"couch", "bed"};
    ROOMWISE_RETURN_IF_ERROR(b.add_region_finder({"finder", "f1nd", labels}).map([](auto) {}));
    objects::KeyframeDetections one = testing::sample_look(2);
    ROOMWISE_RETURN_IF_ERROR(b.put_detections(2, 1, one));
    one.detections.resize(1);
    ROOMWISE_RETURN_IF_ERROR(b.put_detections(2, 1, one));
    ROOMWISE_RETURN_IF_ERROR(b.put_detections(1, 1, testing::sample_look(1)));
    ROOMWISE_RETURN_IF_ERROR(b.put_readout(1, 0.02));
    ROOMWISE_RETURN_IF_ERROR(b.replace_instances(std::vector{testing::sample_instance(3)}));
    ROOMWISE_RETURN_IF_ERROR(testing::add_visits(b));
    ROOMWISE_RETURN_IF_ERROR(b.add_edit(testing::sample_edit(2)));
    home::OwnThing thing = testing::sample_own_thing();
    thing.taught_s += 5;  // when does not count
    ROOMWISE_RETURN_IF_ERROR(testing::teach(b, thing));
    return b.put_setting("seed", "7");
  };
  ASSERT_OK(b.atomically(fill_b));
  EXPECT_EQ(a.content_digest().value(), b.content_digest().value());

  ASSERT_OK(b.add_stage_timings({{"features", {400, 50, 40}}}));
  EXPECT_EQ(a.content_digest().value(), b.content_digest().value()) << "times do not count";
  geometry::RigidTransform pose = testing::sample_pose(2);
  pose.translation.x() = std::nextafter(pose.translation.x(), 10.0);
  ASSERT_OK(b.replace_poses({{2, {pose, 0}}}));
  EXPECT_NE(a.content_digest().value(), b.content_digest().value()) << "one bit of one pose does";
}

}  // namespace
}  // namespace roomwise::home
