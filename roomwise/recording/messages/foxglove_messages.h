#pragma once

#include "roomwise/recording/messages/messages.h"

// The decoders of Foxglove's schemas, as protobuf or JSON; callers use messages.h. Source:
// https://docs.foxglove.dev/docs/visualization/message-schemas/introduction
namespace roomwise::recording::foxglove {

using MessageBytes = std::span<const std::uint8_t>;

[[nodiscard]] Expected<ImageMessage> image(Encoding encoding, MessageBytes message);
[[nodiscard]] Expected<CompressedImageMessage> compressed_image(Encoding encoding,
                                                                MessageBytes message);
[[nodiscard]] Expected<CameraInfoMessage> camera_info(Encoding encoding, MessageBytes message);
// One FrameTransform.
[[nodiscard]] Expected<TransformMessage> transform(Encoding encoding, MessageBytes message);
// FrameTransforms.
[[nodiscard]] Expected<std::vector<TransformMessage>> transforms(Encoding encoding,
                                                                 MessageBytes message);
[[nodiscard]] std::optional<TimestampNs> time(Encoding encoding, MessageBytes message);

}  // namespace roomwise::recording::foxglove
