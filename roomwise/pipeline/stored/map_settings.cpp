#include "roomwise/pipeline/stored/map_settings.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "roomwise/base/in_context.h"

namespace roomwise::pipeline {
namespace {

constexpr const char* kSettingsKey = "map";

}  // namespace

Expected<void> MapSettings::validate() const {
  if (max_keypoints < 50) return fail("max_keypoints = {} must be at least 50", max_keypoints);
  ROOMWISE_RETURN_IF_ERROR(depth.validate());
  ROOMWISE_RETURN_IF_ERROR(mapper.validate());
  ROOMWISE_RETURN_IF_ERROR(solver.validate());
  ROOMWISE_RETURN_IF_ERROR(refinement.validate());
  return objects.validate();
}

std::string to_json(const MapSettings& settings) {
  return nlohmann::ordered_json{
      {"method", mapping::to_string(settings.mapper.method)},
      {"features", features::to_string(settings.features)},
      {"max_keypoints", settings.max_keypoints},
      {"keyframe_translation_m", settings.mapper.keyframe_translation_m},
      {"keyframe_rotation_rad", settings.mapper.keyframe_rotation_rad},
      {"loop_neighbors", settings.mapper.loops.neighbors},
      {"loop_random", settings.mapper.loops.random},
      {"loop_similar", settings.mapper.loops.similar},
      {"keyframe_reuse", settings.mapper.reuse.max_motion_ratio},
      {"keyframe_reuse_age", settings.mapper.reuse.min_age},
      {"bundle_adjustment", settings.adjusts_bundle()},
      {"upright", settings.refinement.uses_gravity},
      {"device_motion", settings.mapper.device_motion},
      {"keyframe_culling", settings.culls_keyframes()},
      {"object_score", settings.objects.min_score},
      {"seed", settings.mapper.seed},
  }
      .dump();
}

Expected<MapSettings> map_settings_from_json(std::string_view json) {
  MapSettings settings;
  try {
    const auto values = nlohmann::json::parse(json);
    ROOMWISE_TRY(settings.features,
                 features::parse_feature_kind(values.at("features").get<std::string>()));
    ROOMWISE_TRY(settings.mapper.method,
                 mapping::parse_mapping_method(values.at("method").get<std::string>()));
    values.at("max_keypoints").get_to(settings.max_keypoints);
    values.at("keyframe_translation_m").get_to(settings.mapper.keyframe_translation_m);
    values.at("keyframe_rotation_rad").get_to(settings.mapper.keyframe_rotation_rad);
    values.at("loop_neighbors").get_to(settings.mapper.loops.neighbors);
    values.at("loop_random").get_to(settings.mapper.loops.random);
    values.at("loop_similar").get_to(settings.mapper.loops.similar);
    values.at("keyframe_reuse").get_to(settings.mapper.reuse.max_motion_ratio);
    values.at("keyframe_reuse_age").get_to(settings.mapper.reuse.min_age);
    values.at("bundle_adjustment").get_to(settings.bundle_adjustment);
    values.at("device_motion").get_to(settings.mapper.device_motion);
    values.at("object_score").get_to(settings.objects.min_score);
    // Homes of before say nothing of these.
    settings.refinement.uses_gravity = values.value("upright", settings.refinement.uses_gravity);
    settings.keyframe_culling = values.value("keyframe_culling", settings.culls_keyframes());
    values.at("seed").get_to(settings.mapper.seed);
  } catch (const nlohmann::json::exception& error) {
    return fail("the map's settings cannot be read: {}", error.what());
  }
  ROOMWISE_RETURN_IF_ERROR(settings.validate());
  return settings;
}

Expected<void> store_map_settings(home::Home& home, const MapSettings& settings) {
  return home.put_setting(kSettingsKey, to_json(settings));
}

Expected<std::optional<MapSettings>> stored_map_settings(const home::Home& home) {
  ROOMWISE_TRY(const auto stored, home.settings());
  const auto own = stored.find(kSettingsKey);
  if (own == stored.end()) return std::nullopt;
  return in_context(home.file(), map_settings_from_json(own->second));
}

}  // namespace roomwise::pipeline
