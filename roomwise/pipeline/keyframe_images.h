#pragma once

#include <algorithm>
#include <map>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "roomwise/home/home.h"
#include "roomwise/image/image.h"
#include "roomwise/pipeline/run_context.h"

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

// The key-frames of the largest piece of the map, by id.
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
  run.progress.begin(work, keyframes.size());
  const std::size_t block = 2 * run.pool.size();
  for (std::size_t first = 0; first < keyframes.size(); first += block) {
    if (run.progress.interrupted()) return fail("interrupted while {}", work);
    const auto now = keyframes.subspan(first, std::min(block, keyframes.size() - first));
    std::vector<home::KeyframeImages> images;
    for (const home::Keyframe& keyframe : now) {
      ROOMWISE_TRY(home::KeyframeImages one, home.images(keyframe.id));
      images.push_back(std::move(one));
    }
    std::vector<Expected<Made>> made(now.size(), fail("not made yet"));
    run.pool.parallel_for(now.size(), [&](std::size_t i) {
      made[i] =
          decode(images[i], cameras.at(now[i].recording)).map([&](const DecodedImages& decoded) {
            return make(now[i], decoded);
          });
    });
    for (std::size_t i = 0; i < now.size(); ++i) {
      if (!made[i]) {
        return Unexpected(
            std::move(made[i]).error().in(fmt::format("{}: key-frame {}", home.file(), now[i].id)));
      }
      ROOMWISE_CHECK_OK(take(now[i], *std::move(made[i])));
    }
    run.progress.advance(first + now.size(), "");
  }
  run.progress.end();
  return {};
}

}  // namespace roomwise::pipeline
