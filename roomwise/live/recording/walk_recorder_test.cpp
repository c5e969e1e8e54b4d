#include "roomwise/live/recording/walk_recorder.h"

#include <gmock/gmock.h>

#include "roomwise/base/testing/full_disk.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/image/codec.h"
#include "roomwise/live/recording/walk_frames.h"
#include "roomwise/recording/tum_recording.h"

namespace roomwise::live {
namespace {

const geometry::PinholeCamera kLens{50, 50, 31.5, 23.5, 64, 48, {}, 1000};

class WalkRecorderFolder : public ::testing::Test {
 protected:
  WalkRecorderFolder()
      : recorder(
            WalkRecorder::begin(folder / "walk", {64, 48, kLens, true}, 1'000'000'000).value()) {}
  // As a phone's browser sends it: depth of a quarter of the size, and where the phone was.
  static CameraFrame phone_frame(double t_ms, const Eigen::Vector3d& position) {
    CameraFrame frame{t_ms, image::encode_jpeg(image::ColorImage(64, 48), 90),
                      image::encode_png(image::DepthImage(16, 12, 1500))};
    frame.camera = kLens;
    frame.depth_size = service::ImageSize{16, 12};
    frame.pose = service::FramePose{"webxr", {{Eigen::Quaterniond::Identity(), position}}};
    frame.pose->motion.up_camera = Eigen::Vector3d(0, -1, 0);
    return frame;
  }
  [[nodiscard]] std::vector<image::RgbdFrame> stored() const {
    const auto recording = recording::TumRecording::open(folder / "walk").value();
    std::vector<image::RgbdFrame> frames;
    while (auto frame = recording->next().value()) frames.push_back(*std::move(frame));
    return frames;
  }

  testing::ScratchFolder folder;
  std::shared_ptr<WalkRecorder> recorder;
};

TEST_F(WalkRecorderFolder, KeepsWhereThePhoneWasAndItsDepth) {
  CameraFrame sent = phone_frame(500, {1, 2, 3});
  ASSERT_OK(recorder->store(sent));
  ASSERT_OK(recorder->store(phone_frame(700, {1.1, 2, 3})));
  const auto frames = stored();  // while it is recorded
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(frames[1].timestamp_ns, 1'200'000'000);
  ASSERT_TRUE(frames[1].device_motion);
  EXPECT_TRUE(frames[1].device_motion->world_from_camera.translation.isApprox(
      Eigen::Vector3d(1.1, 2, 3), 1e-9));
  EXPECT_TRUE(frames[1].device_motion->up_camera->isApprox(Eigen::Vector3d(0, -1, 0), 1e-9));
  EXPECT_EQ(frames[0].depth.at(10, 10), 1500);
  EXPECT_EQ(frames[0].encoded_color, sent.color) << "the picture is not coded anew";
}

TEST_F(WalkRecorderFolder, AFrameWithoutAPoseIsStoredWithout) {
  CameraFrame lost = phone_frame(1, {0, 0, 0});
  lost.pose.reset();
  ASSERT_OK(recorder->store(lost));
  ASSERT_OK(recorder->store(phone_frame(2, {0, 0, 1})));
  const auto frames = stored();
  EXPECT_FALSE(frames[0].device_motion);
  EXPECT_TRUE(frames[1].device_motion);
}

// As where a phone's page is loaded again, or a clock is set, or is too coarse.
TEST_F(WalkRecorderFolder, AClockThatDoesNotGoForwardLosesNoFrame) {
  ASSERT_OK(recorder->store(phone_frame(5000, {0, 0, 0})));
  ASSERT_OK(recorder->store(phone_frame(5100, {0, 0, 1})));
  ASSERT_OK(recorder->store(phone_frame(10, {0, 0, 2})));
  ASSERT_OK(recorder->store(phone_frame(210, {0, 0, 3})));
  ASSERT_OK(recorder->store(phone_frame(910, {0, 0, 4})));
  ASSERT_OK(recorder->store(phone_frame(910, {0, 0, 5})));
  const auto frames = stored();
  ASSERT_EQ(frames.size(), 6U);
  EXPECT_GT(frames[5].timestamp_ns, frames[4].timestamp_ns);
  EXPECT_GT(frames[2].timestamp_ns, frames[1].timestamp_ns);
  EXPECT_NEAR(static_cast<double>(frames[3].timestamp_ns - frames[2].timestamp_ns), 200e6, 1e3);
  EXPECT_NEAR(static_cast<double>(frames[4].timestamp_ns - frames[3].timestamp_ns), 700e6, 1e3);
}

TEST_F(WalkRecorderFolder, WhatCannotBeReadIsNotStored) {
  CameraFrame frame = phone_frame(1, {0, 0, 0});
  frame.depth_size = service::ImageSize{17, 12};
  EXPECT_ERROR(recorder->store(frame), "depth image has 16 x 12");
  EXPECT_EQ(recorder->frames(), 0U);
  EXPECT_FALSE(std::filesystem::exists(folder / "walk/odometry.txt"));
}

TEST_F(WalkRecorderFolder, FramesWithoutDepthAreLeftOutAndCounted) {
  CameraFrame flat = phone_frame(1, {0, 0, 0});
  flat.depth.clear();
  ASSERT_OK(recorder->store(flat));
  ASSERT_OK(recorder->store(phone_frame(2, {0, 0, 0})));
  EXPECT_EQ(recorder->frames(), 1U);
  EXPECT_EQ(recorder->without_depth(), 1U);
}

class StoppedAtWill final : public Interruption {
 public:
  [[nodiscard]] bool interrupted() const override { return stops; }
  bool stops = false;
};

// Its list is damaged: each of its frames is told of once, and then it ends.
TEST_F(WalkRecorderFolder, AWalkThatCannotBeReadComesToItsEndAndCanBeStopped) {
  for (int i = 1; i <= 3; ++i) ASSERT_OK(recorder->store(phone_frame(i, {0, 0, 0})));
  ASSERT_OK(recorder->close());
  std::filesystem::resize_file(folder / "walk/depth.txt", 0);
  StoppedAtWill interruption;
  const auto frames = WalkFrames::open(recorder, interruption).value();
  EXPECT_FALSE(frames->next());
  EXPECT_FALSE(frames->next());
  interruption.stops = true;
  const auto stopped = frames->next();
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, ErrorCode::kInterrupted);
  interruption.stops = false;
  EXPECT_FALSE(frames->next());
  const auto end = frames->next();
  ASSERT_OK(end);
  EXPECT_FALSE(*end);
}

// A file may grow no further, as on a full disk.
TEST_F(WalkRecorderFolder, OnAFullDiskWhatWasStoredStays) {
  ASSERT_OK(recorder->store(phone_frame(1, {0, 0, 0})));
  const auto failed = [&] {
    const testing::FullDisk full(150);  // holds lines, and no image
    return recorder->store(phone_frame(2, {0, 0, 1}));
  }();
  EXPECT_ERROR(failed, "free some space");
  EXPECT_EQ(failed.error().code, ErrorCode::kDiskFull);
  EXPECT_EQ(stored().size(), 1U);
  ASSERT_OK(recorder->store(phone_frame(3, {0, 0, 2})));
  const auto frames = stored();
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_TRUE(frames[1].device_motion->world_from_camera.translation.isApprox(
      Eigen::Vector3d(0, 0, 2), 1e-9));
}

}  // namespace
}  // namespace roomwise::live
