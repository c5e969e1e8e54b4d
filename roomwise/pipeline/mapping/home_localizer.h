#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "roomwise/features/feature_extractor.h"
#include "roomwise/home/home.h"
#include "roomwise/mapping/frontend/measurement_store.h"
#include "roomwise/mapping/localization/localizer.h"
#include "roomwise/pipeline/mapping/keyframes_on_demand.h"
#include "roomwise/pipeline/run_context.h"
#include "roomwise/pipeline/stored/map_settings.h"

namespace roomwise::pipeline {

// A picture to be localised: of any camera that is calibrated, with depth or without.
struct PictureToLocate {
  image::ColorImage color;
  std::optional<image::DepthImage> depth;
  geometry::PinholeCamera camera;  // whose size the images have
};

// Says where on a home's map a picture was taken.
class HomeLocalizer {
 public:
  // Of the key-frames of the map's largest component. Where the home keeps their index
  // (keep_localizer_index()) and it is fresh, it is ready at once, and measures key-frames as
  // pictures ask for them; else it measures all of them, which takes a moment (10 CPU-ms each).
  // Some 128 MB of them stay in memory. Fails where the home has no map.
  [[nodiscard]] static Expected<HomeLocalizer> create(const home::Home& home,
                                                      const mapping::LocalizerOptions& options,
                                                      RunContext& run);

  // What the localiser needs of a picture, to be measured once. Fails where an image is not of the
  // camera's size, and where take_failure() tells of one.
  [[nodiscard]] Expected<motion::FrameMeasurements> measure(const PictureToLocate& picture) const;
  // Where a picture was taken by a camera that nobody calibrated, of whose lens this is known.
  [[nodiscard]] Expected<mapping::Localization> locate_uncalibrated(
      const image::ColorImage& color, const motion::IntrinsicsEstimate& lens) const;
  [[nodiscard]] const mapping::Localizer& localizer() const { return localizer_; }
  // What was measured in a key-frame, by its place among those of the map; null where it cannot be
  // had. Thread-safe.
  [[nodiscard]] std::shared_ptr<const mapping::MeasuredKeyframe> keyframe(std::size_t place) const {
    return keyframes_->get(place);
  }
  // Why a key-frame of the map could not be read when a picture asked for it: answers did without
  // it. Told once; the next picture that needs it tries again.
  [[nodiscard]] std::optional<Error> take_failure() const { return keyframes_->take_failure(); }
  // The index, where it was not kept or stale, to be kept.
  [[nodiscard]] const std::optional<home::DerivedData>& new_index() const { return new_index_; }

 private:
  HomeLocalizer(MapSettings settings, std::shared_ptr<KeyframesOnDemand> keyframes,
                mapping::Localizer localizer);

  MapSettings settings_;
  std::unique_ptr<features::FeatureExtractor> extractor_;
  std::shared_ptr<KeyframesOnDemand> keyframes_;
  mapping::Localizer localizer_;
  std::optional<home::DerivedData> new_index_;
};

// A localiser's index, and the numbers of the key-frames that it is of.
struct KeptLocalizerIndex {
  mapping::LocalizerIndex index;
  std::vector<home::KeyframeId> keyframes;
};

// Keeps in the home what a HomeLocalizer begins with, unless it is there, whole and fresh.
// `measured` gives what mapping took from a key-frame, with its view.
// `before`, if it is one of key-frames that the home still has, is gone on with.
[[nodiscard]] Expected<void> keep_localizer_index(
    home::Home& home,
    const std::function<Expected<mapping::SharedMeasurements>(home::KeyframeId)>& measured,
    std::optional<KeptLocalizerIndex> before = std::nullopt);

// If the home keeps a fresh one.
[[nodiscard]] Expected<std::optional<KeptLocalizerIndex>> take_localizer_index(
    const home::Home& home);
// Keeps it without key-frames that the home had when it was taken and has no more.
[[nodiscard]] Expected<void> keep_localizer_index_without(home::Home& home, KeptLocalizerIndex kept,
                                                          const std::set<home::KeyframeId>& gone);

}  // namespace roomwise::pipeline
