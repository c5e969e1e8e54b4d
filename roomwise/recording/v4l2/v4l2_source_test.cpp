#include "roomwise/recording/v4l2/v4l2_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/base/testing/testing.h"
#include "roomwise/image/codec.h"
#include "roomwise/recording/v4l2/testing/fake_video_kernel.h"

namespace roomwise::recording {
namespace {

using testing::FakeVideoKernel;
using testing::FakeVideoNode;

constexpr TimestampNs kMsNs = 1'000'000;

geometry::PinholeCamera camera_of_size(int width, int height) {
  geometry::PinholeCamera camera;
  camera.fx = camera.fy = width;
  camera.cx = (width - 1) / 2.0;
  camera.cy = (height - 1) / 2.0;
  camera.width = width;
  camera.height = height;
  return camera;
}

// Rows of two bytes a pixel, as the driver pads them: the same two pixels all over.
Bytes rows_of(const v4l2_pix_format& format, std::array<std::uint8_t, 4> two_pixels) {
  Bytes bytes(format.sizeimage);
  for (std::uint32_t y = 0; y < format.height; ++y) {
    for (std::uint32_t i = 0; i < 2 * format.width; ++i) {
      bytes[y * format.bytesperline + i] = two_pixels[i % 4];
    }
  }
  return bytes;
}

// Picture n is 1000 + n units away.
Bytes depth_picture(std::uint32_t n, const v4l2_pix_format& format) {
  const std::uint32_t depth = 1000 + n;
  const auto low = static_cast<std::uint8_t>(depth), high = static_cast<std::uint8_t>(depth >> 8U);
  return rows_of(format, {low, high, low, high});
}

// Grey of brightness 50 + n, as YUYV or MJPG.
Bytes color_of_number(std::uint32_t n, const v4l2_pix_format& format) {
  const auto grey = static_cast<std::uint8_t>(50 + n);
  if (format.pixelformat == V4L2_PIX_FMT_MJPEG) {
    const image::ColorImage color(static_cast<int>(format.width), static_cast<int>(format.height),
                                  {grey, grey, grey});
    return image::encode_jpeg(color, 95);
  }
  const auto luma = static_cast<std::uint8_t>(std::lround(16 + grey * 219 / 255.0));
  return rows_of(format, {luma, 128, luma, 128});
}

// A camera like RealSense's: depth, what is beside its pictures, colour; before it a webcam.
class V4l2SourceTest : public ::testing::Test {
 protected:
  V4l2SourceTest() {
    options_.calibration.color = camera_of_size(64, 48);
    kernel_->add(video("0", "Webcam", "usb-1", {{V4L2_PIX_FMT_YUYV, {{64, 48}}}}));
    kernel_->add(depth_);
    FakeVideoNode beside = video("3", "Depth camera", "usb-2", {});
    beside.capabilities = V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING;
    kernel_->add(beside);
    kernel_->add(color_);
  }
  ~V4l2SourceTest() override { EXPECT_TRUE(kernel_->is_clean()); }

  static FakeVideoNode video(const std::string& number, const std::string& name,
                             const std::string& bus,
                             std::vector<testing::FakeVideoFormat> formats) {
    FakeVideoNode node;
    node.path = "/dev/video" + number;
    node.name = name;
    node.bus = bus;
    node.formats = std::move(formats);
    node.picture = color_of_number;
    return node;
  }
  static FakeVideoNode depth_video() {
    FakeVideoNode node = video("2", "Depth camera", "usb-2",
                               {{V4L2_PIX_FMT_GREY, {{64, 48}}},
                                {V4L2_PIX_FMT_Z16, {{64, 48}, {32, 24}}, {90, 60, 30, 15, 6}}});
    node.picture = depth_picture;
    return node;
  }
  static FakeVideoNode color_video() {
    return video("4", "Depth camera", "usb-2",
                 {{V4L2_PIX_FMT_YUYV, {{64, 48}, {1280, 720}}, {60, 30}},
                  {V4L2_PIX_FMT_MJPEG, {{128, 96}}, {30}}});
  }

  [[nodiscard]] auto open() const { return V4l2Source::open(options_, kernel_); }
  [[nodiscard]] FakeVideoNode& depth() const { return kernel_->node("/dev/video2"); }
  [[nodiscard]] FakeVideoNode& color() const { return kernel_->node("/dev/video4"); }

