#include "roomwise/pipeline/stored/compared_views.h"

#include <utility>

#include "roomwise/image/codec.h"
#include "roomwise/pipeline/stored/keyframe_images.h"

namespace roomwise::pipeline {

Expected<ComparedViews> ComparedViews::of(const home::Home& home) {
  ComparedViews views(home);
  ROOMWISE_TRY(const auto cameras, recording_cameras(home));
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  for (const home::Keyframe& keyframe : keyframes)
    views.cameras_.emplace(keyframe.id, cameras.at(keyframe.recording));
  return views;
}

motion::ViewAgreement ComparedViews::compare(
    home::KeyframeId reference, home::KeyframeId current,
    const geometry::RigidTransform& reference_from_current) {
  return motion::compare_views(view(reference), view(current), reference_from_current);
}

const motion::RgbdPyramid& ComparedViews::view(home::KeyframeId id) {
  const auto [held, is_new] = views_.try_emplace(id);
  if (is_new) {
    if (auto read_now = read(id)) {
      held->second = *std::move(read_now);
    } else {
      unread_.emplace(
          id, fmt::format("{}: key-frame {}: {}", home_->file(), id, read_now.error().message));
    }
  }
  return held->second;
}

Expected<motion::RgbdPyramid> ComparedViews::read(home::KeyframeId id) const {
  const geometry::PinholeCamera& camera = cameras_.at(id);
  ROOMWISE_TRY(const home::KeyframeImages images, home_->images(id));
  ROOMWISE_TRY(const image::DepthImage depth, image::decode_depth(images.depth));
  if (depth.width() != camera.width || depth.height() != camera.height) {
    return fail("the depth image is {}x{}, its camera takes {}x{}", depth.width(), depth.height(),
                camera.width, camera.height);
  }
  // Brightness is not compared.
  motion::RgbdPyramid small =
      motion::make_rgbd_pyramid(image::GrayImage(camera.width, camera.height), depth, camera);
  motion::PyramidLevel level = motion::compared_level(small);
  return motion::RgbdPyramid{{std::move(level)}};
}

}  // namespace roomwise::pipeline
