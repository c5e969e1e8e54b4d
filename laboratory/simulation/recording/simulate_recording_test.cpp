#include "laboratory/simulation/recording/simulate_recording.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "laboratory/simulation/home/ground_truth.h"
#include "laboratory/simulation/recording/recording_folder.h"
#include "laboratory/simulation/recording/simulation_file.h"
#include "laboratory/simulation/render/true_surfaces.h"
#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/recording/room_labels.h"
#include "roomwise/recording/trajectory_file.h"
#include "roomwise/recording/tum_recording.h"
#include "roomwise/recording/tum_writer.h"

namespace roomwise::simulation {
namespace {

using roomwise::testing::ScratchFolder;

// A short walk through a very small home.
SimulationOptions short_walk() {
  SimulationOptions options;
  options.home = HomeOptions{3, {RoomKind::kToilet}};
  options.walk.frames_per_second = 1;
  options.walk.max_frames = 12;
  options.camera.width = 80;
  options.camera.height = 60;
  options.camera.fx = options.camera.fy = 66;
  options.camera.cx = 39.5;
  options.camera.cy = 29.5;
  options.render.samples_per_pixel = 1;
  options.render.bake_effort = 0.02;
  return options;
}

class SimulateRecording : public ::testing::Test {
 protected:
  void SetUp() override {
    auto opened = FurnitureCatalogue::open();
    ASSERT_OK(opened);
    catalogue_ = *std::move(opened);
  }
  Expected<SimulationSummary> simulate(const SimulationOptions& options, const std::string& name,
                                       std::size_t threads, Progress* progress = nullptr) {
    ThreadPool pool(threads);
    SilentProgress silent;
    StageClock clock;
    return simulate_recording(options, *catalogue_, folder_ / name, pool,
                              progress != nullptr ? *progress : silent, clock);
  }
  // Every file below a folder and its bytes.
  std::map<std::string, Bytes> contents(const std::string& name) {
    std::map<std::string, Bytes> contents;
    const std::filesystem::path root = folder_ / name;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(root)) {
      if (entry.is_regular_file()) {
        contents[std::filesystem::relative(entry.path(), root)] = read_file(entry.path()).value();
      }
    }
    return contents;
  }

  ScratchFolder folder_;
  std::optional<FurnitureCatalogue> catalogue_;
};

TEST_F(SimulateRecording, GivesTheSameBytesAtAnyNumberOfThreads) {
  ASSERT_OK(simulate(short_walk(), "one", 1));
  ASSERT_OK(simulate(short_walk(), "three", 3));
  const auto one = contents("one");
  EXPECT_EQ(one.size(), 12U + 12U + 9U) << "pictures, and what tells of them";
  EXPECT_EQ(one, contents("three"));
  SimulationOptions other = short_walk();
  other.sensor.seed = 1;
  ASSERT_OK(simulate(other, "other", 3));
  EXPECT_NE(one, contents("other"));
}

TEST_F(SimulateRecording, IsARecordingThatEveryReaderReads) {
  const auto summary = simulate(short_walk(), "walk", 2);
  ASSERT_OK(summary);
  EXPECT_TRUE(summary->finished);
  const std::filesystem::path walk = folder_ / "walk";
  const auto recording = recording::TumRecording::open(walk, {});
  ASSERT_OK(recording);
  EXPECT_EQ((*recording)->info().frames_remaining, 12U);
  EXPECT_EQ(recording::read_trajectory(walk / "groundtruth.txt")->size(), 12U);
  const auto rooms = recording::RoomLabels::read(walk / "rooms.txt");
  ASSERT_OK(rooms);
  EXPECT_NE(rooms->find(0), nullptr);
  const auto plan = read_floor_plan(walk / "floorplan.json");
  ASSERT_OK(plan);
  EXPECT_EQ(plan->rooms.size(), 2U) << "a hall leads to it";
  const auto objects = read_objects_truth(walk / "objects.json");
  ASSERT_OK(objects);
  EXPECT_EQ(objects->size(), summary->objects);
  EXPECT_TRUE(std::ranges::any_of(*objects, [](const ObjectTruth& o) { return !o.seen.empty(); }));
  EXPECT_THAT(read_text_file(walk / "credits.txt").value(), ::testing::HasSubstr("license"));
}

TEST_F(SimulateRecording, ExactDepthLiesOnTheTrueSurfaces) {
  SimulationOptions options = short_walk();
  options.sensor = SensorOptions::ideal();
  options.camera.distortion = {0.1, -0.05, 0.001, 0.002, 0};
  ASSERT_OK(simulate(options, "walk", 2));
  const auto home = make_home(options, *catalogue_);
  ASSERT_OK(home);
  const auto surfaces =
      TrueSurfaces::create(*home, [&](const std::string& id) { return catalogue_->load(id); });
  ASSERT_OK(surfaces);
  const auto truth = recording::read_trajectory(folder_ / "walk" / "groundtruth.txt").value();
  const auto recording = recording::TumRecording::open(folder_ / "walk", {}).value();
  std::size_t points = 0;
  for (const recording::StampedPose& pose : truth) {
    const auto frame = recording->next().value();
    ASSERT_TRUE(frame.has_value());
    EXPECT_EQ(frame->timestamp_ns, pose.timestamp_ns);
    for (int y = 2; y < options.camera.height; y += 7) {
      for (int x = 2; x < options.camera.width; x += 7) {
        const double depth_m = frame->depth.at(x, y) / options.camera.depth_units_per_metre;
        if (depth_m == 0) continue;  // out of the window
        const Eigen::Vector3d point =
            pose.world_from_camera * options.camera.unproject({x, y}, depth_m);
        EXPECT_LT(surfaces->distance_m(point.cast<float>(), 1), 0.001) << x << ", " << y;
        ++points;
      }
    }
  }
  EXPECT_GT(points, 500U);
}

// Stops the walk after some frames.
class InterruptDrawing final : public Progress {
 public:
  void begin(std::string_view work, std::optional<std::uint64_t>) override {
    drawing_ = work == "drawing the walk";
    done_ = 0;
  }
  void advance(std::uint64_t done, std::string_view) override { done_ = done; }
  void end() override {}
  [[nodiscard]] bool interrupted() const override { return drawing_ && done_ >= 5; }

