#include "roomwise/recording/open_recording.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/base/testing/testing.h"
#include "roomwise/image/codec.h"

namespace roomwise::recording {
namespace {

using roomwise::testing::ScratchFolder;

// A TUM folder of three pictures; the second has no depth.
class SomeRecording : public ::testing::Test {
 protected:
  SomeRecording() {
    write("camera.txt", "7 7 4 3 8 6 1000\n");
    write("rgb.txt", "0.0 0.png\n0.1 1.png\n0.2 2.png\n");
    write("depth.txt", "0.0 depth.png\n0.2 depth.png\n");
    for (std::uint8_t i = 0; i < 3; ++i) {
      write(fmt::format("{}.png", i), image::encode_png(image::ColorImage(8, 6, {i, 0, 0})));
    }
    write("depth.png", image::encode_png(image::DepthImage(8, 6, 1500)));
  }
  template <typename Content>  // text or bytes
  void write(const std::filesystem::path& name, const Content& content) const {
    EXPECT_OK(write_file(folder_ / name, content));
  }

  ScratchFolder folder_;
};

TEST_F(SomeRecording, IsToldByItsContent) {
  const auto recording = open_recording(folder_.path());
  ASSERT_OK(recording);
  EXPECT_EQ((*recording)->kind(), "TUM folder");
  EXPECT_THAT((*recording)->frames(), ::testing::ElementsAre(0, 2));
  EXPECT_EQ((*recording)->pictures().size(), 3U);
  EXPECT_TRUE((*recording)->device_poses().empty());
}

TEST_F(SomeRecording, GivesEachPictureByItsIndexWhateverWasReadBefore) {
  const auto recording = open_recording(folder_.path()).value();
  ASSERT_OK(recording->next());
  EXPECT_EQ(recording->frame(2).value()->color.at(0, 0).r, 2);
  EXPECT_FALSE(recording->frame(1).value().has_value()) << "it has no depth";
  EXPECT_EQ(recording->read_color(1)->at(0, 0).r, 1) << "but a picture";
  EXPECT_FALSE(recording->frame(3).value().has_value());
  EXPECT_ERROR(recording->read_color(3), "has no picture 3");
  EXPECT_EQ(recording->next().value()->index, 2U);
  EXPECT_FALSE(recording->next().value().has_value());
}

TEST_F(SomeRecording, GivesTheDevicesMotionOfOdometryTxt) {
  write("odometry.txt",
        "# a phone\n# up 0 0 1\n-0.05 0 0 0 0.6 0 0 0.8\n0.05 1 0 0 0.6 0 0 0.8\n0.5 9 0 0 0 0 0 "
        "1\n");
  const auto recording = open_recording(folder_.path()).value();
  EXPECT_TRUE(recording->has_device_motion());
  const auto between = recording->frame(0).value()->device_motion;
  ASSERT_TRUE(between);
  EXPECT_NEAR(between->world_from_camera.translation.x(), 0.5, 1e-9) << "halfway between two poses";
  EXPECT_TRUE(between->up_camera->isApprox(Eigen::Vector3d(0, 0.96, 0.28), 1e-9));
  EXPECT_FALSE(recording->frame(2).value()->device_motion) << "poses are too far apart there";
}

TEST_F(SomeRecording, RefusesAnUpThatIsNoDirection) {
  for (const char* up : {"0 0", "0 0 2", "0 0 nan", "0 0 1 0"}) {
    write("odometry.txt", fmt::format("0.0 0 0 0 0 0 0 1\n# up {}\n", up));
    EXPECT_ERROR(open_recording(folder_.path()), "odometry.txt:2");
  }
  write("odometry.txt", "0.0 0 0 0 0 0 0\n");
  EXPECT_ERROR(open_recording(folder_.path()), "odometry.txt:1");
}

TEST_F(SomeRecording, TakesTheTruthForNoMotion) {
  write("groundtruth.txt", "0.0 0 0 0 0 0 0 1\n");
  const auto recording = open_recording(folder_.path()).value();
  EXPECT_FALSE(recording->has_device_motion());
  EXPECT_FALSE(recording->frame(0).value()->device_motion);
}

TEST_F(SomeRecording, CountsTheFramesThatAreStillToCome) {
  const auto recording = open_recording(folder_.path()).value();
  EXPECT_EQ(recording->info().frames_remaining, 2U);
  recording->skip_before(1);
  EXPECT_EQ(recording->info().frames_remaining, 1U);
}

TEST_F(SomeRecording, NamesAllKindsWhereNoneFits) {
  std::filesystem::remove(folder_ / "depth.txt");
  const auto opened = open_recording(folder_.path());
  for (const RecordingKind& kind : recording_kinds()) {
    EXPECT_ERROR(opened, std::string(kind.name));
    EXPECT_ERROR(opened, std::string(kind.told_by));
  }
  EXPECT_ERROR(open_recording(folder_ / "nowhere"), "there is no such file or folder");
  write("file", "no recording\n");
  EXPECT_ERROR(open_recording(folder_ / "file"), "is no recording of a kind that is read");
}

TEST_F(SomeRecording, HasATruthOnlyWhereSomebodyWroteOne) {
  EXPECT_ERROR(read_truth(folder_.path()), "its device wrote no poses");
  write("groundtruth.txt", "0.0 1 2 3 0 0 0 1\n");
  EXPECT_EQ(read_truth(folder_.path())->size(), 1U);
  EXPECT_EQ(read_truth(folder_ / "groundtruth.txt")->size(), 1U);
}

}  // namespace
}  // namespace roomwise::recording
