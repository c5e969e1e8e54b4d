#pragma once

#include <cstddef>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "roomwise/features/feature_extractor.h"
#include "roomwise/home/home.h"
#include "roomwise/mapping/localization/localizer_index.h"
#include "roomwise/pipeline/stored/lost_pictures.h"
#include "roomwise/pipeline/stored/map_settings.h"

namespace roomwise::pipeline {

// What was measured in a home's key-frames, found again in their stored images when it is asked
// for; what was asked for last stays in memory. Thread-safe.
class KeyframesOnDemand {
 public:
  // By a reader of its own. Fails where the first one's images cannot be read, as of a home that is
  // locked, unless `lost` says to go on without them.
  [[nodiscard]] static Expected<std::shared_ptr<KeyframesOnDemand>> create(
      const home::Home& home, std::vector<home::Keyframe> keyframes, MapSettings settings,
      std::size_t max_bytes, std::shared_ptr<LostPictures> lost = nullptr);

  // By place among the key-frames. Null where the home does not hold the key-frame any more, and
  // where it cannot be read: then take_failure() tells why, unless `lost` says to go on without.
  [[nodiscard]] std::shared_ptr<const mapping::MeasuredKeyframe> get(std::size_t index);
  // Keeps what was measured already, as if it had been asked for.
  std::shared_ptr<const mapping::MeasuredKeyframe> put(std::size_t index,
                                                       motion::FrameMeasurements measurements);
  // The first one since it was asked last.
  [[nodiscard]] std::optional<Error> take_failure();

 private:
  using Shared = std::shared_ptr<const mapping::MeasuredKeyframe>;
  KeyframesOnDemand(home::Home reader, std::vector<home::Keyframe> keyframes, MapSettings settings,
                    std::size_t max_bytes, std::shared_ptr<LostPictures> lost);
  [[nodiscard]] Expected<std::optional<home::KeyframeImages>> read(const home::Keyframe& keyframe);
  [[nodiscard]] Expected<std::optional<motion::FrameMeasurements>> measure(std::size_t index);

  home::Home reader_;
  std::vector<home::Keyframe> keyframes_;
  MapSettings settings_;
  std::size_t max_bytes_;
  std::shared_ptr<LostPictures> lost_;
  std::map<home::RecordingId, geometry::PinholeCamera> cameras_;
  std::unique_ptr<features::FeatureExtractor> extractor_;

  struct Held {
    Shared keyframe;
    std::size_t bytes = 0;
    std::list<std::size_t>::iterator use;
  };
  std::mutex reader_mutex_;
  mutable std::mutex mutex_;  // for all below
  std::map<std::size_t, Held> held_;
  std::list<std::size_t> used_;  // the one used last first
  std::size_t bytes_ = 0;
  std::optional<Error> failure_;
};

}  // namespace roomwise::pipeline