  const FakeVideoNode depth_ = depth_video(), color_ = color_video();
  std::shared_ptr<FakeVideoKernel> kernel_ = std::make_shared<FakeVideoKernel>();
  V4l2Options options_;
};

image::RgbdFrame frame_of(FrameSource& source) {
  auto frame = source.next();
  EXPECT_OK(frame);
  EXPECT_TRUE(frame && *frame);
  return frame && *frame ? **std::move(frame) : image::RgbdFrame();
}
// The number of the pictures that made a frame, which must be the same.
int number_of(const image::RgbdFrame& frame) {
  if (frame.depth.empty() || frame.color.empty()) return -1;
  const int number = frame.depth.at(20, 20) - 1000;
  EXPECT_NEAR(frame.color.at(20, 20).r, 50 + number, 2);
  EXPECT_EQ(frame.depth.at(frame.depth.width() - 1, frame.depth.height() - 1), 1000 + number);
  return number;
}

TEST_F(V4l2SourceTest, FindsTheCameraWithDepthAndTheColourBesideIt) {
  const auto source = open();
  ASSERT_OK(source);
  EXPECT_EQ((*source)->info().name, "Depth camera (/dev/video2, /dev/video4)");
  EXPECT_EQ((*source)->info().camera, options_.calibration.color);
  EXPECT_FALSE((*source)->info().frames_remaining);
}

TEST_F(V4l2SourceTest, GivesTheFramesOfBothStreamsInTheOrderOfTime) {
  const auto source = open();
  ASSERT_OK(source);
  const TimestampNs start_ns = kernel_->now_ns();
  for (int i = 0; i < 40; ++i) {
    const image::RgbdFrame frame = frame_of(**source);
    EXPECT_EQ(frame.index, static_cast<std::uint64_t>(i));
    EXPECT_EQ(number_of(frame), i);
    EXPECT_NEAR(static_cast<double>(frame.timestamp_ns - start_ns), i * 1e9 / 30, 2e3);
  }
  EXPECT_EQ((*source)->info().lost_frames, 0U);
}

TEST_F(V4l2SourceTest, AsksForTheFastestRateOfAtMostThirty) {
  color().formats[0].rates_hz = {60, 25, 5};
  ASSERT_OK(open());
  EXPECT_EQ(depth().interval_set.denominator, 30U);
  EXPECT_EQ(color().interval_set.denominator, 25U);
  color().formats[0].rates_hz = {120, 60};
  ASSERT_OK(open());
  EXPECT_EQ(color().interval_set.denominator, 60U) << "the slowest, where none is so slow";
}

TEST_F(V4l2SourceTest, TakesADriverThatKnowsNothingOfRates) {
  depth().knows_rates = color().knows_rates = false;
  const auto source = open();
  ASSERT_OK(source);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(number_of(frame_of(**source)), i);
}

TEST_F(V4l2SourceTest, TakesADriverThatListsNoSizes) {
  depth().lists_sizes = color().lists_sizes = false;
  const auto source = open();
  ASSERT_OK(source);
  EXPECT_EQ(number_of(frame_of(**source)), 0);
  options_.calibration.color = camera_of_size(320, 240);
  EXPECT_ERROR(open(), "/dev/video2: gives Z16 64x48 where Z16 320x240 was asked for");
}

TEST_F(V4l2SourceTest, PairsStreamsThatAreAThirdOfAPeriodApart) {
  for (const int offset : {-11, 11}) {
    (offset < 0 ? color() : depth()).offset_ns = 11 * kMsNs;
    const auto source = open();
    ASSERT_OK(source);
    for (int i = 0; i < 5; ++i) EXPECT_EQ(number_of(frame_of(**source)), i) << offset;
    color().offset_ns = depth().offset_ns = 0;
  }
}

TEST_F(V4l2SourceTest, PairsStreamsOfTwoRates) {
  depth().formats[1].rates_hz = {15};
  const auto source = open();
  ASSERT_OK(source);
  for (int i = 0; i < 5; ++i) {
    const image::RgbdFrame frame = frame_of(**source);
    EXPECT_EQ(frame.depth.at(0, 0), 1000 + i);
    EXPECT_NEAR(frame.color.at(0, 0).r, 50 + 2 * i, 2);
  }
}

TEST_F(V4l2SourceTest, GoesOnAfterASignal) {
  const auto source = open();
  ASSERT_OK(source);
  kernel_->interrupt_polls(3);
  EXPECT_EQ(number_of(frame_of(**source)), 0);
}

TEST_F(V4l2SourceTest, MovesDepthOfAnotherLensToColour) {
  // 0.1 m beside each other: 64 px * 0.1 m / 1 m = 6.4 px at 1 m.
  options_.calibration.depth = camera_of_size(32, 24);
  options_.calibration.color_from_depth.translation = {0.1, 0, 0};
  depth().picture = [](std::uint32_t, const v4l2_pix_format& format) {
    return rows_of(format, {0xE8, 0x03, 0xE8, 0x03});
  };
  const auto source = open();
  ASSERT_OK(source);
  const image::RgbdFrame frame = frame_of(**source);
  ASSERT_EQ(frame.depth.width(), 64);
  EXPECT_EQ(frame.depth.at(40, 20), 1000);
  EXPECT_EQ(frame.depth.at(63, 20), 1000);
  EXPECT_EQ(frame.depth.at(3, 20), 0) << "the depth camera does not see it";
}

TEST_F(V4l2SourceTest, ReadsPackedColour) {
  options_.calibration.color = camera_of_size(128, 96);
  options_.calibration.depth = camera_of_size(64, 48);
  const auto source = open();
  ASSERT_OK(source);
  const image::RgbdFrame frame = frame_of(**source);
  EXPECT_EQ(frame.color.width(), 128);
  EXPECT_NEAR(frame.color.at(100, 50).g, 50, 2);
}

TEST_F(V4l2SourceTest, BringsLargePicturesToTheSizeThatIsWorkedWith) {
  options_.calibration.color = camera_of_size(1280, 720);
  options_.calibration.depth = camera_of_size(64, 48);
  const auto source = open();
  ASSERT_OK(source);
  const image::RgbdFrame frame = frame_of(**source);
  EXPECT_EQ((*source)->info().camera.width, 640);
  EXPECT_EQ(frame.color.width(), 640);
  EXPECT_EQ(frame.color.height(), 360);
  EXPECT_EQ(frame.depth.width(), 640);
  EXPECT_EQ(frame.depth.at(320, 180), 1000);
}

TEST_F(V4l2SourceTest, TakesTheDevicesThatAreNamed) {
  options_.depth_device = "/dev/video2";
  options_.color_device = "/dev/video0";
  const auto source = open();
  ASSERT_OK(source);
  EXPECT_THAT((*source)->info().name, ::testing::HasSubstr("/dev/video0"));
  options_.depth_device = "/dev/video4";
  EXPECT_ERROR(open(),
               "/dev/video4 (Depth camera): YUYV 64x48, 1280x720; MJPG 128x96; depth is Z16");
  options_.depth_device = "/dev/video2";
  options_.color_device = "/dev/video3";
  EXPECT_ERROR(open(), "/dev/video3 (Depth camera): no pictures; no colour that is read");
  options_.color_device = "/dev/video9";
  EXPECT_ERROR(open(), "/dev/video9: there is no such device");
  options_.depth_device = "";
  EXPECT_ERROR(open(), "needs the device of its depth");
}

TEST_F(V4l2SourceTest, LeavesOutDamagedPicturesAndCountsThem) {
  depth().damaged = {1, 4};
  color().damaged = {2};
  color().cut = {3};
  const auto source = open();
  ASSERT_OK(source);
  std::vector<int> numbers;
  for (int i = 0; i < 4; ++i) numbers.push_back(number_of(frame_of(**source)));
  EXPECT_THAT(numbers, ::testing::ElementsAre(0, 5, 6, 7));
  EXPECT_GE((*source)->info().lost_frames, 2U);
}

TEST_F(V4l2SourceTest, LeavesOutAPackedPictureThatCannotBeDecoded) {
  options_.calibration.color = camera_of_size(128, 96);
  options_.calibration.depth = camera_of_size(64, 48);
  color().cut = {1};
  const auto source = open();
  ASSERT_OK(source);
  EXPECT_EQ(frame_of(**source).depth.at(64, 48), 1000);
  EXPECT_EQ(frame_of(**source).depth.at(64, 48), 1002);
  EXPECT_EQ((*source)->info().lost_frames, 1U);
}

TEST_F(V4l2SourceTest, CountsWhatIsMissedWhileNobodyReads) {
  const auto source = open();
  ASSERT_OK(source);
  EXPECT_EQ(number_of(frame_of(**source)), 0);
  kernel_->pass(1000 * kMsNs);
  std::vector<int> numbers;
  for (int i = 0; i < 6; ++i) numbers.push_back(number_of(frame_of(**source)));
  EXPECT_TRUE(std::ranges::is_sorted(numbers, std::less_equal()));
  EXPECT_EQ(numbers[0], 1) << "what the driver had buffers for";
  EXPECT_GE(numbers[5], 30);
  EXPECT_GE((*source)->info().lost_frames, 25U);
}

TEST_F(V4l2SourceTest, WaitsForAFrameNoLongerThanAllowed) {
  depth().is_silent = true;
  options_.timeout_s = 0.5;
  const auto source = open();
  ASSERT_OK(source);
  const TimestampNs start_ns = kernel_->now_ns();
  EXPECT_ERROR((*source)->next(), "gave no depth picture for 0.5 s; see that it is plugged in");
  EXPECT_NEAR(static_cast<double>(kernel_->now_ns() - start_ns), 0.5e9, 2e6);
}

TEST_F(V4l2SourceTest, SaysThatAllPicturesCameDamaged) {
  color().is_all_damaged = true;
  const auto source = open();
  ASSERT_OK(source);
  EXPECT_ERROR((*source)->next(), "gave no colour picture for 5 s; 15");
  EXPECT_ERROR((*source)->next(), "came damaged so far: try another cable or USB port");
}

TEST_F(V4l2SourceTest, SaysThatTheCameraWasUnpluggedInTheMiddle) {
  const auto source = open();
  ASSERT_OK(source);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(number_of(frame_of(**source)), i);
  color().unplugged_at_ns = depth().unplugged_at_ns = kernel_->now_ns() + 10 * kMsNs;
  EXPECT_ERROR((*source)->next(), "the camera was unplugged");
  EXPECT_ERROR((*source)->next(), "the camera was unplugged");
}

TEST_F(V4l2SourceTest, SaysWhyTheCameraCannotBeUsed) {
  depth().open_error = EACCES;
  EXPECT_ERROR(open(), "no camera gives depth");
  EXPECT_ERROR(open(), "/dev/video2: you may not use it; add yourself to its group");
  depth().open_error = 0;
  color().format_error = EBUSY;
  EXPECT_ERROR(open(), "/dev/video4: does not take its format: another program uses it");
  color().format_error = 0;
  color().start_error = ENOSPC;
  EXPECT_ERROR(open(), "/dev/video4: does not start: the USB bus has no room");
  color().start_error = 0;
  depth().size_given = {32, 24};
  EXPECT_ERROR(open(), "/dev/video2: gives Z16 32x24 where Z16 64x48 was asked for");
}

TEST_F(V4l2SourceTest, WantsTheSizeForWhichItIsCalibrated) {
  options_.calibration.color = camera_of_size(320, 240);
  EXPECT_ERROR(open(),
               "gives no depth of 320x240 pixels, for which it is calibrated; it gives "
               "GREY 64x48; Z16 64x48, 32x24");
}

TEST_F(V4l2SourceTest, WantsColourOfTheSameCamera) {
  color().bus = "usb-3";
  EXPECT_ERROR(open(),
               "no colour comes from the same camera; name its device, too "
               "(v4l2:/dev/video2,/dev/videoN)");
}

TEST_F(V4l2SourceTest, WantsTimesOfTheSystemsClock) {
  depth().timestamp_flags = V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN;
  const auto source = open();
  ASSERT_OK(source);
  EXPECT_ERROR((*source)->next(), "/dev/video2: its pictures have no times of the system's clock");
}

TEST(V4l2SourceWithoutCamera, SaysThatNoneIsThere) {
  V4l2Options options;
  options.calibration.color = camera_of_size(64, 48);
  EXPECT_ERROR(V4l2Source::open(options, std::make_shared<FakeVideoKernel>()),
               "there is no camera (/dev/video*); plug it in");
  EXPECT_EQ(describe_video_cameras(std::make_shared<FakeVideoKernel>()), "nothing");
}

TEST(LinuxVideoKernel, SaysOfOtherFilesThatTheyAreNoVideoDevices) {
  V4l2Options options;
  options.calibration.color = camera_of_size(64, 48);
  options.depth_device = "/dev/null";
  EXPECT_ERROR(V4l2Source::open(options), "/dev/null: is no video device");
  options.depth_device = "/dev/there-is-no-such-camera";
  EXPECT_ERROR(V4l2Source::open(options), "/dev/there-is-no-such-camera: there is no such device");
}

}  // namespace
}  // namespace roomwise::recording
