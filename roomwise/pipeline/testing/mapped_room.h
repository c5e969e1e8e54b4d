#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "roomwise/base/testing/testing.h"
#include "roomwise/fusion/testing/test_scenes.h"
#include "roomwise/image/codec.h"
#include "roomwise/pipeline/run_context.h"
#include "roomwise/pipeline/stored/keyframe_images.h"
#include "roomwise/recording/trajectory_file.h"

namespace roomwise::pipeline::testing {

using Eigen::Vector3d;
using fusion::testing::looking_at;
using geometry::RigidTransform;

// A home mapped without an error: key-frames of a walk round an empty room of 3 m by 4 m, which is
// the truth's frame; the map's is the first camera's.
class MappedRoom : public ::testing::Test {
 protected:
  static constexpr std::size_t kKeyframes = 24;

  void SetUp() override {
    home_ = std::make_unique<home::Home>(home::Home::create(folder_ / "a.home").value());
    const geometry::PinholeCamera camera = fusion::testing::small_camera();
    const auto recording = home_->add_recording({"room", "", camera, kKeyframes}).value();
    home::MapCommit step;
    step.recording = recording;
    step.next_frame_index = kKeyframes;
    recording::Trajectory truth;
    for (std::size_t i = 0; i < kKeyframes; ++i) {
      const RigidTransform pose = truth_from_camera(i);
      const auto picture = fusion::testing::render(room(), pose, camera);
      const auto time_ns = static_cast<TimestampNs>((i + 1) * 1'000'000'000);
      truth.push_back({time_ns, pose});
      step.keyframes.push_back(
          {{i, i, time_ns},
           {truth_from_camera(0).inverse() * pose, 0},
           {image::encode_png(picture.color), image::encode_png(picture.depth)},
           {},
           {}});
      step.frames.push_back({i, time_ns, home::FramePlace{i, {}}, ""});
    }
    ASSERT_OK(home_->commit(step));
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

}  // namespace roomwise::pipeline::testing
