#include "roomwise/pipeline/dense_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "roomwise/base/testing.h"
#include "roomwise/fusion/test_scenes.h"
#include "roomwise/image/codec.h"
#include "roomwise/pipeline/keyframe_images.h"
#include "roomwise/pipeline/level_map.h"
#include "roomwise/pipeline/synthetic_walk.h"
#include "roomwise/pipeline/truth_evaluation.h"

namespace roomwise::pipeline {
namespace {

using Eigen::Vector3d;
using fusion::testing::looking_at;
using geometry::RigidTransform;

// A home mapped without an error: key-frames of a walk round an empty room of 3 m by 4 m, which is
// the truth's frame; the map's is the first camera's.
class DenseMapTest : public ::testing::Test {
 protected:
  static constexpr std::size_t kKeyframes = 24;

  void SetUp() override {
    home_ = std::make_unique<home::Home>(home::Home::create(folder_ / "a.home").value());
    const geometry::PinholeCamera camera = fusion::testing::small_camera();
    const auto recording = home_->add_recording({"room", "", camera, kKeyframes}).value();
    home::Step step;
    step.recording = recording;
    step.next_frame_index = kKeyframes;
    recording::Trajectory truth;
    for (std::size_t i = 0; i < kKeyframes; ++i) {
      const RigidTransform pose = truth_from_camera(i);
      const auto picture = fusion::testing::render(room(), pose, camera);
      const auto time_ns = static_cast<TimestampNs>((i + 1) * 1'000'000'000);
      truth.push_back({time_ns, pose});
      step.keyframes.push_back(
          {.id = i,
           .frame_index = i,
           .timestamp_ns = time_ns,
           .pose = {truth_from_camera(0).inverse() * pose, 0},
           .images = {image::encode_png(picture.color), image::encode_png(picture.depth)},
           .predictions = {},
           .sightings = {}});
      step.frames.push_back({i, time_ns, home::FramePlace{i, {}}, ""});
    }
    ASSERT_OK(home_->commit_step(step));
    ASSERT_OK(recording::write_trajectory(folder_ / "groundtruth.txt", truth));
  }

  static fusion::testing::Scene room() {
    return {fusion::testing::half_space(Vector3d::UnitZ(), 0),
            fusion::testing::half_space(Vector3d::UnitX(), 0),
            fusion::testing::half_space(-Vector3d::UnitX(), -3),
            fusion::testing::half_space(Vector3d::UnitY(), 0),
            fusion::testing::half_space(-Vector3d::UnitY(), -4)};
  }
  static RigidTransform truth_from_camera(std::size_t i) {
    const double angle = 0.3 + 2 * std::numbers::pi * static_cast<double>(i % 12) / 12;
    const Vector3d out(std::cos(angle), std::sin(angle), 0);
    const Vector3d middle(1.5, 2, 1.4);
    // From the middle outwards, and along the walls inwards.
    return i < 12 ? looking_at(middle + 0.2 * out, middle + out - Vector3d(0, 0, 0.6))
                  : looking_at(middle + 1.1 * out, middle - out - Vector3d(0, 0, 1));
  }
  std::vector<home::Keyframe> keyframes() const { return map_keyframes(*home_).value(); }

  roomwise::testing::ScratchFolder folder_;
  std::unique_ptr<home::Home> home_;
  ThreadPool pool_{2};
  SilentProgress progress_;
  StageClock clock_;
  RunContext run_{pool_, progress_, clock_};
};

TEST_F(DenseMapTest, FollowsWhenTheMapIsCorrected) {
  auto bent = keyframes();
  for (std::size_t i = 0; i < bent.size(); i += 3) {
    bent[i].pose.world_from_keyframe.translation += Vector3d(0.04, 0, 0.03);
  }
  bent.pop_back();
  auto map = build_dense_map(*home_, bent, 0.02, run_);
  ASSERT_OK(map);
  const auto right = build_dense_map(*home_, keyframes(), 0.02, run_);
  ASSERT_OK(right);
  EXPECT_FALSE(map->field() == right->field());
  ASSERT_OK(map->follow(*home_, keyframes(), run_));
  EXPECT_TRUE(map->field() == right->field());
  EXPECT_EQ(map->fused().size(), kKeyframes);
}

TEST_F(DenseMapTest, RefusesVoxelsOfNoUse) {
  EXPECT_ERROR(build_dense_map(*home_, keyframes(), 0, run_), "voxel_size_m");
}

TEST_F(DenseMapTest, NamesTheKeyframeThatIsDamaged) {
  ASSERT_OK(
      home_->database().run("UPDATE keyframe_images SET depth = x'00' WHERE keyframe_id = 3"));
  EXPECT_ERROR(build_dense_map(*home_, keyframes(), 0.02, run_), "a.home: key-frame 3");
}

TEST_F(DenseMapTest, NamesTheKeyframeWhoseImageHasAnotherSize) {
  ASSERT_OK(home_->database().run("UPDATE recordings SET width_px = width_px + 1"));
  EXPECT_ERROR(build_dense_map(*home_, keyframes(), 0.02, run_), "its camera takes");
}

TEST_F(DenseMapTest, AHomeWithoutAMapIsRefused) {
  const auto empty = home::Home::create(folder_ / "empty.home");
  ASSERT_OK(empty);
  EXPECT_ERROR(build_level_map(*empty, 0.02, run_), "empty.home: the home has no map yet");
}

TEST_F(DenseMapTest, CellsMustGoWithTheVoxels) {
  EXPECT_OK(validate_cell(0.05, 0.02));
  EXPECT_ERROR(validate_cell(0.01, 0.02), "0.04 to 0.16");
  EXPECT_ERROR(validate_cell(0.2, 0.02), "0.04 to 0.16");
  EXPECT_ERROR(validate_cell(std::nan(""), 0.02), "0.04 to 0.16");
}

TEST_F(DenseMapTest, KnowsWhereAPersonMayStand) {
  // Truth: a wall all round, and 0.25 m from it a person's middle.
  std::string rows;
  for (int row = 0; row < 80; ++row) {
    std::string cells(60, '#');
    if (row >= 5 && row < 75) cells.replace(5, 50, std::string(50, '.'));
    rows += (row > 0 ? ",\"" : "\"") + cells + "\"";
  }
  ASSERT_OK(write_file(
      folder_ / "floorplan.json",
      std::string_view(R"({"ceiling_height": 2.6, "wall_thickness": 0.1, "rooms": [], "walls": [],
                    "doors": [], "windows": [], "free_space": {"origin": [0, 0], "cell": 0.05,
                    "person_radius": 0.25, "rows": [)" +
                       rows + "]}}")));
  testing::write_mapped_pictures(*home_, folder_.path());
  const auto floor = evaluate_floor(*home_, folder_.path(), run_);
  ASSERT_OK(floor);
  EXPECT_NEAR(floor->error.true_m2, 2.5 * 3.5, 1e-9);
  EXPECT_GT(floor->error.precision_within_cell, 0.99);
  EXPECT_GT(floor->error.recall_within_cell, 0.97);
  EXPECT_NEAR(floor->floor_above_truth_m, 0, 0.005);
  EXPECT_LT(floor->tilt_rad, 0.005);
}

}  // namespace
}  // namespace roomwise::pipeline
