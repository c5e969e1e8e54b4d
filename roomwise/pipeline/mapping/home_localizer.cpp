#include "roomwise/pipeline/mapping/home_localizer.h"

#include <algorithm>
#include <utility>

#include "roomwise/pipeline/stored/keyframe_images.h"
#include "roomwise/pipeline/stored/made_from.h"
#include "roomwise/pipeline/stored/measured_frame_reader.h"
#include "roomwise/pipeline/stored/stored_keyframes.h"

namespace roomwise::pipeline {

namespace {

const std::string kIndexName = "localizer";
// To be raised where features, views or the index come out otherwise than before.
constexpr std::uint64_t kIndexMethod = 1;

// The settings by which the localiser measures. Views tell whether a pose is right, however the map
// was made.
Expected<MapSettings> measuring_settings(const home::Home& home) {
  ROOMWISE_TRY(auto settings, stored_map_settings(home));
  if (!settings)
    return fail("{}: the home has no map yet; make one with roomwise map", home.file());
  settings->mapper.method = mapping::MappingMethod::kCombined;
  return *std::move(settings);
}

// All that the index follows from: which key-frames the map has and how they are measured. Where
// they are does not matter.
std::string index_made_from(std::span<const home::Keyframe> keyframes,
                            const MapSettings& settings) {
  MadeFrom made_from;
  made_from.add(kIndexMethod);
  made_from.add(to_json(settings));
  for (const home::Keyframe& keyframe : keyframes) {
    made_from.add(static_cast<std::uint64_t>(keyframe.recording));
    made_from.add(std::uint64_t{keyframe.frame_index});
    made_from.add(static_cast<std::uint64_t>(keyframe.timestamp_ns));
  }
  return made_from.digest();
}

// The index that the home keeps; nothing where there is none, or it is stale or damaged.
Expected<std::optional<mapping::LocalizerIndex>> kept_index(const home::Home& home,
                                                            const std::string& made_from,
                                                            std::size_t keyframes) {
  ROOMWISE_TRY(const auto kept, home.derived_data(kIndexName));
  if (!kept || kept->made_from != made_from) return std::nullopt;
  auto index = mapping::LocalizerIndex::from_bytes(kept->data);
  return index && index->size() == keyframes ? std::move(index) : std::nullopt;
}

}  // namespace

HomeLocalizer::HomeLocalizer(MapSettings settings, std::shared_ptr<KeyframesOnDemand> keyframes,
                             mapping::Localizer localizer)
    : settings_(std::move(settings)),
      extractor_(features::make_extractor(settings_.features, settings_.max_keypoints)),
      keyframes_(std::move(keyframes)),
      localizer_(std::move(localizer)) {}

Expected<HomeLocalizer> HomeLocalizer::create(const home::Home& home,
                                              const mapping::LocalizerOptions& options,
                                              RunContext& run) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  ROOMWISE_TRY(const MapSettings settings, measuring_settings(home));
  ROOMWISE_TRY(const auto placed, map_keyframes(home));
  if (placed.empty()) {
    return fail("{}: the home has no map yet; make one with roomwise map", home.file());
  }
  ROOMWISE_TRY(const auto keyframes,
               KeyframesOnDemand::create(home, placed, settings, run.working_set_bytes, run.lost));
  const std::string made_from = index_made_from(placed, settings);
  ROOMWISE_TRY(auto index, kept_index(home, made_from, placed.size()));
  std::optional<home::DerivedData> new_index;
  if (!index) {
    index.emplace();
    const auto extractor = features::make_extractor(settings.features, settings.max_keypoints);
    std::size_t next = 0;
    const auto take = [&](mapping::Keyframe keyframe) -> Expected<void> {
      index->add(keyframe.measurements);
      keyframes->put(next++, std::move(keyframe.measurements));
      return {};
    };
    ROOMWISE_RETURN_IF_ERROR(measure_each_keyframe(home, placed, *extractor, settings, run, take));
    new_index = {kIndexName, made_from, index->to_bytes()};
  }
  std::vector<mapping::PlacedKeyframe> poses;
  for (const home::Keyframe& keyframe : placed)
    poses.push_back({keyframe.id, keyframe.pose.world_from_keyframe});
  HomeLocalizer result(
      settings, keyframes,
      mapping::Localizer(options, *std::move(index), std::move(poses),
                         [keyframes](std::size_t place) { return keyframes->get(place); }));
  result.new_index_ = std::move(new_index);
  return result;
}

