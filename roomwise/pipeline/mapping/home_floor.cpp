#include "roomwise/pipeline/mapping/home_floor.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "roomwise/pipeline/mapping/walked_floor.h"
#include "roomwise/pipeline/stored/keyframe_images.h"
#include "roomwise/pipeline/stored/made_from.h"

namespace roomwise::pipeline {
namespace {

using nlohmann::json;

const std::string kName = "floor";
// To be raised where fusing, the frame or the grid come out otherwise than before.
constexpr std::uint64_t kMethod = 4;

// All that the floor follows from: which key-frames the map has, and where they are. Their images
// and cameras never change.
Expected<std::string> floor_made_from(const home::Home& home) {
  ROOMWISE_TRY(const auto keyframes, map_keyframes(home));
  if (keyframes.empty()) {
    return fail("{}: the home has no map yet; make one with roomwise map", home.file());
  }
  MadeFrom made_from;
  made_from.add(kMethod);
  made_from.add(keyframes);
  return made_from.digest();
}

json point_json(const Eigen::Vector2d& point) {
  return {point.x(), point.y()};
}

Eigen::Vector2d point_from(const json& value) {
  const auto n = value.get<std::array<double, 2>>();
  return {n[0], n[1]};
}

json storeys_json(const fusion::Storeys& storeys) {
  json all = json::array(), flights = json::array();
  for (const fusion::Storey& one : storeys.all()) {
    all.push_back({{"floor_m", one.floor_m},
                   {"plan_from_gravity", point_json(one.plan_from_gravity)},
                   {"plan_from_x_m", one.plan_from_x_m}});
  }
  for (const fusion::Staircase& one : storeys.stairs()) {
    flights.push_back({{"lower", one.lower},
                       {"below_plan", point_json(one.below_plan)},
                       {"above_plan", point_json(one.above_plan)},
                       {"foot_gravity", point_json(one.foot_gravity)},
                       {"top_gravity", point_json(one.top_gravity)},
                       {"up_rad", one.up_rad},
                       {"end_rad", one.end_rad},
                       {"run_m", one.run_m},
                       {"height_m", one.height_m},
                       {"steps", one.steps},
                       {"width_m", one.width_m},
                       {"left_rail", one.has_left_rail},
                       {"right_rail", one.has_right_rail}});
  }
  return {{"all", std::move(all)}, {"stairs", std::move(flights)}};
}

fusion::Storeys storeys_from(const json& value) {
  std::vector<fusion::Storey> all;
  for (const json& one : value.at("all")) {
    all.push_back({one.at("floor_m").get<double>(), point_from(one.at("plan_from_gravity")),
                   one.at("plan_from_x_m").get<double>()});
  }
  std::vector<fusion::Staircase> flights;
  for (const json& one : value.at("stairs")) {
    fusion::Staircase& stairs = flights.emplace_back();
    one.at("lower").get_to(stairs.lower);
    if (all.empty() || stairs.lower >= all.size() - 1)  // a number below 0 is read as a huge one
      throw json::other_error::create(501, "stairs lead nowhere", &value);
    stairs.below_plan = point_from(one.at("below_plan"));
    stairs.above_plan = point_from(one.at("above_plan"));
    stairs.foot_gravity = point_from(one.at("foot_gravity"));
    stairs.top_gravity = point_from(one.at("top_gravity"));
    one.at("up_rad").get_to(stairs.up_rad);
    one.at("end_rad").get_to(stairs.end_rad);
    one.at("run_m").get_to(stairs.run_m);
    one.at("height_m").get_to(stairs.height_m);
    one.at("steps").get_to(stairs.steps);
    one.at("width_m").get_to(stairs.width_m);
    one.at("left_rail").get_to(stairs.has_left_rail);
    one.at("right_rail").get_to(stairs.has_right_rail);
  }
  return fusion::Storeys(std::move(all), std::move(flights));
}

Bytes to_bytes(const HomeFloor& floor) {
  const geometry::RigidTransform& pose = floor.frame.gravity_from_world;
  const Eigen::Vector3d& t = pose.translation;
  const Eigen::Quaterniond& q = pose.rotation;
  json value{{"gravity_from_world", {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()}},
             {"has_floor", floor.frame.has_floor},
             {"has_up", floor.frame.has_up}};
  if (floor.grid) {
    std::vector<std::uint8_t> cells;
    for (int row = 0; row < floor.grid->rows(); ++row) {
      for (int column = 0; column < floor.grid->columns(); ++column)
        cells.push_back(static_cast<std::uint8_t>(floor.grid->at(column, row)));
    }
    value["grid"] = {{"origin_m", {floor.grid->origin_m().x(), floor.grid->origin_m().y()}},
                     {"cell_m", floor.grid->cell_m()},
                     {"columns", floor.grid->columns()},
                     {"cells", json::binary(std::move(cells))}};
  }
  if (floor.frame.storeys.are_several()) value["storeys"] = storeys_json(floor.frame.storeys);
  return json::to_cbor(value);
}

fusion::FloorGrid grid_from(const json& value) {
  const auto origin_m = value.at("origin_m").get<std::array<double, 2>>();
  const auto columns = value.at("columns").get<std::size_t>();
  const std::vector<std::uint8_t>& cells = value.at("cells").get_binary();
  if (columns == 0 || cells.empty() || cells.size() % columns != 0)
    throw json::other_error::create(501, "cells are no rectangle", &value);
  image::Image<fusion::FloorCell> image(static_cast<int>(columns),
                                        static_cast<int>(cells.size() / columns));
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (cells[i] > static_cast<std::uint8_t>(fusion::FloorCell::kOccupied))
      throw json::other_error::create(501, "a cell is of no kind", &value);
    image.at(static_cast<int>(i % columns), static_cast<int>(i / columns)) =
        static_cast<fusion::FloorCell>(cells[i]);
  }
  return {{origin_m[0], origin_m[1]}, value.at("cell_m").get<double>(), std::move(image)};
}

// Nothing where they are not what to_bytes() gave.
std::optional<HomeFloor> from_bytes(const Bytes& bytes) {
  try {
    const json value = json::from_cbor(bytes);
    const auto n = value.at("gravity_from_world").get<std::array<double, 7>>();
    HomeFloor floor;
    floor.frame.gravity_from_world = {Eigen::Quaterniond(n[6], n[3], n[4], n[5]),
                                      {n[0], n[1], n[2]}};
    value.at("has_floor").get_to(floor.frame.has_floor);
    value.at("has_up").get_to(floor.frame.has_up);
    if (value.contains("storeys")) floor.frame.storeys = storeys_from(value.at("storeys"));
    if (value.contains("grid")) floor.grid = grid_from(value.at("grid"));
    return floor;
  } catch (const json::exception&) {
    return std::nullopt;
  }
}

Expected<HomeFloor> build_home_floor(const home::Home& home, RunContext& run) {
  ROOMWISE_TRY(GravityAlignedMap map,
               build_gravity_aligned_map(home, {.keeps_colors = false}, run));
  return floor_of(map, run);
}

}  // namespace

