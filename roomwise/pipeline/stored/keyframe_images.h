#pragma once

#include <map>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "roomwise/home/home.h"
#include "roomwise/image/image.h"
#include "roomwise/pipeline/in_blocks.h"
#include "roomwise/pipeline/stored/lost_pictures.h"

namespace roomwise::pipeline {

struct DecodedImages {
  image::ColorImage color;
  image::DepthImage depth;
};
// Fails where an image is damaged or not of the camera's size.
[[nodiscard]] Expected<DecodedImages> decode(const home::KeyframeImages& images,
                                             const geometry::PinholeCamera& camera);
// The same of a depth image alone.
[[nodiscard]] Expected<image::DepthImage> decode_depth(const Bytes& depth,
                                                       const geometry::PinholeCamera& camera);
// The camera of every recording.
[[nodiscard]] Expected<std::map<home::RecordingId, geometry::PinholeCamera>> recording_cameras(
    const home::Home& home);

// The key-frames of the largest component of the map, by id.
[[nodiscard]] Expected<std::vector<home::Keyframe>> map_keyframes(const home::Home& home);

// Where the camera was at a frame of a walk, in the map's world.
struct WalkedFrame {
  home::RecordingId recording = 0;
  std::uint64_t index = 0;
  TimestampNs timestamp_ns = 0;
  Eigen::Vector3d at_world = Eigen::Vector3d::Zero();
};
// The frames that the largest component of the map places: of all walks, one after the other, or of
// one, each in the order of time. They stay where key-frames were culled.
[[nodiscard]] Expected<std::vector<WalkedFrame>> walked_frames(
    const home::Home& home, std::optional<home::RecordingId> walk = std::nullopt);

// A picture that shows nothing: what a key-frame counts as whose own cannot be read.
[[nodiscard]] DecodedImages blank(const geometry::PinholeCamera& camera);

struct NothingInItsPlace {
  Expected<void> operator()(const home::Keyframe&) const { return {}; }
};
// Shows the images of key-frames: make(keyframe, images) runs on the pool's threads, then
// take(keyframe, what was made), which may fail, in the order of the key-frames. Fails where images
// cannot be read, naming the key-frame, or when the user interrupts. Where RunContext::lost says to
// go on without such images, lost(keyframe) is called in the place of take().
template <typename Make, typename Take, typename Lost = NothingInItsPlace>
[[nodiscard]] Expected<void> for_each_keyframe(const home::Home& home,
                                               std::span<const home::Keyframe> keyframes,
                                               std::string_view work, RunContext& run,
                                               const Make& make, const Take& take,
                                               const Lost& lost = {}) {
  using Made = std::invoke_result_t<Make, const home::Keyframe&, const DecodedImages&>;
  using Images = std::optional<home::KeyframeImages>;
  ROOMWISE_TRY(const auto cameras, recording_cameras(home));
  const auto without = [&](std::size_t i, Error why) {
    return go_on_without(home, keyframes[i].id, std::move(why), run.lost);
  };
  return in_blocks(
      keyframes.size(), work, run,
      [&](std::size_t i) -> Expected<Images> {
        auto images = home.images(keyframes[i].id);
        if (images) return *std::move(images);
        ROOMWISE_RETURN_IF_ERROR(without(i, std::move(images).error()));
        return std::nullopt;
      },
      [&](std::size_t i, const Images& images) -> Expected<std::optional<Made>> {
        if (!images) return std::nullopt;
        const auto decoded = decode(*images, cameras.at(keyframes[i].recording));
        if (decoded) return std::optional<Made>(make(keyframes[i], *decoded));
        ROOMWISE_RETURN_IF_ERROR(without(i, decoded.error()));
        return std::nullopt;
      },
      [&](std::size_t i, std::optional<Made> made) -> Expected<void> {
        return made ? take(keyframes[i], *std::move(made)) : lost(keyframes[i]);
      });
}

// The same of depth images between pictures. One that cannot be read is named by its key-frame, and
// may be gone on without likewise.
template <typename Make, typename Take>
[[nodiscard]] Expected<void> for_each_depth_view(const home::Home& home,
                                                 std::span<const home::DepthView> views,
                                                 std::string_view work, RunContext& run,
                                                 const Make& make, const Take& take) {
  if (views.empty()) return {};
  using Made = std::invoke_result_t<Make, const home::DepthView&, const image::DepthImage&>;
  ROOMWISE_TRY(const auto cameras, recording_cameras(home));
  const auto without = [&](std::size_t i, Error why) {
    return go_on_without(home, views[i].keyframe, std::move(why), run.lost);
  };
  return in_blocks(
      views.size(), work, run,
      [&](std::size_t i) -> Expected<std::optional<Bytes>> {
        auto image = home.depth_view_image(views[i].id);
        if (image) return *std::move(image);
        ROOMWISE_RETURN_IF_ERROR(without(i, std::move(image).error()));
        return std::nullopt;
      },
      [&](std::size_t i, const std::optional<Bytes>& image) -> Expected<std::optional<Made>> {
        if (!image) return std::nullopt;
        auto depth = decode_depth(*image, cameras.at(views[i].recording));
        if (depth) return std::optional<Made>(make(views[i], *depth));
        ROOMWISE_RETURN_IF_ERROR(without(i, std::move(depth).error()));
        return std::nullopt;
      },
      [&](std::size_t i, std::optional<Made> made) -> Expected<void> {
        return made ? take(views[i], *std::move(made)) : Expected<void>();
      });
}

}  // namespace roomwise::pipeline
