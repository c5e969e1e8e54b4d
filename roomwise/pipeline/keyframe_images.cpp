#include "roomwise/pipeline/keyframe_images.h"

#include "roomwise/image/codec.h"

namespace roomwise::pipeline {

Expected<DecodedImages> decode(const home::KeyframeImages& images) {
  ROOMWISE_TRY(image::ColorImage color, image::decode_color(images.color));
  ROOMWISE_TRY(image::DepthImage depth, image::decode_depth(images.depth));
  return DecodedImages{std::move(color), std::move(depth)};
}

Expected<std::vector<home::Keyframe>> map_keyframes(const home::Home& home) {
  ROOMWISE_TRY(auto keyframes, home.keyframes());
  std::erase_if(keyframes, [](const home::Keyframe& keyframe) { return keyframe.pose.piece != 0; });
  return keyframes;
}

}  // namespace roomwise::pipeline
