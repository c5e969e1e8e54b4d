#include "roomwise/pipeline/exports/home_json.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "roomwise/pipeline/rooms/room_outline.h"

namespace roomwise::pipeline {
namespace {

// Keeps its members in the order of writing.
using Json = nlohmann::ordered_json;

Json json_of(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}
Json json_of(const Eigen::Vector2d& v) {
  return {v.x(), v.y()};
}
Json json_of(const Eigen::Quaterniond& q) {
  return {q.x(), q.y(), q.z(), q.w()};
}
Json word_or_null(const std::string& word) {
  return word.empty() ? Json(nullptr) : Json(word);
}

// A place of the layout, in the level frame.
Json floor_json(const Eigen::Vector2d& point_plan, const HomeContents& contents) {
  return json_of(Eigen::Vector2d(contents.place_gravity(point_plan).head<2>()));
}

// A closed ring: its first corner is also its last.
Json ring_json(const geometry::CellRing& ring, const HomeContents& contents) {
  const fusion::FloorGrid& grid = *contents.floor.grid;
  Json corners = Json::array();
  for (std::size_t i = 0; i <= ring.size(); ++i) {
    corners.push_back(floor_json(
        grid.origin_m() + grid.cell_m() * ring[i % ring.size()].cast<double>(), contents));
  }
  return corners;
}

Json polygons_json(const geometry::CellSet& cells, const HomeContents& contents) {
  Json polygons = Json::array();
  for (const geometry::CellPolygon& polygon : geometry::cell_outlines(cells)) {
    Json rings = Json::array({ring_json(polygon.outer, contents)});
    for (const geometry::CellRing& hole : polygon.holes) rings.push_back(ring_json(hole, contents));
    polygons.push_back(std::move(rings));
  }
  return polygons;
}

Json room_json(const rooms::Room& room, const HomeContents& contents) {
  Json json{{"name", room.name},   {"type", word_or_null(room.type)}, {"floor_m2", nullptr},
            {"middle_m", nullptr}, {"polygons", Json::array()},       {"neighbors", Json::array()}};
  if (!contents.layout) return json;
  const auto& extents = contents.layout->rooms();
  const auto extent = std::ranges::find(extents, room.name, &rooms::RoomExtent::name);
  if (extent == extents.end() || extent->floor_m2 == 0) return json;
  json["floor_m2"] = extent->floor_m2;
  json["middle_m"] = floor_json(extent->middle_plan, contents);
  json["polygons"] = polygons_json(room_cells(*contents.floor.grid, *contents.layout,
                                              static_cast<std::size_t>(extent - extents.begin())),
                                   contents);
  json["neighbors"] = contents.layout->neighbors(room.name);
  if (contents.storeys().are_several()) {
    json["storey"] = contents.storeys().at_plan(extent->middle_plan);
  }
  return json;
}

// Doors that a hand can find, or the borders where rooms are open to each other.
Json doors_json(const HomeContents& contents, bool are_openings) {
  Json doors = Json::array();
  if (!contents.layout) return doors;
  for (const rooms::Doorway& door : contents.layout->doorways()) {
    if (door.is_stairs || door.is_door() == are_openings) continue;
    doors.push_back({{"rooms", door.rooms},
                     {"middle_m", floor_json(door.middle_plan, contents)},
                     {"width_m", door.width_m > 0 ? Json(door.width_m) : Json(nullptr)},
                     {"walked", door.is_walked}});
    if (contents.storeys().are_several()) {
      doors.back()["storey"] = contents.storeys().at_plan(door.middle_plan);
    }
  }
  return doors;
}

Json storey_list_json(const fusion::Storeys& storeys) {
  Json all = Json::array();
  for (const fusion::Storey& storey : storeys.all()) all.push_back({{"floor_m", storey.floor_m}});
  return all;
}

Json flights_json(const HomeContents& contents) {
  Json all = Json::array();
  for (const fusion::Staircase& stairs : contents.storeys().stairs()) {
    const auto room_at = [&](const Eigen::Vector2d& place) {
      const auto room = contents.layout ? contents.layout->room_at(place) : std::nullopt;
      return room ? Json(*room) : Json(nullptr);
    };
    Json rails = Json::array();
    if (stairs.has_left_rail) rails.push_back("left");
    if (stairs.has_right_rail) rails.push_back("right");
    all.push_back({{"storeys", {stairs.lower, stairs.lower + 1}},
                   {"rooms", {room_at(stairs.below_plan), room_at(stairs.above_plan)}},
                   {"foot_m", json_of(stairs.foot_gravity)},
                   {"top_m", json_of(stairs.top_gravity)},
                   {"up_rad", stairs.up_rad},
                   {"steps", stairs.steps > 0 ? Json(stairs.steps) : Json(nullptr)},
                   {"height_m", stairs.height_m},
                   {"width_m", stairs.width_m > 0 ? Json(stairs.width_m) : Json(nullptr)},
                   {"rails", std::move(rails)}});
  }
  return all;
}

Json sighting_json(const std::optional<Sighting>& seen, const HomeContents& contents) {
  if (!seen) return nullptr;
  const auto walk = std::ranges::find(contents.walks, seen->walk,
                                      [](const WalkContent& one) { return one.stored.id; });
  if (walk == contents.walks.end()) return nullptr;  // it is taken away
  return {{"walk", walk - contents.walks.begin()}, {"time_s", seconds_between(0, seen->time_ns)}};
}

Json box_json(const std::optional<geometry::OrientedBox>& box) {
  if (!box) return nullptr;
  return {{"middle_m", json_of(box->center())},
          {"quaternion_xyzw", json_of(box->world_from_box.rotation)},
          {"size_m", json_of(box->size_m)}};
}

Json thing_json(const ThingContent& thing, const HomeContents& contents) {
  return {{"name", thing.instance.name},
          {"probability", thing.instance.probability},
          {"names", thing.instance.names},
          {"piece", thing.component},
          {"box", box_json(thing.box_gravity)},
          {"sigma_m", json_of(thing.instance.sigma_m)},
          {"room", thing.room ? Json(*thing.room) : Json(nullptr)},
          {"first_seen", sighting_json(thing.first_seen, contents)},
          {"last_seen", sighting_json(thing.last_seen, contents)},
          {"visit", word_or_null(thing.visit)},
          {"by_hand", thing.is_confirmed},
          {"note", word_or_null(thing.note)}};
}

Json camera_json(const geometry::PinholeCamera& camera) {
  const geometry::LensDistortion& lens = camera.distortion;
  return {{"width", camera.width}, {"height", camera.height}, {"fx", camera.fx}, {"fy", camera.fy},
          {"cx", camera.cx},       {"cy", camera.cy},         {"k1", lens.k1},   {"k2", lens.k2},
          {"p1", lens.p1},         {"p2", lens.p2},           {"k3", lens.k3}};
}

Json walk_json(const WalkContent& walk, const HomeContents& contents) {
  Json path = Json::array();
  for (const home::Keyframe& keyframe : walk.keyframes) {
    if (keyframe.pose.component != 0) continue;
    const geometry::RigidTransform pose =
        contents.gravity_from_world() * keyframe.pose.world_from_keyframe;
    const auto room = contents.keyframe_rooms.find(keyframe.id);
    path.push_back(
        {{"time_s", seconds_between(0, keyframe.timestamp_ns)},
         {"frame", keyframe.frame_index},
         {"position_m", json_of(pose.translation)},
         {"quaternion_xyzw", json_of(pose.rotation)},
         {"room", room == contents.keyframe_rooms.end() ? Json(nullptr) : Json(room->second)}});
  }
  const auto apart = walk.keyframes.size() - path.size();
  return {{"name", walk.stored.recording.name},
          {"finished", walk.stored.finished},
          {"frames", walk.frames},
          {"placed", walk.placed},
          {"keyframes_elsewhere", apart},
          {"camera", camera_json(walk.stored.recording.camera)},
          {"path", std::move(path)}};
}

Json frames_json(const HomeContents& contents) {
  const geometry::RigidTransform& pose = contents.gravity_from_world();
  return {{"level",
           "x, y on the floor, z up; z = 0 is the floor or, where floor_found is false, the height "
           "of the first camera. All places are in it"},
          {"camera", "x right, y down, z forward; pixel (0, 0) is the middle of the top left one"},
          {"floor_found", contents.floor.frame.has_floor},
          {"level_from_world",
           {{"translation_m", json_of(pose.translation)},
            {"quaternion_xyzw", json_of(pose.rotation)}}}};
}

}  // namespace

std::string home_json(const HomeContents& contents) {
  Json json{{"format", "roomwise-home"},
            {"version", 1},
            {"units", {{"length", "m"}, {"area", "m2"}, {"time", "s"}, {"image", "px"}}},
            {"frames", frames_json(contents)},
            {"rooms", Json::array()},
            {"doors", doors_json(contents, false)},
            {"openings", doors_json(contents, true)},
            {"things", Json::array()},
            {"walks", Json::array()}};
  if (contents.storeys().are_several()) {
    json["version"] = 2;
    json["storeys"] = storey_list_json(contents.storeys());
    json["stairs"] = flights_json(contents);
  }
  for (const rooms::Room& room : contents.rooms) json["rooms"].push_back(room_json(room, contents));
  for (const ThingContent& thing : contents.things) {
    json["things"].push_back(thing_json(thing, contents));
  }
  for (const WalkContent& walk : contents.walks) {
    json["walks"].push_back(walk_json(walk, contents));
  }
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace roomwise::pipeline
