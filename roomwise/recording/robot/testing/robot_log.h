#pragma once

#include <algorithm>
#include <string>

#include "roomwise/recording/messages/testing/log_writers.h"
#include "roomwise/recording/messages/testing/message_writer.h"

// Small recordings of robots, for tests and as seeds of fuzzing.
namespace roomwise::recording::testing {

constexpr TimestampNs kStart = 1'700'000'000'000'000'000;
constexpr TimestampNs kTenth = 100'000'000;
constexpr std::uint32_t kWidth = 40, kHeight = 30;

// A robot's recording as it grows: pictures of 40x30 pixels.
class RobotLog {
 public:
  explicit RobotLog(Encoding encoding = Encoding::kRos1) : encoding_(encoding) {}

  RobotLog& image(const std::string& topic, TimestampNs time, const std::string& frame,
                  const std::string& pixels, std::uint32_t width, std::uint32_t height,
                  const Bytes& data) {
    ImageMessage image;
    image.header = {time, frame};
    image.width = width;
    image.height = height;
    image.pixels = pixels;
    image.step = static_cast<std::uint32_t>(data.size() / height);
    image.data = data;
    return add(topic, "sensor_msgs/Image", time, write_image(encoding_, image));
  }
  RobotLog& color(const std::string& topic, TimestampNs time, const std::string& frame) {
    Bytes pixels(3 * kWidth * kHeight, 50);
    pixels[0] = static_cast<std::uint8_t>(time / kTenth % 10);
    return image(topic, time, frame, "rgb8", kWidth, kHeight, pixels);
  }
  RobotLog& depth(const std::string& topic, TimestampNs time, const std::string& frame,
                  std::uint16_t value = 2000) {
    ByteWriter data;
    for (std::uint32_t i = 0; i < kWidth * kHeight; ++i) data.number<std::uint16_t>(value);
    return image(topic, time, frame, "16UC1", kWidth, kHeight, data.all());
  }
  RobotLog& info(const std::string& topic, const std::string& frame, double f = 50,
                 std::uint32_t width = kWidth, std::uint32_t height = kHeight) {
    CameraInfoMessage info;
    info.header = {kStart, frame};
    info.width = width;
    info.height = height;
    info.k = {f, 0, (width - 1) / 2.0, 0, f, (height - 1) / 2.0, 0, 0, 1};
    return add(topic, "sensor_msgs/CameraInfo", kStart, write_camera_info(encoding_, info));
  }
  RobotLog& transform(const std::string& topic, TimestampNs time, const std::string& parent,
                      const std::string& child, double x) {
    const TransformMessage one{{time, parent}, child, {Eigen::Quaterniond::Identity(), {x, 0, 0}}};
    return add(topic, "tf2_msgs/TFMessage", time, write_transforms(encoding_, {one}));
  }
  RobotLog& odometry(TimestampNs time, const std::string& child, double x) {
    const TransformMessage one{{time, "odom"}, child, {Eigen::Quaterniond::Identity(), {x, 0, 0}}};
    return add("/odom", "nav_msgs/Odometry", time, write_odometry(encoding_, one));
  }
  RobotLog& add(const std::string& topic, const std::string& type, TimestampNs time, Bytes data) {
    auto channel = std::ranges::find(plan_.channels, topic, &Channel::topic);
    if (channel == plan_.channels.end()) {
      plan_.channels.push_back({topic, type, message_type_named(type), encoding_});
      channel = std::prev(plan_.channels.end());
    }
    messages_.push_back(
        {static_cast<std::size_t>(channel - plan_.channels.begin()), time, std::move(data)});
    return *this;
  }
  // Two chunks.
  [[nodiscard]] LogPlan plan(const std::string& packing = "lz4") const {
    LogPlan plan = plan_;
    plan.packing = packing;
    const auto half = messages_.begin() + static_cast<std::ptrdiff_t>(messages_.size() / 2);
    plan.chunks = {{messages_.begin(), half}, {half, messages_.end()}};
    return plan;
  }

 private:
  Encoding encoding_;
  LogPlan plan_;
  std::vector<WrittenMessage> messages_;
};

// Colour, depth that is registered to it a little later, and how the robot drives.
inline RobotLog simple_robot(Encoding encoding = Encoding::kRos1) {
  RobotLog log(encoding);
  log.info("/camera/color/camera_info", "color").info("/camera/aligned/camera_info", "color");
  log.transform("/tf_static", kStart, "base", "color", 0.5);
  for (int i = 0; i < 4; ++i) {
    const TimestampNs time = kStart + i * kTenth;
    log.transform("/tf", time, "odom", "base", i);
    log.color("/camera/color/image_raw", time, "color");
    if (i != 2) log.depth("/camera/aligned/image_raw", time + kTenth / 20, "color");
  }
  return log;
}

// One picture and one depth image of eight by six pixels.
inline RobotLog small_robot(Encoding encoding) {
  RobotLog log(encoding);
  log.info("/c/camera_info", "color", 10, 8, 6).info("/d/camera_info", "depth", 10, 8, 6);
  log.transform("/tf_static", kStart, "base", "color", 0.5);
  log.transform("/tf_static", kStart, "base", "depth", 0.4);
  log.image("/c/image", kStart, "color", "rgb8", 8, 6, Bytes(8 * 6 * 3, 50));
  log.image("/d/image", kStart, "depth", "16UC1", 8, 6, Bytes(8 * 6 * 2, 7));
  return log.odometry(kStart, "base", 1);
}

}  // namespace roomwise::recording::testing
