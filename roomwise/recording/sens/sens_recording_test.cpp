#include "roomwise/recording/sens/sens_recording.h"

#include <gmock/gmock.h>

#include <limits>

#include "roomwise/base/testing/testing.h"
#include "roomwise/recording/bytes/testing/quick_file.h"
#include "roomwise/recording/sens/testing/sens_writer.h"

namespace roomwise::recording {
namespace {

using namespace recording::testing;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class SensTest : public ::testing::Test {
 protected:
  Expected<std::unique_ptr<Recording>> open_bytes(std::span<const std::uint8_t> bytes) {
    write_quickly(path_, bytes);
    return open_sens_recording(path_, {});
  }
  Expected<std::unique_ptr<Recording>> open(const SensPlan& plan) {
    return open_bytes(sens_file(plan));
  }

  const roomwise::testing::ScratchFolder folder_;
  const std::filesystem::path path_ = folder_ / "scene.sens";
};

TEST_F(SensTest, GivesFramesAndPoses) {
  const auto opened = open({});
  ASSERT_OK(opened);
  const Recording& recording = **opened;
  EXPECT_TRUE(is_sens_file(path_));
  EXPECT_EQ(recording.info().camera.width, 80);
  EXPECT_EQ(recording.info().camera.fx, 100);
  EXPECT_THAT(recording.frames(), ElementsAre(0, 1, 2));
  EXPECT_EQ(recording.pictures()[1].timestamp_ns, 1'033'000'000);
  EXPECT_FALSE(recording.has_device_motion()) << "its poses are BundleFusion's";
  ASSERT_THAT(recording.device_poses(), SizeIs(2)) << "the second frame has no pose";
  EXPECT_NEAR(recording.device_poses()[1].world_from_camera.translation.x(), 2, 1e-6);
  EXPECT_THAT(recording.notes(), IsEmpty());
  const auto frame = recording.frame(2);
  ASSERT_OK(frame);
  EXPECT_NEAR((*frame)->color.at(40, 30).g, 90, 2);
  EXPECT_FALSE((*frame)->encoded_color.empty());
  EXPECT_EQ((*frame)->depth, image::DepthImage(80, 60, 1500)) << "brought to colour's size";
}

TEST_F(SensTest, LargePicturesAreBroughtToWorkingSize) {
  SensPlan plan;
  plan.color_width = 1280;
  plan.color_height = 960;
  const auto opened = open(plan);
  ASSERT_OK(opened);
  EXPECT_EQ((*opened)->info().camera.width, 640);
  const auto frame = (*opened)->frame(0);
  ASSERT_OK(frame);
  EXPECT_EQ((*frame)->color.height(), 480);
  EXPECT_EQ((*frame)->depth.height(), 480);
  EXPECT_TRUE((*frame)->encoded_color.empty());
}

TEST_F(SensTest, PlainDepthIsReadToo) {
  SensPlan plan;
  plan.depth_packing = 0;
  const auto opened = open(plan);
  ASSERT_OK(opened);
  EXPECT_EQ((*opened)->frame(0).value()->depth.at(7, 7), 1500);
}

TEST_F(SensTest, FramesWithoutTimesAreThirtyASecond) {
  SensPlan plan;
  plan.times_us = {0, 0, 0};
  const auto opened = open(plan);
  ASSERT_OK(opened);
  EXPECT_NEAR(
      seconds_between((*opened)->pictures()[0].timestamp_ns, (*opened)->pictures()[2].timestamp_ns),
      2.0 / 30, 1e-6);
  EXPECT_THAT((*opened)->notes(), ElementsAre(HasSubstr("30 a second are assumed")));
}

TEST_F(SensTest, ATimeThatDoesNotFitCostsItsFrameAlone) {
  for (const std::uint64_t damaged : {1'033'000U, 7U, 9'000'000U}) {  // again, back, far ahead
    SensPlan plan;
    plan.frame_count = 4;
    plan.colors = std::vector(4, image::encode_jpeg(image::ColorImage(80, 60, {9, 9, 9}), 90));
    plan.times_us = {1'000'000, 1'033'000, damaged, 1'099'000};
    const auto opened = open(plan);
    ASSERT_OK(opened);
    EXPECT_THAT((*opened)->frames(), ElementsAre(0, 1, 3));
    EXPECT_EQ((*opened)->pictures()[2].timestamp_ns, 1'099'000'000);
    EXPECT_OK((*opened)->frame(3));
    EXPECT_THAT((*opened)->device_poses(), SizeIs(2));
    EXPECT_THAT((*opened)->notes(), IsEmpty());
    ASSERT_THAT((*opened)->damaged(), SizeIs(1));
    EXPECT_EQ((*opened)->damaged()[0].index, 2U);
    EXPECT_THAT((*opened)->damaged()[0].why,
                HasSubstr("scene.sens: the time of frame 2 does not fit those of the others"));
  }
}

TEST_F(SensTest, RefusesWhatItDoesNotRead) {
  SensPlan plan;
  plan.version = 3;
  EXPECT_ERROR(open(plan), "is of version 3");
  EXPECT_FALSE(is_sens_file(path_));
  plan = {};
  plan.color_packing = -1;
  EXPECT_ERROR(open(plan), "write it as JPEG");
  plan = {};
  plan.depth_packing = 2;
  EXPECT_ERROR(open(plan), "write it with zlib");
  plan = {};
  plan.color_offset_m = 0.02;
  EXPECT_ERROR(open(plan), "lie apart");
}

TEST_F(SensTest, ANumberOfFramesThatLiesCostsNothing) {
  SensPlan plan;
  plan.frame_count = std::numeric_limits<std::uint64_t>::max();
  const auto opened = open(plan);
  ASSERT_OK(opened);
  EXPECT_THAT((*opened)->frames(), SizeIs(3));
  EXPECT_THAT((*opened)->notes(), ElementsAre(HasSubstr("ends within frame 3 of")));
}

TEST_F(SensTest, DepthOfAnotherSizeIsRefused) {
  SensPlan plan;
  plan.depth_packing = 0;
  Bytes bytes = sens_file(plan);
  const std::size_t sides = 4 + 8 + 15 + 4 * 64 + 8;
  bytes[sides + 8] = 41;  // depth's width
  const auto opened = open_bytes(bytes);
  ASSERT_OK(opened);
  EXPECT_ERROR((*opened)->frame(0), "scene.sens: frame 0: holds 2400 bytes instead of 2460");
}

TEST_F(SensTest, AFileThatWasCutOffGivesAnErrorOrTheFramesBefore) {
  const Bytes whole = sens_file({});
  std::size_t most = 0;
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const auto opened = open_bytes(std::span(whole).first(size));
    if (!opened) {
      EXPECT_THAT(opened.error().message, HasSubstr("scene.sens"));
      continue;
    }
    if ((*opened)->frames().size() == most) continue;
    EXPECT_EQ((*opened)->frames().size(), most + 1);
    EXPECT_OK((*opened)->frame(most++));
  }
  EXPECT_EQ(most, 3U);
}

}  // namespace
}  // namespace roomwise::recording
