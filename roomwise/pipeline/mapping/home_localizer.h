#pragma once

#include <memory>
#include <optional>

#include "roomwise/features/feature_extractor.h"
#include "roomwise/home/home.h"
#include "roomwise/mapping/localization/localizer.h"
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
  // Measures the key-frames of the map's largest component anew, which takes a moment. Fails where
  // the home has no map.
  [[nodiscard]] static Expected<HomeLocalizer> create(const home::Home& home,
                                                      const mapping::LocalizerOptions& options,
                                                      RunContext& run);

  // What the localiser needs of a picture, to be measured once. Fails where an image is not of the
  // camera's size.
  [[nodiscard]] Expected<motion::FrameMeasurements> measure(const PictureToLocate& picture) const;
  // Where a picture was taken by a camera that nobody calibrated, of whose lens this is known.
  [[nodiscard]] Expected<mapping::Localization> locate_uncalibrated(
      const image::ColorImage& color, const motion::LensEstimate& lens) const;
  [[nodiscard]] const mapping::Localizer& localizer() const { return localizer_; }

 private:
  HomeLocalizer(MapSettings settings, const mapping::LocalizerOptions& options);

  MapSettings settings_;
  std::unique_ptr<features::FeatureExtractor> extractor_;
  mapping::Localizer localizer_;
};

}  // namespace roomwise::pipeline
