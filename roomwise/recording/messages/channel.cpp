#include "roomwise/recording/messages/channel.h"

#include <algorithm>
#include <array>

namespace roomwise::recording {
namespace {

struct KnownType {
  std::string_view name;
  MessageType type;
};

constexpr std::array kKnownTypes{
    KnownType{"sensor_msgs/Image", MessageType::kImage},
    KnownType{"sensor_msgs/CompressedImage", MessageType::kCompressedImage},
    KnownType{"sensor_msgs/CameraInfo", MessageType::kCameraInfo},
    KnownType{"tf2_msgs/TFMessage", MessageType::kTransforms},
    KnownType{"tf/tfMessage", MessageType::kTransforms},
    KnownType{"nav_msgs/Odometry", MessageType::kOdometry},
    KnownType{"sensor_msgs/Imu", MessageType::kInertial},
    KnownType{"geometry_msgs/Transform", MessageType::kBareTransform},
    KnownType{"std_msgs/Float32", MessageType::kFloat},
    KnownType{"foxglove.RawImage", MessageType::kImage},
    KnownType{"foxglove.CompressedImage", MessageType::kCompressedImage},
    KnownType{"foxglove.CameraCalibration", MessageType::kCameraInfo},
    KnownType{"foxglove.FrameTransforms", MessageType::kTransforms},
    KnownType{"foxglove.FrameTransform", MessageType::kTransform}};

}  // namespace

MessageType message_type_named(std::string_view name) {
  std::string plain(name);
  if (const auto at = plain.find("/msg/"); at != std::string::npos) plain.erase(at, 4);
  const auto known = std::ranges::find(kKnownTypes, plain, &KnownType::name);
  return known == kKnownTypes.end() ? MessageType::kOther : known->type;
}

}  // namespace roomwise::recording
