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

Expected<motion::ViewAgreement> ComparedViews::compare(
    home::KeyframeId reference, home::KeyframeId current,
    const geometry::RigidTransform& reference_from_current) {
  ROOMWISE_TRY(const motion::RgbdPyramid* const one, view(reference));
  ROOMWISE_TRY(const motion::RgbdPyramid* const other, view(current));
  return motion::compare_views(*one, *other, reference_from_current);
}

Expected<const motion::RgbdPyramid*> ComparedViews::view(home::KeyframeId id) {
  if (const auto known = views_.find(id); known != views_.end()) return &known->second;
  const geometry::PinholeCamera& camera = cameras_.at(id);
  const auto depth = home_->images(id).and_then(
      [](const home::KeyframeImages& images) { return image::decode_depth(images.depth); });
  const auto named = [&](const Error& error) {
    return Unexpected(Error(error).in(fmt::format("{}: key-frame {}", home_->file(), id)));
  };
  if (!depth) return named(depth.error());
  if (depth->width() != camera.width || depth->height() != camera.height) {
    return fail("{}: key-frame {}: the depth image is {}x{}, its camera takes {}x{}", home_->file(),
                id, depth->width(), depth->height(), camera.width, camera.height);
  }
  // Brightness is not compared.
  motion::RgbdPyramid small =
      motion::make_rgbd_pyramid(image::GrayImage(camera.width, camera.height), *depth, camera);
  motion::PyramidLevel level = motion::compared_level(small);
  return &views_.emplace(id, motion::RgbdPyramid{{std::move(level)}}).first->second;
}

}  // namespace roomwise::pipeline
