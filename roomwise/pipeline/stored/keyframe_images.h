#pragma once

#include <map>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "roomwise/home/home.h"
#include "roomwise/image/image.h"
#include "roomwise/pipeline/in_blocks.h"

namespace roomwise::pipeline {

struct DecodedImages {
  image::ColorImage color;
  image::DepthImage depth;
};
// Fails where an image is damaged or not of the camera's size.
[[nodiscard]] Expected<DecodedImages> decode(const home::KeyframeImages& images,
                                             const geometry::PinholeCamera& camera);
// The camera of every recording.
[[nodiscard]] Expected<std::map<home::RecordingId, geometry::PinholeCamera>> recording_cameras(
    const home::Home& home);

// The key-frames of the largest component of the map, by id.
[[nodiscard]] Expected<std::vector<home::Keyframe>> map_keyframes(const home::Home& home);

// Shows the images of key-frames: make(keyframe, images) runs on the pool's threads, then
// take(keyframe, what was made), which may fail, in the order of the key-frames. Fails where images
// cannot be decoded, naming the key-frame, or when the user interrupts.
template <typename Make, typename Take>
[[nodiscard]] Expected<void> for_each_keyframe(const home::Home& home,
                                               std::span<const home::Keyframe> keyframes,
                                               std::string_view work, RunContext& run,
                                               const Make& make, const Take& take) {
  using Made = std::invoke_result_t<Make, const home::Keyframe&, const DecodedImages&>;
  ROOMWISE_TRY(const auto cameras, recording_cameras(home));
  return in_blocks(
      keyframes.size(), work, run, [&](std::size_t i) { return home.images(keyframes[i].id); },
      [&](std::size_t i, const home::KeyframeImages& images) -> Expected<Made> {
        auto made =
            decode(images, cameras.at(keyframes[i].recording))
                .map([&](const DecodedImages& decoded) { return make(keyframes[i], decoded); });
        if (made) return made;
        return Unexpected(std::move(made).error().in(
            fmt::format("{}: key-frame {}", home.file(), keyframes[i].id)));
      },
      [&](std::size_t i, Made made) { return take(keyframes[i], std::move(made)); });
}

}  // namespace roomwise::pipeline
