#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "roomwise/base/file.h"
#include "roomwise/base/timestamp.h"
#include "roomwise/geometry/inertial_track.h"
#include "roomwise/geometry/rigid_transform.h"
#include "roomwise/recording/messages/channel.h"

// The messages that are understood, in any encoding. Each decoder fails where the bytes end within
// the message or hold what it cannot have; the caller names the topic. None takes more memory than
// the message has bytes, some factors aside.
namespace roomwise::recording {

struct MessageHeader {
  TimestampNs timestamp_ns = 0;
  std::string frame;  // of coordinates, without a leading '/'
};

struct ImageMessage {
  MessageHeader header;
  std::uint32_t width = 0, height = 0;
  std::string pixels;  // ROS's name of how a pixel is stored: "rgb8", "16UC1"
  bool is_big_endian = false;
  std::uint32_t step = 0;  // bytes from row to row
  Bytes data;
  // RealSense's own addition: what 1 means in a depth image, m.
  std::optional<double> depth_unit_m;
};

struct CompressedImageMessage {
  MessageHeader header;
  std::string format;  // "jpeg", "rgb8; jpeg compressed bgr8", "16UC1; compressedDepth png"
  Bytes data;
};

struct CameraInfoMessage {
  MessageHeader header;
  std::uint32_t width = 0, height = 0;
  std::string distortion_model;
  std::vector<double> distortion;
  std::array<double, 9> k{};   // of the image as it is, row after row
  std::array<double, 12> p{};  // of the rectified image, row after row
};

struct TransformMessage {
  MessageHeader header;  // the frame is the parent's
  std::string child;
  geometry::RigidTransform parent_from_child;
};

struct InertialMessage {
  MessageHeader header;
  geometry::InertialSample sample;  // in the header's frame
};

[[nodiscard]] Expected<ImageMessage> decode_image(const Channel& channel,
                                                  std::span<const std::uint8_t> message);
[[nodiscard]] Expected<CompressedImageMessage> decode_compressed_image(
    const Channel& channel, std::span<const std::uint8_t> message);
[[nodiscard]] Expected<CameraInfoMessage> decode_camera_info(const Channel& channel,
                                                             std::span<const std::uint8_t> message);
// Of kTransform and kTransforms.
[[nodiscard]] Expected<std::vector<TransformMessage>> decode_transforms(
    const Channel& channel, std::span<const std::uint8_t> message);
// The pose of the child's frame in the header's.
[[nodiscard]] Expected<TransformMessage> decode_odometry(const Channel& channel,
                                                         std::span<const std::uint8_t> message);
[[nodiscard]] Expected<InertialMessage> decode_inertial(const Channel& channel,
                                                        std::span<const std::uint8_t> message);
[[nodiscard]] Expected<geometry::RigidTransform> decode_bare_transform(
    const Channel& channel, std::span<const std::uint8_t> message);
[[nodiscard]] Expected<double> decode_float(const Channel& channel,
                                            std::span<const std::uint8_t> message);

// The time in the header of an image, a camera info, an odometry or an inertial message, from its
// first bytes; nothing where they are too few or the type has no header.
[[nodiscard]] std::optional<TimestampNs> header_time(const Channel& channel,
                                                     std::span<const std::uint8_t> message);
// As many first bytes nearly always do.
constexpr std::uint64_t kHeaderBytes = 64;

}  // namespace roomwise::recording
