#pragma once

#include <functional>
#include <span>
#include <vector>

#include "roomwise/features/feature_extractor.h"
#include "roomwise/home/home.h"
#include "roomwise/mapping/backend/map_refinement.h"
#include "roomwise/mapping/frontend/keyframe.h"
#include "roomwise/pipeline/run_context.h"
#include "roomwise/pipeline/stored/map_settings.h"

namespace roomwise::pipeline {

// Takes a key-frame, which may fail.
using TakeKeyframe = std::function<Expected<void>(mapping::Keyframe)>;

// What mapping took from key-frames, found again in their stored images; they are handed over one
// by one, in the order given. One whose images are lost (RunContext::lost) is handed over, too, as
// if it had shown nothing.
[[nodiscard]] Expected<void> measure_each_keyframe(const home::Home& home,
                                                   std::span<const home::Keyframe> keyframes,
                                                   const features::FeatureExtractor& extractor,
                                                   const MapSettings& settings, RunContext& run,
                                                   const TakeKeyframe& take);
// The same, all together.
[[nodiscard]] Expected<std::vector<mapping::Keyframe>> measure_keyframes(
    const home::Home& home, std::span<const home::Keyframe> keyframes,
    const features::FeatureExtractor& extractor, const MapSettings& settings, RunContext& run);

// Finds what landmarks are found by again in key-frames as they are stored. Which there are is read
// once, however often it is asked for some of them; home, settings and run outlive it.
[[nodiscard]] Expected<mapping::FindFeatures> stored_keyframe_features(const home::Home& home,
                                                                       const MapSettings& settings,
                                                                       RunContext& run);

}  // namespace roomwise::pipeline
