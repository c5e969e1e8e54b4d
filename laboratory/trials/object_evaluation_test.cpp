#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "laboratory/simulation/home/ground_truth.h"
#include "laboratory/trials/object_report.h"
#include "laboratory/trials/truth_evaluation.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/home/testing/sample_home.h"
#include "roomwise/pipeline/mapping/map_recording.h"
#include "roomwise/pipeline/rooms/room_learning.h"
#include "roomwise/pipeline/testing/synthetic_walk.h"
#include "roomwise/recording/trajectory_file.h"

namespace roomwise::trials {
namespace {

using ::testing::HasSubstr;

// A walk mapped while a network looks at it that calls everything a bed.
home::Home mapped_home(const std::filesystem::path& file, recording::FrameSource& walk) {
  home::Home home = pipeline::create_home(file).value();
  pipeline::Networks networks;
  networks.push_back(std::make_unique<pipeline::testing::ColorNetwork>(
      std::vector<std::string>{"studio couch", "wolf"}));
  ThreadPool pool(2);
  SilentProgress progress;
  StageClock clock;
  pipeline::RunContext run{pool, progress, clock};
  ROOMWISE_MUST(pipeline::map_recording(
      walk, {walk.info().name, "made up", walk.info().camera, walk.info().frames_remaining}, home,
      networks, pipeline::MapSettings{}, run, objects::ObjectFinders{}));
  return home;
}

TEST(ObjectEvaluation, ComparesWithWhatIsThere) {
  const roomwise::testing::ScratchFolder folder;
  pipeline::testing::SyntheticWalk walk(45);
  const home::Home home = mapped_home(folder / "a.home", walk);
  const objects::ConfirmedObject bed = home.confirmed_objects()->front();
  ASSERT_EQ(bed.name, "bed");
  const Eigen::Vector3d place =
      home.keyframes()->at(bed.keyframe_id).pose.world_from_keyframe * *bed.position_keyframe;

  // The truth lies elsewhere and is turned: the map is moved onto it.
  const geometry::RigidTransform truth_from_walk{
      Eigen::Quaterniond(Eigen::AngleAxisd(1.2, Eigen::Vector3d::UnitX())), {5, -3, 2}};
  recording::Trajectory truth = walk.truth();
  for (recording::StampedPose& pose : truth)
    pose.world_from_camera = truth_from_walk * pose.world_from_camera;
  ASSERT_OK(recording::write_trajectory(folder / "groundtruth.txt", truth));
  const auto thing = [&](const char* label, const Eigen::Vector3d& center, bool is_seen) {
    simulation::ObjectTruth object;
    object.name = object.label = object.kind = label;
    object.center_m = center;
    object.size_m = {0.4, 0.4, 0.4};
    if (is_seen) object.seen.push_back({0, 100, 0.1});
    return object;
  };
  const std::vector<simulation::ObjectTruth> things{
      thing("bed", truth_from_walk * place + Eigen::Vector3d(0, 0.3, 0), true),
      thing("lamp", {0, 0, 0}, true), thing("fridge", {1, 0, 0}, false),
      thing("hat", {2, 0, 0}, true)};
  ASSERT_OK(simulation::write_objects_truth(folder / "objects.json", things));

  pipeline::testing::write_mapped_pictures(home, folder.path());
  const auto result = evaluate_objects(home, {folder.path(), {}}, 1.0);
  ASSERT_OK(result);
  EXPECT_EQ(result->truth.size(), 2U) << "the fridge was never shown, a hat has no name here";
  const evaluation::ObjectErrors& errors = result->by_rules.errors;
  EXPECT_EQ(errors.by_kind.at("bed").beyond, 1U) << "found, though it was not shown well";
  EXPECT_FALSE(errors.by_kind.contains("lamp")) << "nor was the lamp, which nobody need find";
  EXPECT_NEAR(errors.from_center_quantile_m(0.5), 0.3, 0.03);
  EXPECT_NEAR(errors.from_box_quantile_m(0.5), 0.1, 0.03);
  ASSERT_EQ(result->truth_shown.size(), 2U);
  EXPECT_EQ(result->truth_shown[0]->keyframe, home.keyframes()->front().id);
  trials::ObjectEvaluation made_up = *result;  // something of each kind
  const home::KeyframeId keyframe = home.keyframes()->front().id;
  made_up.instances.found = {{"bed", place}, {"bed", place}, {"chair", place}};
  made_up.instances_shown = {{keyframe, network::PixelBox{8, 8, 20, 16}},
                             {keyframe, std::nullopt},
                             {keyframe, network::PixelBox{-5, -5, 9000, 9000}}};
  made_up.instances.errors.matches = {{0, 0, 0.1, 0.2}};
  made_up.instances.errors.duplicates = {{0, 1, 0.3, 0.4}};
  made_up.instances.errors.wrong = {2};
  made_up.instances.errors.missed = {0};
  const auto report = object_report(home, "a", made_up);
  ASSERT_OK(report);
  EXPECT_EQ(report->ways.size(), 3U);
  ASSERT_EQ(report->found.size(), 1U);
  EXPECT_EQ(report->found[0].text,
            "0.20 m from the middle of the true bed, which need not be found.");
  EXPECT_EQ(report->found[0].picture.at(6, 6).r, 255) << "the frame lies around the box";
  ASSERT_EQ(report->duplicates.size(), 1U);
  EXPECT_EQ(report->duplicates[0].text, "0.30 m from a bed that was found.");
  ASSERT_EQ(report->wrong.size(), 1U);
  EXPECT_THAT(report->wrong[0].alt, HasSubstr("about what was called chair"));
  ASSERT_EQ(report->missed.size(), 1U);
  EXPECT_EQ(report->missed[0].heading, fmt::format("bed, key-frame {}", keyframe));
  std::filesystem::remove(folder / "objects.json");
  EXPECT_ERROR(evaluate_objects(home, {folder.path(), {}}, 1.0), "objects.json");
  EXPECT_ERROR(evaluate_objects(home, {folder / "nowhere", {}}, 1.0), "nowhere: there is nothing");
}

TEST(ObjectEvaluation, WhatAnotherWalkAloneShowsCountsNeitherWay) {
  const roomwise::testing::ScratchFolder folder;
  pipeline::testing::SyntheticWalk walk(45);
  home::Home home = mapped_home(folder / "a.home", walk);
  ASSERT_OK(recording::write_trajectory(folder / "groundtruth.txt", walk.truth()));
  simulation::ObjectTruth bed;
  bed.name = bed.label = bed.kind = "bed";
  bed.size_m = {0.4, 0.4, 0.4};
  bed.seen.push_back({0, 100, 0.1});
  ASSERT_OK(simulation::write_objects_truth(folder / "objects.json", std::vector{bed}));
  pipeline::testing::write_mapped_pictures(home, folder.path());

  // A second walk, its first picture at the same time as that of the first.
  const home::Keyframe first = home.keyframes()->front();
  const home::RecordingId later = home.add_recording({"later", "", walk.info().camera, 1}).value();
  home::MapCommit step;
  step.recording = later;
  step.next_frame_index = 1;
  const home::KeyframeId of_later = home.next_keyframe_id().value();
  step.keyframes.push_back({{of_later, first.frame_index, first.timestamp_ns},
                            first.pose,
                            home.images(first.id).value(),
                            {},
                            {}});
  step.frames.push_back(
      {first.frame_index, first.timestamp_ns, home::FramePlace{of_later, {}}, ""});
  ASSERT_OK(home.commit(step));
  const auto placed = at_true_poses(home.keyframes().value(), first.recording, folder.path());
  ASSERT_OK(placed);
  for (const home::Keyframe& keyframe : *placed) EXPECT_EQ(keyframe.recording, first.recording);

  objects::Instance chair;  // there is none
  chair.name = "chair";
  chair.box_keyframe.size_m = {0.4, 0.4, 0.4};
  const auto wrong = [&](home::KeyframeId best) {
    chair.keyframe_id = best;
    EXPECT_OK(home.replace_instances(std::vector{chair}));
    EXPECT_OK(home.replace_confirmed_objects(std::vector<objects::ConfirmedObject>{
        {"chair", best, 0.9, 4, Eigen::Vector3d(Eigen::Vector3d::Zero())}}));
    const auto result = evaluate_objects(home, {folder.path(), {}}, 1.0).value();
    EXPECT_EQ(result.instances_shown.size(), result.instances.found.size());
    EXPECT_EQ(result.by_rules.errors.all.wrong, result.instances.errors.all.wrong);
    return result.instances.errors.all.wrong;
  };
  EXPECT_EQ(wrong(first.id), 1U);
  EXPECT_EQ(wrong(of_later), 0U);
}

}  // namespace
}  // namespace roomwise::trials
