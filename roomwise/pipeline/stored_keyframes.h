#pragma once

#include <span>
#include <vector>

#include "roomwise/features/feature_extractor.h"
#include "roomwise/home/home.h"
#include "roomwise/mapping/keyframe.h"
#include "roomwise/mapping/landmarks.h"
#include "roomwise/pipeline/map_settings.h"
#include "roomwise/pipeline/run_context.h"

namespace roomwise::pipeline {

// What mapping took from key-frames, found again in their stored images.
[[nodiscard]] Expected<std::vector<mapping::Keyframe>> measure_keyframes(
    const home::Home& home, std::span<const home::Keyframe> keyframes,
    const geometry::PinholeCamera& camera, const features::FeatureExtractor& extractor,
    const MapSettings& settings, RunContext& run);

// What landmarks are found by, found again in all stored key-frames, by id.
[[nodiscard]] Expected<std::vector<mapping::KeyframeFeatures>> stored_keyframe_features(
    const home::Home& home, const MapSettings& settings, RunContext& run);

}  // namespace roomwise::pipeline
