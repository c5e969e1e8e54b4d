#include "roomwise/pipeline/mapping/home_localizer.h"

#include <utility>

#include "roomwise/pipeline/stored/keyframe_images.h"
#include "roomwise/pipeline/stored/measured_frame_reader.h"
#include "roomwise/pipeline/stored/stored_keyframes.h"

namespace roomwise::pipeline {

HomeLocalizer::HomeLocalizer(MapSettings settings, const mapping::LocalizerOptions& options)
    : settings_(std::move(settings)),
      extractor_(features::make_extractor(settings_.features, settings_.max_keypoints)),
      localizer_(options) {}

Expected<HomeLocalizer> HomeLocalizer::create(const home::Home& home,
                                              const mapping::LocalizerOptions& options,
                                              RunContext& run) {
  ROOMWISE_CHECK_OK(options.validate());
  ROOMWISE_TRY(auto settings, stored_map_settings(home));
  ROOMWISE_TRY(const auto placed, map_keyframes(home));
  if (!settings || placed.empty()) {
    return fail("{}: the home has no map yet; make one with roomwise map", home.file());
  }
  // Views tell whether a pose is right, however the map was made.
  settings->mapper.method = mapping::MappingMethod::kCombined;
  HomeLocalizer result(*std::move(settings), options);
  ROOMWISE_TRY(std::vector<mapping::Keyframe> keyframes,
               measure_keyframes(home, placed, *result.extractor_, result.settings_, run));
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    result.localizer_.add(std::move(keyframes[i]), placed[i].pose.world_from_keyframe);
  }
  return result;
}

Expected<motion::FrameMeasurements> HomeLocalizer::measure(const PictureToLocate& picture) const {
  const auto check_size = [&](const auto& image, std::string_view what) -> Expected<void> {
    if (image.width() == picture.camera.width && image.height() == picture.camera.height) return {};
    return fail("the {} is {}x{}, the camera takes {}x{}; give its camera", what, image.width(),
                image.height(), picture.camera.width, picture.camera.height);
  };
  ROOMWISE_CHECK_OK(check_size(picture.color, "picture"));
  if (picture.depth) ROOMWISE_CHECK_OK(check_size(*picture.depth, "depth image"));
  if (picture.depth) {
    return measure_frame(picture.color, *picture.depth, picture.camera, *extractor_, settings_);
  }
  const image::DepthImage none(picture.color.width(), picture.color.height());
  MapSettings without_views = settings_;
  without_views.mapper.method = mapping::MappingMethod::kPaper;
  return measure_frame(picture.color, none, picture.camera, *extractor_, without_views);
}

Expected<mapping::Localization> HomeLocalizer::locate_uncalibrated(
    const image::ColorImage& color, const motion::LensEstimate& lens) const {
  geometry::PinholeCamera camera = lens.camera(color.width(), color.height());
  camera.distortion = {};  // pixels are to stay where they are
  ROOMWISE_TRY(const motion::FrameMeasurements measured, measure({color, std::nullopt, camera}));
  return localizer_.locate({measured, camera, lens});
}

}  // namespace roomwise::pipeline