Expected<HomeFloor> floor_of(GravityAlignedMap& map, RunContext& run) {
  HomeFloor floor{map.frame, std::nullopt};
  if (map.frame.has_floor) {
    ROOMWISE_TRY(floor.grid, floor_grid_of(map, {}, run));
  }
  return floor;
}

Expected<HomeFloor> find_home_floor(const home::Home& home, RunContext& run) {
  ROOMWISE_TRY(const std::string now, floor_made_from(home));
  ROOMWISE_TRY(const auto kept, home.derived_data(kName));
  auto floor = kept && kept->made_from == now ? from_bytes(kept->data) : std::nullopt;
  if (!floor) {
    ROOMWISE_TRY(floor, build_home_floor(home, run));
  }
  if (floor->grid) {
    ROOMWISE_TRY(const auto frames, walked_frames(home));
    floor->grid = with_walked_ways(*floor->grid, floor->frame, frames);
  }
  return *std::move(floor);
}

Expected<void> keep_home_floor(home::Home& home, RunContext& run) {
  ROOMWISE_TRY(const std::string now, floor_made_from(home));
  ROOMWISE_TRY(const auto kept, home.derived_data(kName));
  if (kept && kept->made_from == now && from_bytes(kept->data)) return {};
  ROOMWISE_TRY(const HomeFloor floor, build_home_floor(home, run));
  return keep_home_floor(home, floor);
}

Expected<void> keep_home_floor(home::Home& home, const HomeFloor& floor) {
  ROOMWISE_TRY(const std::string now, floor_made_from(home));
  ROOMWISE_TRY(const auto kept, home.derived_data(kName));
  if (kept && kept->made_from == now && from_bytes(kept->data)) return {};
  return home.put_derived_data({kName, now, to_bytes(floor)});
}

}  // namespace roomwise::pipeline
