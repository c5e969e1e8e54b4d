#pragma once

#include <string>

namespace roomwise::recording {

// How the messages of a channel are laid out.
enum class Encoding { kRos1, kCdr, kProtobuf, kJson };

// What is understood of a message. A type that robots name in several ways is one here.
enum class MessageType {
  kOther,
  kImage,            // sensor_msgs/Image, foxglove.RawImage
  kCompressedImage,  // sensor_msgs/CompressedImage, foxglove.CompressedImage
  kCameraInfo,       // sensor_msgs/CameraInfo, foxglove.CameraCalibration
  kTransforms,       // tf2_msgs/TFMessage, foxglove.FrameTransforms
  kTransform,        // foxglove.FrameTransform
  kOdometry,         // nav_msgs/Odometry
  kInertial,         // sensor_msgs/Imu
  kBareTransform,    // geometry_msgs/Transform (RealSense: extrinsics)
  kFloat             // std_msgs/Float32 (RealSense: options)
};

// A stream of messages of one type.
struct Channel {
  std::string topic;
  std::string type_name;
  MessageType type = MessageType::kOther;
  Encoding encoding = Encoding::kRos1;

  [[nodiscard]] bool is_read() const { return type != MessageType::kOther; }
};

// By the names of ROS 1, ROS 2 ("sensor_msgs/msg/Image") and Foxglove.
[[nodiscard]] MessageType message_type_named(std::string_view name);

}  // namespace roomwise::recording