Expected<void> keep_localizer_index(
    home::Home& home,
    const std::function<Expected<mapping::SharedMeasurements>(home::KeyframeId)>& measured,
    std::optional<KeptLocalizerIndex> before) {
  ROOMWISE_TRY(const MapSettings settings, measuring_settings(home));
  ROOMWISE_TRY(const auto placed, map_keyframes(home));
  const std::string made_from = index_made_from(placed, settings);
  ROOMWISE_TRY(const auto kept, kept_index(home, made_from, placed.size()));
  if (kept) return {};
  const bool goes_on =
      before && before->keyframes.size() <= placed.size() &&
      std::ranges::equal(before->keyframes, std::span(placed).first(before->keyframes.size()), {},
                         {}, &home::Keyframe::id);
  mapping::LocalizerIndex index = goes_on ? std::move(before->index) : mapping::LocalizerIndex();
  for (const home::Keyframe& keyframe : std::span(placed).subspan(index.size())) {
    ROOMWISE_TRY(const auto measurements, measured(keyframe.id));
    index.add(*measurements);
  }
  // Of a large map both are large: the one is given back before the other is stored.
  home::DerivedData data{kIndexName, made_from, index.to_bytes()};
  index = {};
  return home.put_derived_data(data);
}

Expected<std::optional<KeptLocalizerIndex>> take_localizer_index(const home::Home& home) {
  ROOMWISE_TRY(const MapSettings settings, measuring_settings(home));
  ROOMWISE_TRY(const auto placed, map_keyframes(home));
  ROOMWISE_TRY(auto index, kept_index(home, index_made_from(placed, settings), placed.size()));
  if (!index) return std::nullopt;
  KeptLocalizerIndex kept{*std::move(index), {}};
  for (const home::Keyframe& one : placed) kept.keyframes.push_back(one.id);
  return kept;
}

Expected<void> keep_localizer_index_without(home::Home& home, KeptLocalizerIndex kept,
                                            const std::set<home::KeyframeId>& gone) {
  std::vector<std::size_t> left;
  for (std::size_t i = 0; i < kept.keyframes.size(); ++i) {
    if (!gone.contains(kept.keyframes[i])) left.push_back(i);
  }
  kept.index.keep_only(left);
  ROOMWISE_TRY(const MapSettings settings, measuring_settings(home));
  ROOMWISE_TRY(const auto placed, map_keyframes(home));
  return home.put_derived_data(
      {kIndexName, index_made_from(placed, settings), kept.index.to_bytes()});
}

Expected<motion::FrameMeasurements> HomeLocalizer::measure(const PictureToLocate& picture) const {
  const auto check_size = [&](const auto& image, std::string_view what) -> Expected<void> {
    if (image.width() == picture.camera.width && image.height() == picture.camera.height) return {};
    return fail("the {} is {}x{}, the camera takes {}x{}; give its camera", what, image.width(),
                image.height(), picture.camera.width, picture.camera.height);
  };
  if (auto failed = take_failure()) return Unexpected(*std::move(failed));
  ROOMWISE_RETURN_IF_ERROR(check_size(picture.color, "picture"));
  if (picture.depth) ROOMWISE_RETURN_IF_ERROR(check_size(*picture.depth, "depth image"));
  if (picture.depth) {
    return measure_frame(picture.color, *picture.depth, picture.camera, *extractor_, settings_);
  }
  const image::DepthImage none(picture.color.width(), picture.color.height());
  MapSettings without_views = settings_;
  without_views.mapper.method = mapping::MappingMethod::kPaper;
  return measure_frame(picture.color, none, picture.camera, *extractor_, without_views);
}

Expected<mapping::Localization> HomeLocalizer::locate_uncalibrated(
    const image::ColorImage& color, const motion::IntrinsicsEstimate& lens) const {
  geometry::PinholeCamera camera = lens.camera(color.width(), color.height());
  camera.distortion = {};  // pixels are to stay where they are
  ROOMWISE_TRY(const motion::FrameMeasurements measured, measure({color, std::nullopt, camera}));
  return localizer_.locate({measured, camera, lens});
}

}  // namespace roomwise::pipeline
