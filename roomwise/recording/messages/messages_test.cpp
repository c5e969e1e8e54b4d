#include "roomwise/recording/messages/messages.h"

#include <gmock/gmock.h>

#include <numbers>

#include "roomwise/base/testing/testing.h"
#include "roomwise/recording/messages/testing/message_writer.h"

namespace roomwise::recording {
namespace {

using namespace recording::testing;
using ::testing::ElementsAre;
using ::testing::SizeIs;

constexpr TimestampNs kTime = 1'700'000'000'123'456'789;

Channel channel_of(const std::string& type, Encoding encoding) {
  return {"/topic", type, message_type_named(type), encoding};
}

geometry::RigidTransform some_transform() {
  const Eigen::AngleAxisd turn(0.3, Eigen::Vector3d::UnitZ());
  return {Eigen::Quaterniond(turn), {1, 2, 3}};
}

ImageMessage some_image() {
  ImageMessage image;
  image.header = {kTime, "camera_color_optical_frame"};
  image.width = 2;
  image.height = 1;
  image.pixels = "rgb8";
  image.step = 6;
  image.data = {1, 2, 3, 4, 5, 6};
  return image;
}

CameraInfoMessage some_camera() {
  CameraInfoMessage camera;
  camera.header = {kTime, "camera"};
  camera.width = 640;
  camera.height = 480;
  camera.distortion_model = "plumb_bob";
  camera.distortion = {0.1, -0.2, 0.001, 0.002, 0.05};
  camera.k = {525, 0, 319.5, 0, 524, 239.5, 0, 0, 1};
  camera.p = {500, 0, 320, 0, 0, 501, 240, 0, 0, 0, 1, 0};
  return camera;
}

class RosMessages : public ::testing::TestWithParam<Encoding> {};
INSTANTIATE_TEST_SUITE_P(Encodings, RosMessages, ::testing::Values(Encoding::kRos1, Encoding::kCdr),
                         [](const auto& tested) {
                           return tested.param == Encoding::kRos1 ? "Ros1" : "Cdr";
                         });

TEST_P(RosMessages, AnImageIsReadBack) {
  const Bytes bytes = write_image(GetParam(), some_image());
  const Channel channel = channel_of("sensor_msgs/msg/Image", GetParam());
  const auto image = decode_image(channel, bytes);
  ASSERT_OK(image);
  EXPECT_EQ(image->header.timestamp_ns, kTime);
  EXPECT_EQ(image->header.frame, "camera_color_optical_frame");
  EXPECT_EQ(image->width, 2U);
  EXPECT_EQ(image->height, 1U);
  EXPECT_EQ(image->pixels, "rgb8");
  EXPECT_EQ(image->step, 6U);
  EXPECT_EQ(image->data, some_image().data);
  EXPECT_FALSE(image->depth_unit_m.has_value());
  EXPECT_EQ(header_time(channel, std::span(bytes).first(20)), kTime);
}

TEST_P(RosMessages, ACompressedImageIsReadBack) {
  const CompressedImageMessage written{{kTime, "/camera"}, "jpeg", {9, 8, 7}};
  const auto image = decode_compressed_image(channel_of("sensor_msgs/CompressedImage", GetParam()),
                                             write_compressed_image(GetParam(), written));
  ASSERT_OK(image);
  EXPECT_EQ(image->header.frame, "camera") << "frames of old bags begin with a slash";
  EXPECT_EQ(image->format, "jpeg");
  EXPECT_EQ(image->data, written.data);
}

TEST_P(RosMessages, ACameraInfoIsReadBack) {
  const auto camera = decode_camera_info(channel_of("sensor_msgs/CameraInfo", GetParam()),
                                         write_camera_info(GetParam(), some_camera()));
  ASSERT_OK(camera);
  EXPECT_EQ(camera->width, 640U);
  EXPECT_EQ(camera->height, 480U);
  EXPECT_EQ(camera->distortion_model, "plumb_bob");
  EXPECT_EQ(camera->distortion, some_camera().distortion);
  EXPECT_EQ(camera->k, some_camera().k);
  EXPECT_EQ(camera->p, some_camera().p);
}

TEST_P(RosMessages, TransformsAreReadBack) {
  const std::vector<TransformMessage> written{{{kTime, "map"}, "odom", some_transform()},
                                              {{kTime, "odom"}, "base", {}}};
  const auto transforms = decode_transforms(channel_of("tf2_msgs/msg/TFMessage", GetParam()),
                                            write_transforms(GetParam(), written));
  ASSERT_OK(transforms);
  ASSERT_THAT(*transforms, SizeIs(2));
  EXPECT_EQ((*transforms)[0].child, "odom");
  EXPECT_EQ((*transforms)[0].header.frame, "map");
  EXPECT_TRUE(
      (*transforms)[0].parent_from_child.translation.isApprox(some_transform().translation));
  EXPECT_TRUE((*transforms)[0].parent_from_child.rotation.isApprox(some_transform().rotation));
}

TEST_P(RosMessages, OdometryIsReadBack) {
  const auto pose =
      decode_odometry(channel_of("nav_msgs/Odometry", GetParam()),
                      write_odometry(GetParam(), {{kTime, "odom"}, "base", some_transform()}));
  ASSERT_OK(pose);
  EXPECT_EQ(pose->child, "base");
  EXPECT_TRUE(pose->parent_from_child.translation.isApprox(some_transform().translation));
}

TEST_P(RosMessages, WhatAnInertialSensorFeltIsReadBack) {
  const Channel channel = channel_of("sensor_msgs/Imu", GetParam());
  const Bytes bytes =
      write_inertial(GetParam(), {{kTime, "imu"}, {kTime, {0.1, 0.2, 0.3}, {1, 2, 9.5}}});
  const auto read = decode_inertial(channel, bytes);
  ASSERT_OK(read);
  EXPECT_EQ(read->header.frame, "imu");
  EXPECT_EQ(read->sample.timestamp_ns, kTime);
  EXPECT_EQ(read->sample.turning_rad_s, Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(read->sample.force_m_s2, Eigen::Vector3d(1, 2, 9.5));
  EXPECT_EQ(header_time(channel, bytes), kTime);
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_ERROR(decode_inertial(channel, std::span(bytes).first(size)), "cut off");
}

TEST_P(RosMessages, WhatIsCutOffIsRefused) {
  const Bytes image = write_image(GetParam(), some_image());
  const Bytes camera = write_camera_info(GetParam(), some_camera());
  const Bytes transforms = write_transforms(GetParam(), {{{kTime, "a"}, "b", {}}});
  for (std::size_t size = 0; size < image.size(); ++size) {
    EXPECT_ERROR(
        decode_image(channel_of("sensor_msgs/Image", GetParam()), std::span(image).first(size)),
        "cut off");
  }
  for (std::size_t size = 0; size + 25 < camera.size(); ++size) {
    EXPECT_ERROR(decode_camera_info(channel_of("sensor_msgs/CameraInfo", GetParam()),
                                    std::span(camera).first(size)),
                 "cut off");
  }
  for (std::size_t size = 0; size < transforms.size(); ++size) {
    EXPECT_ERROR(decode_transforms(channel_of("tf2_msgs/TFMessage", GetParam()),
                                   std::span(transforms).first(size)),
                 "cut off");
  }
}

TEST_P(RosMessages, ATransformWithoutARotationIsRefused) {
  geometry::RigidTransform broken;
  broken.rotation.coeffs().setZero();
  EXPECT_ERROR(decode_transforms(channel_of("tf2_msgs/TFMessage", GetParam()),
                                 write_transforms(GetParam(), {{{kTime, "a"}, "b", broken}})),
               "from 'b' to 'a'");
  broken.rotation.setIdentity();
  broken.translation.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_ERROR(decode_odometry(channel_of("nav_msgs/Odometry", GetParam()),
                               write_odometry(GetParam(), {{kTime, "a"}, "b", broken})),
               "no rotation and translation");
}

TEST(Messages, BigEndianCdrIsReadToo) {
  ByteWriter bytes;
  bytes.number<std::uint32_t>(0);  // CDR_BE
  for (const int byte : {0, 0, 0, 2, 0, 0, 0, 5, 0, 0, 0, 2, 97, 0}) {
    bytes.number<std::uint8_t>(static_cast<std::uint8_t>(byte));
  }
  EXPECT_EQ(header_time(channel_of("sensor_msgs/Image", Encoding::kCdr), bytes.all()),
            2'000'000'005);
}

TEST(Messages, RealSenseSaysWhatOneMeansBehindItsImages) {
  ImageMessage written = some_image();
  written.depth_unit_m = 0.00025F;
  const auto image = decode_image(channel_of("sensor_msgs/Image", Encoding::kRos1),
                                  write_image(Encoding::kRos1, written));
  ASSERT_OK(image);
  EXPECT_FLOAT_EQ(static_cast<float>(image->depth_unit_m.value()), 0.00025F);
}

TEST(FoxgloveMessages, ProtobufIsRead) {
  const Bytes data{1, 2, 3};
  const auto raw = ProtoWriter()
                       .time(1, kTime)
                       .fixed32(2, 3)
                       .fixed32(3, 1)
                       .text(4, "mono8")
                       .fixed32(5, 3)
                       .blob(6, data)
                       .text(7, "camera");
  const Channel raw_channel = channel_of("foxglove.RawImage", Encoding::kProtobuf);
  const auto image = decode_image(raw_channel, raw.all());
  ASSERT_OK(image);
  EXPECT_EQ(image->header.timestamp_ns, kTime);
  EXPECT_EQ(image->header.frame, "camera");
  EXPECT_EQ(image->width, 3U);
  EXPECT_EQ(image->height, 1U);
  EXPECT_EQ(image->pixels, "mono8");
  EXPECT_EQ(image->data, data);
  EXPECT_EQ(header_time(raw_channel, raw.all()), kTime);

  const auto compressed = decode_compressed_image(
      channel_of("foxglove.CompressedImage", Encoding::kProtobuf),
      ProtoWriter().time(1, kTime).blob(2, data).text(3, "png").text(4, "camera").all());
  ASSERT_OK(compressed);
  EXPECT_EQ(compressed->format, "png");
  EXPECT_EQ(compressed->data, data);

  const auto camera =
      decode_camera_info(channel_of("foxglove.CameraCalibration", Encoding::kProtobuf),
                         ProtoWriter()
                             .fixed32(2, 640)
                             .fixed32(3, 480)
                             .text(4, "plumb_bob")
                             .numbers(5, some_camera().distortion)
                             .numbers(6, some_camera().k)
                             .numbers(8, some_camera().p)
                             .text(9, "camera")
                             .all());
  ASSERT_OK(camera);
  EXPECT_EQ(camera->k, some_camera().k);
  EXPECT_EQ(camera->p, some_camera().p);
  EXPECT_EQ(camera->distortion, some_camera().distortion);
}

TEST(FoxgloveMessages, ProtobufTransformsAreRead) {
  const auto moved = ProtoWriter().number(1, 1).number(3, 3);
  const auto turned =
      ProtoWriter().number(3, std::numbers::sqrt2 / 2).number(4, std::numbers::sqrt2 / 2);
  const auto one = ProtoWriter()
                       .time(1, kTime)
                       .text(2, "odom")
                       .text(3, "base")
                       .blob(4, moved.all())
                       .blob(5, turned.all());
  const auto transforms =
      decode_transforms(channel_of("foxglove.FrameTransforms", Encoding::kProtobuf),
                        ProtoWriter().blob(1, one.all()).blob(1, one.all()).all());
  ASSERT_OK(transforms);
  ASSERT_THAT(*transforms, SizeIs(2));
  EXPECT_EQ((*transforms)[1].child, "base");
  EXPECT_TRUE(((*transforms)[1].parent_from_child * Eigen::Vector3d(1, 0, 0))
                  .isApprox(Eigen::Vector3d(1, 1, 3)));
  EXPECT_OK(
      decode_transforms(channel_of("foxglove.FrameTransform", Encoding::kProtobuf), one.all()));
}

TEST(FoxgloveMessages, JsonIsRead) {
  const auto bytes = [](std::string_view text) { return Bytes(text.begin(), text.end()); };
  const auto image = decode_compressed_image(
      channel_of("foxglove.CompressedImage", Encoding::kJson),
      bytes(
          R"({"timestamp":{"sec":5,"nsec":7},"frame_id":"c","data":"AQIDBA==","format":"jpeg"})"));
  ASSERT_OK(image);
  EXPECT_EQ(image->header.timestamp_ns, 5'000'000'007);
  EXPECT_THAT(image->data, ElementsAre(1, 2, 3, 4));
  const auto camera = decode_camera_info(
      channel_of("foxglove.CameraCalibration", Encoding::kJson),
      bytes(
          R"({"width":4,"height":3,"distortion_model":"","D":[],"K":[1,0,2,0,1,1,0,0,1],"P":[]})"));
  ASSERT_OK(camera);
  EXPECT_EQ(camera->k[2], 2);
  const auto raw =
      decode_image(channel_of("foxglove.RawImage", Encoding::kJson),
                   bytes(R"({"width":1,"height":1,"encoding":"16UC1","step":2,"data":"AAE="})"));
  ASSERT_OK(raw);
  EXPECT_THAT(raw->data, ElementsAre(0, 1));
}

TEST(FoxgloveMessages, WhatMakesNoSenseIsRefused) {
  const auto bytes = [](std::string_view text) { return Bytes(text.begin(), text.end()); };
  const Channel json = channel_of("foxglove.CompressedImage", Encoding::kJson);
  EXPECT_ERROR(decode_compressed_image(json, bytes("[1]")), "damaged");
  EXPECT_ERROR(decode_compressed_image(json, bytes(R"({"data":"!"})")), "base64");
  EXPECT_ERROR(decode_compressed_image(json, bytes(R"({"data":5})")), "damaged");
  const Channel proto = channel_of("foxglove.CompressedImage", Encoding::kProtobuf);
  EXPECT_ERROR(decode_compressed_image(proto, Bytes{0x12, 0xFF}), "damaged");
  EXPECT_ERROR(decode_compressed_image(proto, Bytes{0x17}), "damaged");
  EXPECT_ERROR(decode_camera_info(channel_of("foxglove.CameraCalibration", Encoding::kProtobuf),
                                  ProtoWriter().number(6, 1).all()),
               "damaged");
}

}  // namespace
}  // namespace roomwise::recording
