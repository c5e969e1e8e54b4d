// Any bytes as a message of a robot: the first byte says of which type, the second in which
// encoding.

#include <array>

#include "fuzz_target.h"
#include "roomwise/recording/robot/camera_model.h"
#include "roomwise/recording/robot/pixels.h"

namespace {

using namespace roomwise::recording;

void read_message(const Channel& channel, std::span<const std::uint8_t> bytes) {
  std::ignore = header_time(channel, bytes);
  if (const auto image = decode_image(channel, bytes)) {
    std::ignore = color_of(*image);
    std::ignore = depth_of(*image);
  }
  if (const auto image = decode_compressed_image(channel, bytes)) {
    if (pixel_kind(*image) == PixelKind::kDepth) std::ignore = depth_of(*image);
  }
  if (const auto info = decode_camera_info(channel, bytes)) std::ignore = camera_of(*info, false);
  if (const auto transforms = decode_transforms(channel, bytes)) {
    for (const auto& one : *transforms) {
      if (!one.parent_from_child.is_finite()) __builtin_trap();
    }
  }
  std::ignore = decode_odometry(channel, bytes);
  std::ignore = decode_inertial(channel, bytes);
  std::ignore = decode_bare_transform(channel, bytes);
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::array kTypes{MessageType::kImage,      MessageType::kCompressedImage,
                              MessageType::kCameraInfo, MessageType::kTransforms,
                              MessageType::kTransform,  MessageType::kOdometry};
  constexpr std::array kEncodings{Encoding::kRos1, Encoding::kCdr, Encoding::kProtobuf,
                                  Encoding::kJson};
  if (size < 2) return 0;
  const Channel channel{"/topic", "", kTypes[data[0] % kTypes.size()],
                        kEncodings[data[1] % kEncodings.size()]};
  read_message(channel, {data + 2, size - 2});
  return 0;
}
