#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "roomwise/base/expected.h"
#include "roomwise/features/feature_extractor.h"
#include "roomwise/home/home.h"
#include "roomwise/mapping/backend/map_refinement.h"
#include "roomwise/mapping/backend/map_solver.h"
#include "roomwise/mapping/frontend/mapper.h"
#include "roomwise/motion/measured_features.h"
#include "roomwise/objects/detection/confirmed_objects.h"

namespace roomwise::pipeline {

// With what a map is made. A home keeps them, so that an interrupted run goes on with the same.
struct MapSettings {
  features::FeatureKind features = features::FeatureKind::kSurf;
  int max_keypoints = 1000;  // a frame
  motion::DepthRange depth;
  mapping::MapperOptions mapper;
  mapping::MapSolverOptions solver;
  // Landmarks and bundle adjustment at the end, and frames between key-frames by the motion of a
  // hand. The paper's method has neither.
  bool bundle_adjustment = true;
  mapping::RefinementOptions refinement;
  objects::ObjectRules objects;
  // Of the walk before the last, key-frames that add nothing to what the walks before it show go
  // when a further walk is mapped. The paper's method keeps all.
  bool keyframe_culling = true;

  [[nodiscard]] Expected<void> validate() const;
  [[nodiscard]] bool culls_keyframes() const {
    return keyframe_culling && mapper.method != mapping::MappingMethod::kPaper;
  }
  [[nodiscard]] bool adjusts_bundle() const {
    return bundle_adjustment && mapper.method != mapping::MappingMethod::kPaper;
  }
};

// The settings that the command line offers, as JSON; the others have their defaults.
[[nodiscard]] std::string to_json(const MapSettings& settings);
[[nodiscard]] Expected<MapSettings> map_settings_from_json(std::string_view json);

// Those that a home keeps of its map; nothing where no map was begun.
[[nodiscard]] Expected<void> store_map_settings(home::Home& home, const MapSettings& settings);
[[nodiscard]] Expected<std::optional<MapSettings>> stored_map_settings(const home::Home& home);

}  // namespace roomwise::pipeline
