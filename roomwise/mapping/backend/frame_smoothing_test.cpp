#include "roomwise/mapping/backend/frame_smoothing.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "roomwise/base/testing/testing.h"
#include "roomwise/mapping/testing/synthetic_bundle.h"

namespace roomwise::mapping {
namespace {

using geometry::RigidTransform;

RigidTransform truth(double t) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(0.8 * std::sin(1.5 * t), Eigen::Vector3d::UnitY())),
          {0.3 * std::sin(2 * t), 0.2 * std::cos(1.3 * t), 0.1 * t}};
}

// A hand's walk, every fourth frame a key-frame.
std::vector<PlacedFrame> walk(double frame_s, double noise_m) {
  RandomStream random(5);
  std::vector<PlacedFrame> frames;
  for (int i = 0; i < 100; ++i) {
    const double t = frame_s * i;
    const bool is_fixed = i % 4 == 0;
    const double noise = is_fixed ? 0 : noise_m;
    frames.push_back({static_cast<TimestampNs>(std::llround(1e9 * t)),
                      truth(t) * testing::random_transform(random, noise, noise), is_fixed});
  }
  return frames;
}

double rms_error_m(const std::vector<PlacedFrame>& frames, double frame_s) {
  double sum = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const RigidTransform error =
        truth(frame_s * static_cast<double>(i)).inverse() * *frames[i].world_from_camera;
    sum += error.translation.squaredNorm() + std::pow(error.angle_rad(), 2);
  }
  return std::sqrt(sum / static_cast<double>(frames.size()));
}

TEST(SmoothFrames, TakesAwayNoise) {
  auto frames = walk(0.033, 0.005);
  const double before = rms_error_m(frames, 0.033);
  smooth_frames(frames);
  EXPECT_LT(rms_error_m(frames, 0.033), 0.7 * before);
}

TEST(SmoothFrames, PutsAWrongFrameBack) {
  auto frames = walk(0.033, 0);
  frames[46].world_from_camera->translation.x() += 0.15;
  frames[71].world_from_camera->rotation *=
      Eigen::Quaterniond(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX()));
  smooth_frames(frames);
  EXPECT_LT(rms_error_m(frames, 0.033), 0.002);
}

TEST(SmoothFrames, LeavesWhatIsRightAndWhatIsHeld) {
  auto frames = walk(0.033, 0);
  const auto before = frames;
  smooth_frames(frames);
  EXPECT_LT(rms_error_m(frames, 0.033), 0.001);
  for (std::size_t i = 0; i < frames.size(); i += 4) {
    EXPECT_EQ(frames[i].world_from_camera->translation, before[i].world_from_camera->translation);
    EXPECT_EQ(frames[i].world_from_camera->rotation.coeffs(),
              before[i].world_from_camera->rotation.coeffs());
  }
}

TEST(SmoothFrames, ChangesNothingWhereFramesAreFarApartOrTooFewAreHeld) {
  const auto expect_unchanged = [](std::vector<PlacedFrame> frames) {
    const auto before = frames;
    smooth_frames(frames);
    for (std::size_t i = 0; i < frames.size(); ++i) {
      EXPECT_LT(
          (frames[i].world_from_camera->translation - before[i].world_from_camera->translation)
              .norm(),
          1e-12);
    }
  };
  expect_unchanged(walk(0.3, 0.01));
  auto frames = walk(0.033, 0.01);
  frames.resize(20);
  expect_unchanged(frames);
  expect_unchanged({});
}

TEST(SmoothFrames, DoesNotReachAcrossAGap) {
  auto frames = walk(0.033, 0);
  const auto untouched = frames;
  frames[50].world_from_camera.reset();
  frames[51].world_from_camera->translation.x() += 0.1;  // nothing says that it is wrong
  frames[52].world_from_camera.reset();
  smooth_frames(frames);
  EXPECT_FALSE(frames[50].world_from_camera.has_value());
  EXPECT_NEAR(frames[51].world_from_camera->translation.x(),
              untouched[51].world_from_camera->translation.x() + 0.1, 1e-12);
}

TEST(SmoothingOptions, SayWhichIsWrong) {
  SmoothingOptions options;
  EXPECT_OK(options.validate());
  options.acceleration_share = 0;
  EXPECT_ERROR(options.validate(), "acceleration_share");
}

}  // namespace
}  // namespace roomwise::mapping
