#include "roomwise/recording/robot/robot_recording.h"

#include <gmock/gmock.h>

#include <numbers>
#include <thread>

#include "roomwise/base/testing/testing.h"
#include "roomwise/image/codec.h"
#include "roomwise/image/testing/exif_writer.h"
#include "roomwise/recording/bytes/testing/quick_file.h"
#include "roomwise/recording/robot/testing/robot_log.h"

namespace roomwise::recording {
namespace {

using namespace recording::testing;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class RobotTest : public ::testing::Test {
 protected:
  Expected<std::unique_ptr<Recording>> open_bytes(std::span<const std::uint8_t> bytes,
                                                  bool is_bag = true,
                                                  const RecordingOptions& options = {}) {
    const auto path = folder_ / "walk";
    write_quickly(path, bytes);
    EXPECT_EQ(is_ros1_bag_file(path), is_bag && bytes.size() >= 13);
    return is_bag ? open_ros1_bag_recording(path, options) : open_mcap_recording(path, options);
  }
  Expected<std::unique_ptr<Recording>> open(const RobotLog& log,
                                            const RecordingOptions& options = {}) {
    return open_bytes(BagWriter::write(log.plan()), true, options);
  }
  Expected<std::unique_ptr<Recording>> open_mcap(const RobotLog& log) {
    return open_bytes(McapWriter::write(log.plan("zstd")), false);
  }

 private:
  roomwise::testing::ScratchFolder folder_;
};

void expect_simple_robot(const Expected<std::unique_ptr<Recording>>& opened) {
  ASSERT_OK(opened);
  Recording& recording = **opened;
  EXPECT_EQ(recording.info().name, "walk");
  EXPECT_EQ(recording.info().camera.fx, 50);
  EXPECT_EQ(recording.info().camera.depth_units_per_metre, 1000);
  EXPECT_THAT(recording.pictures(), SizeIs(4));
  EXPECT_THAT(recording.frames(), ElementsAre(0, 1, 3));
  ASSERT_THAT(recording.device_poses(), SizeIs(4));
  EXPECT_EQ(recording.device_poses()[2].timestamp_ns, kStart + 2 * kTenth);
  EXPECT_NEAR(recording.device_poses()[2].world_from_camera.translation.x(), 2.5, 1e-9);
  const auto frame = recording.frame(3);
  ASSERT_OK(frame);
  ASSERT_TRUE(frame->has_value());
  EXPECT_EQ((*frame)->index, 3U);
  EXPECT_EQ((*frame)->timestamp_ns, kStart + 3 * kTenth);
  EXPECT_EQ((*frame)->color.at(0, 0).r, 3);
  EXPECT_EQ((*frame)->depth, image::DepthImage(kWidth, kHeight, 2000));
  EXPECT_EQ(recording.read_color(2).value().at(0, 0).r, 2);
  EXPECT_THAT(recording.describe(recording.pictures()[1]),
              HasSubstr("/camera/color/image_raw at "));
}

TEST_F(RobotTest, ABagGivesFramesAndPoses) {
  expect_simple_robot(open(simple_robot()));
}

TEST_F(RobotTest, AnMcapFileOfRos2GivesTheSame) {
  expect_simple_robot(open_mcap(simple_robot(Encoding::kCdr)));
}

TEST_F(RobotTest, AnMcapFileOfRos1GivesTheSame) {
  expect_simple_robot(open_mcap(simple_robot()));
}

TEST_F(RobotTest, FramesComeOneAfterTheOther) {
  const auto opened = open(simple_robot());
  ASSERT_OK(opened);
  Recording& recording = **opened;
  recording.skip_before(1);
  EXPECT_EQ(recording.info().frames_remaining, 2U);
  EXPECT_EQ(recording.next().value()->index, 1U);
  EXPECT_EQ(recording.next().value()->index, 3U);
  EXPECT_FALSE(recording.next().value().has_value());
}

TEST_F(RobotTest, SeveralThreadsReadAtOnce) {
  const auto opened = open(simple_robot());
  ASSERT_OK(opened);
  std::vector<std::thread> threads;
  for (int thread = 0; thread < 4; ++thread) {
    threads.emplace_back([&] {
      for (int i = 0; i < 40; ++i) {
        const auto frame = (*opened)->frame(static_cast<std::uint64_t>(i % 2));
        ASSERT_OK(frame);
        EXPECT_EQ((*frame)->color.at(0, 0).r, i % 2);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
}

TEST_F(RobotTest, RegisteredDepthIsTakenBeforeOtherAndTheOthersAreNamed) {
  RobotLog log = simple_robot();
  log.info("/camera/depth/camera_info", "depth").info("/camera/infra/camera_info", "depth");
  log.transform("/tf_static", kStart, "base", "depth", 0.52);
  for (int i = 0; i < 9; ++i) {
    log.depth("/camera/depth/image_rect_raw", kStart + i * kTenth, "depth", 1000);
    log.image("/camera/infra/image_raw", kStart + i * kTenth, "depth", "mono8", kWidth, kHeight,
              Bytes(kWidth * kHeight, 7));
  }
  const auto opened = open(log);
  expect_simple_robot(opened);
  EXPECT_THAT(
      (*opened)->notes(),
      Contains("colour is /camera/color/image_raw, depth /camera/aligned/image_raw; not taken: "
               "/camera/depth/image_rect_raw, /camera/infra/image_raw"));
}

TEST_F(RobotTest, DepthOfAnotherCameraIsRegisteredByTransforms) {
  RobotLog log;
  log.info("/camera/color/camera_info", "color", 100)
      .info("/camera/depth/camera_info", "depth", 100);
  log.transform("/tf_static", kStart, "link", "color", 0.1);
  log.transform("/tf_static", kStart, "link", "depth", 0);
  log.color("/camera/color/image_raw", kStart, "color");
  log.depth("/camera/depth/image_rect_raw", kStart, "depth");
  const auto opened = open(log);
  ASSERT_OK(opened);
  const auto frame = (*opened)->frame(0);
  ASSERT_OK(frame);
  // 0.1 * 100 / 2 = 5 px to the left.
  EXPECT_EQ((*frame)->depth.at(34, 10), 2000);
  EXPECT_EQ((*frame)->depth.at(36, 10), 0);
  EXPECT_THAT((*opened)->notes(), Contains(HasSubstr("registered to colour here")));
  EXPECT_THAT((*opened)->device_poses(), IsEmpty());
}

TEST_F(RobotTest, DepthOfAnotherCameraNeedsATransform) {
  RobotLog log;
  log.info("/camera/color/camera_info", "color").info("/camera/depth/camera_info", "depth");
  log.color("/camera/color/image_raw", kStart, "color");
  log.depth("/camera/depth/image_rect_raw", kStart, "depth");
  EXPECT_ERROR(open(log),
               "frame 'depth') and /camera/color/image_raw (frame 'color'): no transform");
}

// As librealsense records: no frames, a common reference, the unit beside the picture.
TEST_F(RobotTest, RealSenseIsRegisteredByItsExtrinsics) {
  RobotLog log;
  const std::string depth = "/device_0/sensor_0/Depth_0", color = "/device_0/sensor_1/Color_0";
  log.info(depth + "/info/camera_info", "", 100).info(color + "/info/camera_info", "", 100);
  const auto extrinsics = [](double x) {
    return RosWriter(Encoding::kRos1).transform({Eigen::Quaterniond::Identity(), {x, 0, 0}}).take();
  };
  log.add(depth + "/tf/0", "geometry_msgs/Transform", 0, extrinsics(0));
  log.add(color + "/tf/0", "geometry_msgs/Transform", 0, extrinsics(-0.1));
  log.add("/device_0/sensor_0/option/Depth Units/value", "std_msgs/Float32", 0,
          RosWriter(Encoding::kRos1).number<float>(0.0001F).take());
  ByteWriter data;
  for (std::uint32_t i = 0; i < kWidth * kHeight; ++i) data.number<std::uint16_t>(20'000);
  log.image(depth + "/image/data", kStart, "0", "mono16", kWidth, kHeight, data.all());
  log.color(color + "/image/data", kStart, "0");
  const auto opened = open(log);
  ASSERT_OK(opened);
  EXPECT_NEAR((*opened)->info().camera.depth_units_per_metre, 10'000, 1e-6);
  const auto frame = (*opened)->frame(0);
  ASSERT_OK(frame);
  // Points move by 0.1 m to the left in the colour camera: 5 px.
  EXPECT_EQ((*frame)->depth.at(34, 10), 20'000);
  EXPECT_EQ((*frame)->depth.at(36, 10), 0);
}

// Drives 1 m between two pictures while its head moves by `head_m` on it.
RobotLog robot_with_a_head(double head_m) {
  RobotLog log;
  log.info("/camera/camera_info", "color");
  log.transform("/tf_static", kStart, "head", "color", 0.5);
  for (int i = 0; i < 3; ++i) {
    const TimestampNs time = kStart + i * kTenth;
    log.color("/camera/rgb", time, "color").depth("/camera/depth", time, "color");
    log.transform("/tf", time, "base", "head", head_m * i).odometry(time, "base", i);
  }
  return log;
}

TEST_F(RobotTest, OdometryTellsPosesWhereTransformsDoNot) {
  for (const double head_m : {0.0, 0.1}) {
    const auto opened = open(robot_with_a_head(head_m));
    ASSERT_OK(opened);
    EXPECT_TRUE((*opened)->has_device_motion());
    ASSERT_THAT((*opened)->device_poses(), SizeIs(3));
    EXPECT_NEAR((*opened)->device_poses()[2].world_from_camera.translation.x(), 2.5 + 2 * head_m,
                1e-9);
  }
}

TEST_F(RobotTest, TransformsTellPosesWhereTheyMoveTheRobot) {
  for (const std::string world : {"map", "odom"}) {
    RobotLog log = robot_with_a_head(0.1);
    for (int i = 0; i < 3; ++i) {
      log.transform("/tf", kStart + i * kTenth, world, "base", 10 * i);
    }
    const auto opened = open(log);
    ASSERT_OK(opened);
    EXPECT_EQ((*opened)->has_device_motion(), world == "odom");
    ASSERT_THAT((*opened)->device_poses(), SizeIs(3));
    EXPECT_NEAR((*opened)->device_poses()[2].world_from_camera.translation.x(), 20.7, 1e-9);
  }
}

// A camera that stands still, in whose frame the sensor lies a quarter turn about z.
TEST_F(RobotTest, AnInertialSensorIsReadInTheCamerasFrame) {
  for (const bool is_connected : {true, false}) {
    RobotLog log;
    log.info("/camera/camera_info", "color");
    log.color("/camera/rgb", kStart, "color").depth("/camera/depth", kStart, "color");
    const Eigen::Quaterniond quarter(
        Eigen::AngleAxisd(-std::numbers::pi / 2, Eigen::Vector3d::UnitZ()));
    const TransformMessage turned{{kStart, "color"}, "imu", {quarter, {0.1, 0, 0}}};
    if (is_connected) {
      log.add("/tf_static", "tf2_msgs/TFMessage", kStart,
              write_transforms(Encoding::kRos1, {turned}));
    }
    for (int i = 0; i < 3; ++i) {
      const TimestampNs time = kStart + i * kTenth / 20;
      const InertialMessage one{{time, "imu"}, {time, {0.5, 0, 0}, {9.8, 0, 0}}};
      log.add("/imu", "sensor_msgs/Imu", time, write_inertial(Encoding::kRos1, one));
    }
    const auto opened = open(log);
    ASSERT_OK(opened);
    const geometry::InertialTrack& felt = (*opened)->inertial();
    ASSERT_THAT(felt.samples(), SizeIs(3));
    EXPECT_TRUE(felt.tells_turns());
    const Eigen::Vector3d expected =
        is_connected ? Eigen::Vector3d(0, -1, 0) : Eigen::Vector3d::UnitX();
    EXPECT_TRUE(felt.samples()[2].turning_rad_s.isApprox(0.5 * expected));
    EXPECT_TRUE(felt.samples()[2].force_m_s2.isApprox(9.8 * expected));
    EXPECT_EQ(std::ranges::count_if((*opened)->notes(),
                                    [](const std::string& note) {
                                      return note.find("how the sensor is turned") !=
                                             std::string::npos;
                                    }),
              is_connected ? 0 : 1);
  }
}

TEST_F(RobotTest, OdometryHoldsWhatAnInertialSensorFelt) {
  RobotLog log = robot_with_a_head(0);
  log.add("/imu", "sensor_msgs/Imu", kStart,
          write_inertial(Encoding::kRos1, {{kStart, "base"}, {kStart, {0, 0, 0}, {0, 0, 9.8}}}));
  const auto opened = open(log);
  ASSERT_OK(opened);
  EXPECT_TRUE((*opened)->inertial().empty());
}

TEST_F(RobotTest, CompressedImagesAreKeptAsTheyCame) {
  RobotLog log;
  log.info("/camera/camera_info", "color");
  const Bytes jpeg = image::encode_jpeg(image::ColorImage(kWidth, kHeight, {90, 80, 70}), 90);
  const Bytes png = image::encode_png(image::DepthImage(kWidth, kHeight, 1234));
  Bytes depth(12, 0);
  depth.insert(depth.end(), png.begin(), png.end());
  log.add("/camera/rgb/compressed", "sensor_msgs/CompressedImage", kStart,
          write_compressed_image(Encoding::kRos1,
                                 {{kStart, "color"}, "rgb8; jpeg compressed bgr8", jpeg}));
  log.add("/camera/depth/compressedDepth", "sensor_msgs/CompressedImage", kStart,
          write_compressed_image(Encoding::kRos1,
                                 {{kStart, "color"}, "16UC1; compressedDepth png", depth}));
  const auto opened = open(log);
  ASSERT_OK(opened);
  const auto frame = (*opened)->frame(0);
  ASSERT_OK(frame);
  EXPECT_EQ((*frame)->encoded_color, jpeg);
  EXPECT_EQ((*frame)->encoded_depth, png);
  EXPECT_EQ((*frame)->depth.at(5, 5), 1234);
}

TEST_F(RobotTest, AGreyPngOfSixteenBitsIsDepthWhereItIsCalledSoAlone) {
  const auto open_with = [this](const std::string& topic, const std::string& format) {
    RobotLog log;
    log.info("/camera/camera_info", "color").color("/camera/rgb", kStart, "color");
    Bytes picture(format.find("compressedDepth") == std::string::npos ? 0 : 12, 0);
    const Bytes png = image::encode_png(image::DepthImage(kWidth, kHeight, 1234));
    picture.insert(picture.end(), png.begin(), png.end());
    log.add(topic, "sensor_msgs/CompressedImage", kStart,
            write_compressed_image(Encoding::kRos1, {{kStart, "color"}, format, picture}));
    return open(log);
  };
  EXPECT_ERROR(open_with("/camera/infra/compressed", "mono16; png compressed "),
               "depth none; of other kinds /camera/infra/compressed");
  EXPECT_OK(open_with("/camera/Depth/compressed", "mono16; png compressed "));
  EXPECT_OK(open_with("/camera/range/packed", "mono16; compressedDepth png"));
  EXPECT_OK(open_with("/camera/range/compressed", "16UC1; png compressed "));
}

TEST_F(RobotTest, WhereItWasAndByWhomAPictureIsSaysSoAlone) {
  EXPECT_FALSE(open(simple_robot()).value()->info().personal_data.any());
  RobotLog with_gps = simple_robot();
  with_gps.add("/fix", "sensor_msgs/NavSatFix", kStart, Bytes(8));
  EXPECT_EQ(open(with_gps).value()->info().personal_data,
            (image::PersonalData{true, false, false}));
  RobotLog log;
  log.info("/camera/camera_info", "color");
  const Bytes jpeg = image::testing::with_exif(
      image::encode_jpeg(image::ColorImage(kWidth, kHeight, {90, 80, 70}), 90),
      image::testing::exif_with_place(1));
  log.add("/camera/rgb/compressed", "sensor_msgs/CompressedImage", kStart,
          write_compressed_image(Encoding::kRos1,
                                 {{kStart, "color"}, "rgb8; jpeg compressed bgr8", jpeg}));
  log.depth("/camera/depth", kStart, "color");
  const auto opened = open(log);
  ASSERT_OK(opened);
  EXPECT_EQ((*opened)->info().personal_data, (image::PersonalData{true, true, true}));
  EXPECT_EQ(image::testing::secrets_in(image::color_file(*(*opened)->frame(0).value())), "");
}

TEST_F(RobotTest, LargePicturesAreBroughtToWorkingSize) {
  RobotLog log;
  log.info("/camera/camera_info", "color", 1000, 1280, 720);
  log.image("/camera/rgb", kStart, "color", "rgb8", 1280, 720, Bytes(3 * 1280 * 720, 60));
  ByteWriter data;
  for (int i = 0; i < 1280 * 720; ++i) data.number<std::uint16_t>(1500);
  log.image("/camera/depth", kStart, "color", "16UC1", 1280, 720, data.all());
  const auto opened = open(log);
  ASSERT_OK(opened);
  EXPECT_EQ((*opened)->info().camera.width, 640);
  EXPECT_EQ((*opened)->info().camera.height, 360);
  EXPECT_NEAR((*opened)->info().camera.fx, 500, 1e-9);
  const auto frame = (*opened)->frame(0);
  ASSERT_OK(frame);
  EXPECT_EQ((*frame)->color.width(), 640);
  EXPECT_EQ((*frame)->depth, image::DepthImage(640, 360, 1500));
}

TEST_F(RobotTest, TimesOfRecordingStandInForHeadersWithoutTime) {
  RobotLog log;
  log.info("/camera/camera_info", "color");
  for (int i = 0; i < 3; ++i) {
    Bytes pixels(3 * kWidth * kHeight, 1);
    ImageMessage image;
    image.header = {0, "color"};
    image.width = kWidth;
    image.height = kHeight;
    image.pixels = "rgb8";
    image.step = 3 * kWidth;
    image.data = pixels;
    log.add("/camera/rgb", "sensor_msgs/Image", kStart + i * kTenth,
            write_image(Encoding::kRos1, image));
    log.depth("/camera/depth", kStart + i * kTenth, "color");
  }
  const auto opened = open(log);
  ASSERT_OK(opened);
  EXPECT_THAT((*opened)->frames(), SizeIs(3));
  EXPECT_EQ((*opened)->pictures()[1].timestamp_ns, kStart + kTenth);
  EXPECT_THAT((*opened)->notes(), Contains(HasSubstr("no times")));
}

TEST_F(RobotTest, ACameraThatIsGivenMustFit) {
  RecordingOptions options;
  options.camera = geometry::camera_preset("kinect-v1").value();
  EXPECT_ERROR(open(simple_robot(), options), "40x30 pixels, the camera that is given 640x480");
  options.camera->width = kWidth;
  options.camera->height = kHeight;
  options.camera->fx = 44;
  const auto opened = open(simple_robot(), options);
  ASSERT_OK(opened);
  EXPECT_EQ((*opened)->info().camera.fx, 44);
}

TEST_F(RobotTest, TheCameraThatAHomeKeepsOfLargePicturesIsTakenAgain) {
  RobotLog log;
  log.info("/camera/camera_info", "color", 1000, 1280, 720);
  log.image("/camera/rgb", kStart, "color", "mono8", 1280, 720, Bytes(1280 * 720, 60));
  log.image("/camera/depth", kStart, "color", "16UC1", 1280, 720, Bytes(2 * 1280 * 720, 4));
  const auto first = open(log);
  ASSERT_OK(first);
  RecordingOptions options;
  options.camera = (*first)->info().camera;
  options.camera->fx += 7;
  const auto again = open(log, options);
  ASSERT_OK(again);
  EXPECT_EQ((*again)->info().camera, *options.camera);
}

TEST_F(RobotTest, WhatLacksColourOrDepthOrACameraIsRefused) {
  RobotLog no_depth;
  no_depth.info("/camera/camera_info", "color").color("/camera/rgb", kStart, "color");
  EXPECT_ERROR(open(no_depth), "colour /camera/rgb; depth none");
  RobotLog no_info;
  no_info.color("/camera/rgb", kStart, "color").depth("/camera/depth", kStart, "color");
  EXPECT_ERROR(open(no_info), "no camera info of 40x30 pixels belongs to it");
  RobotLog apart;
  apart.info("/camera/camera_info", "color").color("/camera/rgb", kStart, "color");
  apart.depth("/camera/depth", kStart + 10 * kTenth, "color");
  EXPECT_ERROR(open(apart), "within 0.02 s");
  EXPECT_ERROR(open(RobotLog()), "colour none; depth none");
  const Bytes whole = BagWriter::write(simple_robot().plan());
  EXPECT_ERROR(open_bytes(std::span(whole).first(200)), "the file ends within a record");
}

TEST_F(RobotTest, ACameraInfoOfAnotherCameraIsNotTaken) {
  RobotLog log;
  log.info("/camera/depth/camera_info", "depth", 77);
  log.color("/camera/color/image_raw", kStart, "color")
      .depth("/camera/depth/image_raw", kStart, "depth");
  EXPECT_ERROR(open(log), "/camera/color/image_raw: no camera info of 40x30 pixels belongs to it");
}

TEST_F(RobotTest, CameraInfosOfOneNamespaceAreToldApartByTheirNames) {
  RobotLog log;
  log.info("/c/depth_info", "c", 77).info("/c/rgb_info", "c", 50);
  log.color("/c/rgb", kStart, "c").depth("/c/depth", kStart, "c");
  const auto opened = open(log);
  ASSERT_OK(opened);
  EXPECT_EQ((*opened)->info().camera.fx, 50);
  EXPECT_THAT((*opened)->notes(), Contains(HasSubstr("registered to colour here")));
}

TEST_F(RobotTest, ADamagedImageIsNamed) {
  RobotLog log = simple_robot();
  ImageMessage broken;
  broken.header = {kStart + 5 * kTenth, "color"};
  broken.width = kWidth;
  broken.height = kHeight;
  broken.pixels = "rgb8";
  broken.step = 3 * kWidth;
  broken.data = Bytes(100);
  log.add("/camera/color/image_raw", "sensor_msgs/Image", kStart + 5 * kTenth,
          write_image(Encoding::kRos1, broken));
  log.depth("/camera/aligned/image_raw", kStart + 5 * kTenth, "color");
  const auto opened = open(log);
  ASSERT_OK(opened);
  EXPECT_ERROR((*opened)->frame(4),
               "/camera/color/image_raw at 1700000000.500000 s: its picture of 40x30");
}

TEST_F(RobotTest, OneOddImageAtTheBeginningCostsItselfAlone) {
  RobotLog log;
  log.info("/camera/color/camera_info", "color");
  for (int i = 0; i < 3; ++i) {
    const TimestampNs time = kStart + i * kTenth;
    if (i == 0) {
      log.image("/camera/color/image_raw", time, "color", "rgb8", 8, 8, Bytes(3 * 8 * 8, 50));
    } else {
      log.color("/camera/color/image_raw", time, "color");
    }
    log.depth("/camera/aligned/image_raw", time, "color");
  }
  const auto opened = open(log);
  ASSERT_OK(opened);
  EXPECT_ERROR((*opened)->frame(0), "has 8x8 pixels, the others 40x30");
  EXPECT_OK((*opened)->frame(1));
  EXPECT_OK((*opened)->frame(2));
}

TEST_F(RobotTest, AFileThatWasCutOffGivesAnErrorOrTheFramesBefore) {
  RobotLog log;
  log.info("/c/camera_info", "color");
  for (int i = 0; i < 2; ++i) {
    log.image("/c/rgb", kStart + i * kTenth, "color", "mono8", kWidth, kHeight,
              Bytes(kWidth * kHeight, 9));
    log.depth("/c/depth", kStart + i * kTenth, "color");
  }
  for (const bool is_bag : {true, false}) {
    const Bytes whole =
        is_bag ? BagWriter::write(log.plan("")) : McapWriter::write(log.plan("lz4"));
    std::size_t most = 0;
    for (std::size_t size = 0; size < whole.size(); size += is_bag ? 7 : 1) {
      const auto opened = open_bytes(std::span(whole).first(size), is_bag);
      if (!opened) continue;
      for (const std::uint64_t frame : (*opened)->frames()) EXPECT_OK((*opened)->frame(frame));
      most = std::max(most, (*opened)->frames().size());
    }
    EXPECT_EQ(most, 2U);
  }
}

}  // namespace
}  // namespace roomwise::recording
