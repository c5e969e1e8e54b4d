#include "laboratory/simulation/recording/simulation_file.h"

#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "laboratory/simulation/home/home_geometry.h"
#include "roomwise/base/file.h"

namespace roomwise::simulation {
namespace {

using nlohmann::ordered_json;

// One list of fields serves writing and reading: a visitor is called with each name and value.
template <typename Walk, typename Visit>
void visit_walk(Walk& walk, const Visit& visit) {
  visit("seed", walk.seed);
  visit("frames_per_second", walk.frames_per_second);
  visit("camera_height_m", walk.camera_height_m);
  visit("walking_speed_m_s", walk.walking_speed_m_s);
  visit("max_turning_rad_s", walk.max_turning_rad_s);
  visit("jitter", walk.jitter);
  visit("fast_turns", walk.fast_turns);
  visit("rooms", walk.rooms);
  visit("max_frames", walk.max_frames);
}

template <typename Camera, typename Visit>
void visit_camera(Camera& camera, const Visit& visit) {
  visit("fx_px", camera.fx);
  visit("fy_px", camera.fy);
  visit("cx_px", camera.cx);
  visit("cy_px", camera.cy);
  visit("width_px", camera.width);
  visit("height_px", camera.height);
  visit("k1", camera.distortion.k1);
  visit("k2", camera.distortion.k2);
  visit("p1", camera.distortion.p1);
  visit("p2", camera.distortion.p2);
  visit("k3", camera.distortion.k3);
  visit("depth_units_per_metre", camera.depth_units_per_metre);
}

template <typename Render, typename Visit>
void visit_render(Render& render, const Visit& visit) {
  visit("samples_per_pixel", render.samples_per_pixel);
  visit("bake_effort", render.bake_effort);
}

template <typename Sensor, typename Visit>
void visit_sensor(Sensor& sensor, const Visit& visit) {
  visit("seed", sensor.seed);
  visit("auto_exposure", sensor.auto_exposure);
  visit("exposure", sensor.exposure);
  visit("exposure_errors", sensor.exposure_errors);
  visit("auto_white_balance", sensor.auto_white_balance);
  visit("white_balance_errors", sensor.white_balance_errors);
  visit("soft_shoulder", sensor.soft_shoulder);
  visit("motion_blur", sensor.motion_blur);
  visit("color_noise", sensor.color_noise);
  visit("unamplified_radiance", sensor.unamplified_radiance);
  visit("max_amplification", sensor.max_amplification);
  visit("depth_noise", sensor.depth_noise);
  visit("depth_noise_m", sensor.depth_noise_m);
  visit("depth_quantization", sensor.depth_quantization);
  visit("projector_shadow", sensor.projector_shadow);
  visit("lost_surfaces", sensor.lost_surfaces);
  visit("edge_jitter", sensor.edge_jitter);
  visit("limited_range", sensor.limited_range);
  visit("nearest_m", sensor.nearest_m);
  visit("farthest_m", sensor.farthest_m);
}

ordered_json to_json(const SimulationOptions& options) {
  ordered_json json;
  json["home"] = "reference";
  if (options.home) {
    std::vector<std::string> rooms;
    for (const RoomKind kind : options.home->rooms) rooms.emplace_back(name_of(kind));
    json["home"] = {{"seed", options.home->seed}, {"rooms", rooms}};
    if (options.home->storeys != 1) json["home"]["storeys"] = options.home->storeys;
    if (options.home->furniture_seed) json["home"]["furniture"] = *options.home->furniture_seed;
    if (options.home->finish_seed) json["home"]["finishes"] = *options.home->finish_seed;
    if (options.home->mirrored) json["home"]["mirrored"] = true;
  }
  if (options.bare_halls) json["bare_halls"] = true;
  json["scenario"] = name_of(options.scenario);
  json["scenario_seed"] = options.scenario_seed;
  const auto writer = [&](const char* part) {
    return [&json, part](const char* name, const auto& value) { json[part][name] = value; };
  };
  visit_walk(options.walk, writer("walk"));
  visit_camera(options.camera, writer("camera"));
  visit_render(options.render, writer("render"));
  visit_sensor(options.sensor, writer("sensor"));
  return json;
}

// Throws nlohmann's exceptions, which name the field.
Expected<SimulationOptions> from_json(const ordered_json& json) {
  SimulationOptions options;
  if (const auto& home = json.at("home"); home != "reference") {
    options.home = HomeOptions{home.at("seed"), {}, home.value("storeys", 1)};
    if (home.contains("furniture")) options.home->furniture_seed = home.at("furniture");
    if (home.contains("finishes")) options.home->finish_seed = home.at("finishes");
    options.home->mirrored = home.value("mirrored", false);
    for (const std::string name : home.at("rooms")) {
      ROOMWISE_TRY(const RoomKind kind, parse_room_kind(name));
      options.home->rooms.push_back(kind);
    }
  }
  options.bare_halls = json.value("bare_halls", false);
  ROOMWISE_TRY(options.scenario, parse_scenario(json.at("scenario").get<std::string>()));
  json.at("scenario_seed").get_to(options.scenario_seed);
  const auto reader = [&](const char* part) {
    return
        [&fields = json.at(part)](const char* name, auto& value) { fields.at(name).get_to(value); };
  };
  visit_walk(options.walk, reader("walk"));
  visit_camera(options.camera, reader("camera"));
  visit_render(options.render, reader("render"));
  visit_sensor(options.sensor, reader("sensor"));
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  return options;
}

}  // namespace

Expected<void> write_simulation(const std::filesystem::path& path, const MadeRecording& made) {
  ordered_json json = to_json(made.options);
  json["scene_sha256"] = made.scene_sha256;
  return write_file(path, json.dump(2) + "\n");
}

Expected<MadeRecording> read_simulation(const std::filesystem::path& path) {
  ROOMWISE_TRY(const std::string text, read_text_file(path));
  try {
    const auto json = ordered_json::parse(text);
    auto options = from_json(json);
    if (!options) return Unexpected(std::move(options).error().with_context(path.string()));
    return MadeRecording{*std::move(options), json.at("scene_sha256").get<std::string>()};
  } catch (const nlohmann::json::exception& error) {
    return fail(
        "{}: does not describe a simulation as this version does: {}; make the recording anew",
        path.string(), error.what());
  }
}

bool are_alike(const SimulationOptions& a, const SimulationOptions& b) {
  return to_json(a) == to_json(b);
}

}  // namespace roomwise::simulation