 private:
  bool drawing_ = false;
  std::uint64_t done_ = 0;
};

TEST_F(SimulateRecording, InterruptedKeepsWhatWasDrawnAndIsNotTakenForWhole) {
  InterruptDrawing interrupt;
  const auto summary = simulate(short_walk(), "walk", 2, &interrupt);
  ASSERT_OK(summary);
  EXPECT_FALSE(summary->finished);
  const std::filesystem::path walk = folder_ / "walk";
  EXPECT_EQ(recording::read_trajectory(walk / "groundtruth.txt")->size(), summary->frames);
  EXPECT_EQ((*recording::TumRecording::open(walk, {}))->info().frames_remaining, summary->frames);
  EXPECT_FALSE(std::filesystem::exists(walk / "simulation.json"));

  // Another walk does not take its place; the same one is begun anew and gives what it always
  // gives.
  SimulationOptions other = short_walk();
  other.walk.seed = 9;
  EXPECT_ERROR(simulate(other, "walk", 2), "unfinished recording of other options");
  ASSERT_OK(write_file(walk / "rgb" / "mine.txt", "mine"));
  EXPECT_ERROR(simulate(short_walk(), "walk", 2), "mine.txt");
  std::filesystem::remove(walk / "rgb" / "mine.txt");
  EXPECT_EQ(contents("walk").count("groundtruth.txt"), 1U) << "nothing was removed";
  EXPECT_TRUE(std::filesystem::exists(walk / "rgb.txt"));
  ASSERT_OK(write_file(walk / "rooms.txt.partial-17", ""));  // of a killed process
  const auto again = simulate(short_walk(), "walk", 2);
  ASSERT_OK(again);
  EXPECT_TRUE(again->finished);
  ASSERT_OK(simulate(short_walk(), "whole", 2));
  EXPECT_EQ(contents("walk"), contents("whole"));
}

// Is interrupted from the beginning, and notes what was begun.
class InterruptAtOnce final : public Progress {
 public:
  void begin(std::string_view work, std::optional<std::uint64_t>) override {
    works.emplace_back(work);
  }
  void advance(std::uint64_t, std::string_view) override {}
  void end() override {}
  [[nodiscard]] bool interrupted() const override { return true; }

