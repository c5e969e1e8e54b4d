#include "roomwise/recording/messages/messages.h"

#include "roomwise/recording/messages/foxglove_messages.h"
#include "roomwise/recording/messages/ros_reader.h"

namespace roomwise::recording {
namespace {

using Message = std::span<const std::uint8_t>;

bool is_ros(const Channel& channel) {
  return channel.encoding == Encoding::kRos1 || channel.encoding == Encoding::kCdr;
}

Unexpected cut_off() {
  return fail("the message is damaged or cut off");
}

geometry::RigidTransform read_transform(RosReader& reader) {
  geometry::RigidTransform transform;
  for (int i = 0; i < 3; ++i) transform.translation[i] = reader.number<double>();
  for (int i = 0; i < 4; ++i) transform.rotation.coeffs()[i] = reader.number<double>();
  return transform;
}

// Makes the rotation one. False where it is none.
bool normalise(geometry::RigidTransform& transform) {
  const double norm = transform.rotation.norm();
  if (!transform.is_finite() || !(norm > 0.5 && norm < 2)) return false;
  transform.rotation.normalize();
  return true;
}

Unexpected no_transform(const TransformMessage& transform) {
  return fail("the transform from '{}' to '{}' is no rotation and translation", transform.child,
              transform.header.frame);
}

Expected<TransformMessage> checked(Expected<TransformMessage> transform) {
  if (transform && !normalise(transform->parent_from_child)) return no_transform(*transform);
  return transform;
}

Expected<ImageMessage> ros_image(const Channel& channel, Message message) {
  RosReader reader(message, channel.encoding);
  ImageMessage image;
  image.header = reader.header();
  image.height = reader.number<std::uint32_t>();
  image.width = reader.number<std::uint32_t>();
  image.pixels = reader.text();
  image.is_big_endian = reader.number<std::uint8_t>() != 0;
  image.step = reader.number<std::uint32_t>();
  const auto data = reader.counted_bytes();
  if (!reader.ok()) return cut_off();
  image.data.assign(data.begin(), data.end());
  // librealsense appends the unit since 2.50; the field is in no definition of the message.
  if (channel.encoding == Encoding::kRos1 && reader.remaining() == sizeof(float)) {
    image.depth_unit_m = reader.number<float>();
  }
  return image;
}

Expected<std::vector<TransformMessage>> ros_transforms(const Channel& channel, Message message) {
  RosReader reader(message, channel.encoding);
  const auto count = reader.number<std::uint32_t>();
  std::vector<TransformMessage> transforms;
  for (std::uint32_t i = 0; i < count && reader.ok(); ++i) {
    TransformMessage& transform = transforms.emplace_back();
    transform.header = reader.header();
    transform.child = reader.text();
    if (transform.child.starts_with('/')) transform.child.erase(0, 1);
    transform.parent_from_child = read_transform(reader);
  }
  if (!reader.ok()) return cut_off();
  return transforms;
}

bool has_header(MessageType type) {
  return type == MessageType::kImage || type == MessageType::kCompressedImage ||
         type == MessageType::kCameraInfo || type == MessageType::kOdometry ||
         type == MessageType::kInertial;
}

}  // namespace

Expected<ImageMessage> decode_image(const Channel& channel, Message message) {
  return is_ros(channel) ? ros_image(channel, message) : foxglove::image(channel.encoding, message);
}

Expected<CompressedImageMessage> decode_compressed_image(const Channel& channel, Message message) {
  if (!is_ros(channel)) return foxglove::compressed_image(channel.encoding, message);
  RosReader reader(message, channel.encoding);
  CompressedImageMessage image;
  image.header = reader.header();
  image.format = reader.text();
  const auto data = reader.counted_bytes();
  if (!reader.ok()) return cut_off();
  image.data.assign(data.begin(), data.end());
  return image;
}

Expected<CameraInfoMessage> decode_camera_info(const Channel& channel, Message message) {
  if (!is_ros(channel)) return foxglove::camera_info(channel.encoding, message);
  RosReader reader(message, channel.encoding);
  CameraInfoMessage camera;
  camera.header = reader.header();
  camera.height = reader.number<std::uint32_t>();
  camera.width = reader.number<std::uint32_t>();
  camera.distortion_model = reader.text();
  const auto count = reader.number<std::uint32_t>();
  for (std::uint32_t i = 0; i < count && reader.ok(); ++i) {
    camera.distortion.push_back(reader.number<double>());
  }
  for (double& number : camera.k) number = reader.number<double>();
  for (int i = 0; i < 9; ++i) reader.number<double>();  // the rotation that rectifies
  for (double& number : camera.p) number = reader.number<double>();
  if (!reader.ok()) return cut_off();
  return camera;
}

Expected<std::vector<TransformMessage>> decode_transforms(const Channel& channel, Message message) {
  std::vector<TransformMessage> transforms;
  if (is_ros(channel)) {
    ROOMWISE_TRY(transforms, ros_transforms(channel, message));
  } else if (channel.type == MessageType::kTransforms) {
    ROOMWISE_TRY(transforms, foxglove::transforms(channel.encoding, message));
  } else {
    ROOMWISE_TRY(TransformMessage one, foxglove::transform(channel.encoding, message));
    transforms.push_back(std::move(one));
  }
  for (TransformMessage& transform : transforms) {
    if (!normalise(transform.parent_from_child)) return no_transform(transform);
  }
  return transforms;
}

Expected<TransformMessage> decode_odometry(const Channel& channel, Message message) {
  RosReader reader(message, channel.encoding);
  TransformMessage pose;
  pose.header = reader.header();
  pose.child = reader.text();
  if (pose.child.starts_with('/')) pose.child.erase(0, 1);
  pose.parent_from_child = read_transform(reader);
  if (!is_ros(channel) || !reader.ok()) return cut_off();
  return checked(std::move(pose));
}

Expected<InertialMessage> decode_inertial(const Channel& channel, Message message) {
  RosReader reader(message, channel.encoding);
  InertialMessage inertial;
  inertial.header = reader.header();
  inertial.sample.timestamp_ns = inertial.header.timestamp_ns;
  const auto skip = [&](int numbers) {
    for (int i = 0; i < numbers; ++i) reader.number<double>();
  };
  constexpr int kCovariance = 9;
  skip(4 + kCovariance);  // the orientation, which a filter made
  for (double& number : inertial.sample.turning_rad_s) number = reader.number<double>();
  skip(kCovariance);
  for (double& number : inertial.sample.force_m_s2) number = reader.number<double>();
  skip(kCovariance);
  if (!is_ros(channel) || !reader.ok()) return cut_off();
  return inertial;
}

Expected<geometry::RigidTransform> decode_bare_transform(const Channel& channel, Message message) {
  RosReader reader(message, channel.encoding);
  geometry::RigidTransform transform = read_transform(reader);
  if (!is_ros(channel) || !reader.ok()) return cut_off();
  if (!normalise(transform)) return fail("it is no rotation and translation");
  return transform;
}

Expected<double> decode_float(const Channel& channel, Message message) {
  RosReader reader(message, channel.encoding);
  const double number = reader.number<float>();
  if (!is_ros(channel) || !reader.ok()) return cut_off();
  return number;
}

std::optional<TimestampNs> header_time(const Channel& channel, Message message) {
  if (!has_header(channel.type)) return std::nullopt;
  if (!is_ros(channel)) return foxglove::time(channel.encoding, message);
  RosReader reader(message, channel.encoding);
  if (channel.encoding == Encoding::kRos1) reader.number<std::uint32_t>();
  const TimestampNs time = reader.time();
  return reader.ok() ? std::optional(time) : std::nullopt;
}

}  // namespace roomwise::recording