  std::vector<std::string> works;
};

TEST_F(SimulateRecording, InterruptedBeforeTheFirstFrameLeavesNothing) {
  InterruptAtOnce interrupt;
  EXPECT_ERROR(simulate(short_walk(), "walk", 2, &interrupt), "interrupted");
  EXPECT_FALSE(interrupt.works.empty());
  EXPECT_FALSE(std::filesystem::exists(folder_ / "walk"));
  std::filesystem::create_directory(folder_ / "empty");
  EXPECT_ERROR(simulate(short_walk(), "empty", 2, &interrupt), "interrupted");
  EXPECT_TRUE(std::filesystem::is_empty(folder_ / "empty")) << "it was the user's";
}

TEST_F(SimulateRecording, KilledBeforeTheFirstFrameMakesRoomForAnyOther) {
  const std::filesystem::path walk = folder_ / "walk";
  ASSERT_OK(recording::TumWriter::create(walk, short_walk().camera));
  ASSERT_OK(mark_unfinished(walk, short_walk()));
  SimulationOptions other = short_walk();
  other.walk.max_frames = 2;
  ASSERT_OK(simulate(other, "walk", 2));
  EXPECT_FALSE(std::filesystem::exists(walk / "unfinished.json"));
}

TEST_F(SimulateRecording, WhatCannotBeWrittenIsNoticedBeforeTheBake) {
  ASSERT_OK(write_file(folder_ / "file", "a file"));
  InterruptAtOnce progress;
  SimulationOptions options = short_walk();
  options.render.light_cache = folder_ / "none/flat.light";
  EXPECT_ERROR(simulate(options, "walk", 2, &progress), "none/flat.light");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "walk"));
  options.render.light_cache = folder_.path();
  EXPECT_ERROR(simulate(options, "walk", 2, &progress), "is a folder");
  EXPECT_ERROR(simulate(short_walk(), "file/walk", 2, &progress), "file/walk");
  EXPECT_TRUE(progress.works.empty()) << "nothing was begun";
}

TEST_F(SimulateRecording, IsKeptAsLongAsTheProgramMakesTheSameHome) {
  const std::filesystem::path walk = folder_ / "walk";
  EXPECT_FALSE(is_made_already(walk, short_walk(), *catalogue_).value());
  ASSERT_OK(simulate(short_walk(), "walk", 2));
  EXPECT_TRUE(is_made_already(walk, short_walk(), *catalogue_).value());
  SimulationOptions other = short_walk();
  other.sensor.edge_jitter = false;
  EXPECT_FALSE(is_made_already(walk, other, *catalogue_).value());
  // As if made by a program that furnished the home otherwise.
  auto made = read_simulation(walk / "simulation.json").value();
  EXPECT_EQ(made.scene_sha256.size(), 64U);
  made.scene_sha256[0] = made.scene_sha256[0] == '0' ? '1' : '0';
  ASSERT_OK(write_simulation(walk / "simulation.json", made));
  EXPECT_ERROR(is_made_already(walk, short_walk(), *catalogue_), "another version of the program");
}

TEST_F(SimulateRecording, RefusesAFolderThatIsNotEmpty) {
  ASSERT_OK(write_file(folder_ / "mine.txt", "mine"));
  EXPECT_ERROR(simulate(short_walk(), ".", 1), "empty");
  SimulationOptions wrong = short_walk();
  wrong.walk.frames_per_second = 0;
  EXPECT_ERROR(simulate(wrong, "walk", 1), "frames_per_second");
}

TEST(SimulationFile, TellsOfWhatARecordingIsMade) {
  const ScratchFolder folder;
  SimulationOptions options = short_walk();
  options.home = HomeOptions{12345678901234567890ULL, {RoomKind::kKitchen, RoomKind::kHall}};
  options.home->furniture_seed = 4;
  options.home->finish_seed = 5;
  options.home->mirrored = true;
  options.scenario = Scenario::kMovedNight;
  options.walk.rooms = {"kitchen"};
  options.walk.jitter = 0.1 + 0.2;  // no short decimal
  options.sensor.edge_jitter = false;
  ASSERT_OK(write_simulation(folder / "simulation.json", {options, "abc"}));
  const auto made = read_simulation(folder / "simulation.json");
  ASSERT_OK(made);
  EXPECT_EQ(made->scene_sha256, "abc");
  const SimulationOptions* again = &made->options;
  EXPECT_EQ(again->home->seed, options.home->seed);
  EXPECT_EQ(again->home->rooms, options.home->rooms);
  EXPECT_EQ(again->home->furniture_seed, 4U);
  EXPECT_EQ(again->home->finish_seed, 5U);
  EXPECT_TRUE(again->home->mirrored);
  EXPECT_EQ(again->scenario, options.scenario);
  EXPECT_EQ(again->walk.rooms, options.walk.rooms);
  EXPECT_EQ(again->walk.jitter, options.walk.jitter);
  EXPECT_FALSE(again->sensor.edge_jitter);
  EXPECT_EQ(again->camera, options.camera);
  EXPECT_TRUE(are_alike(*again, options));
  options.render.light_cache = "elsewhere";
  EXPECT_TRUE(are_alike(*again, options));
  options.sensor.edge_jitter = true;
  EXPECT_FALSE(are_alike(*again, options));

  ASSERT_OK(write_file(folder / "simulation.json", R"({"home": "reference"})"));
  EXPECT_ERROR(read_simulation(folder / "simulation.json"), "simulation.json");
  ASSERT_OK(write_file(folder / "simulation.json", "buy milk"));
  EXPECT_ERROR(read_simulation(folder / "simulation.json"), "does not describe a simulation");
}

}  // namespace
}  // namespace roomwise::simulation
