#include "roomwise/live/routes/home_json.h"

#include <algorithm>
#include <bit>
#include <numbers>

#include "roomwise/base/calendar_time.h"
#include "roomwise/pipeline/rooms/room_outline.h"

namespace roomwise::live {
namespace {

Json json_of(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}
Json json_of(const Eigen::Vector2d& v) {
  return {v.x(), v.y()};
}
Json or_null(const std::optional<std::string>& text) {
  return text ? Json(*text) : Json(nullptr);
}

// Its corners; the last leads back to the first.
Json ring_json(const geometry::CellRing& ring, const fusion::FloorGrid& grid) {
  Json corners = Json::array();
  for (const Eigen::Vector2i& corner : ring) {
    corners.push_back(
        json_of(Eigen::Vector2d(grid.origin_m() + grid.cell_m() * corner.cast<double>())));
  }
  return corners;
}

Json room_json(const rooms::Room& room, const HomeView& view) {
  Json json{{"name", room.name}, {"type", room.type}, {"floor_m2", nullptr}, {"middle", nullptr}};
  if (!view.layout) return json;
  const auto& extents = view.layout->rooms();
  const auto extent = std::ranges::find(extents, room.name, &rooms::RoomExtent::name);
  if (extent != extents.end() && extent->floor_m2 > 0) {
    json["floor_m2"] = extent->floor_m2;
    json["middle"] = json_of(extent->middle_plan);
  }
  return json;
}

Json thing_json(const guide::KnownThing& thing) {
  const network::PixelBox& box = thing.picture_box;
  return {{"id", thing_id(thing)},
          {"name", thing.name},
          {"probability", thing.probability},
          {"room", or_null(thing.room)},
          {"position", thing.position_plan ? json_of(*thing.position_plan) : Json(nullptr)},
          {"size", json_of(thing.size_m())},
          {"keyframe", thing.keyframe_id},
          {"by_hand", thing.is_confirmed},
          {"added", thing.added_by_edit != 0},
          {"note", thing.note},
          {"box", {box.left, box.top, box.right - box.left, box.bottom - box.top}}};
}

// When the walk began, in seconds since 1970; null where its stamps tell no date.
Json recorded_json(const ViewedWalk& walk, const HomeView& view) {
  const auto first =
      std::ranges::find(view.keyframes, walk.stored.id,
                        [](const ViewedKeyframe& one) { return one.keyframe.recording; });
  if (first == view.keyframes.end() || !calendar_time(first->keyframe.timestamp_ns)) return nullptr;
  return first->keyframe.timestamp_ns / 1'000'000'000;
}

Json walk_json(const ViewedWalk& walk, const HomeView& view) {
  const home::Recording& recording = walk.stored.recording;
  Json ranges = Json::array();
  for (const recording::RoomRange& range : walk.labels.ranges()) {
    ranges.push_back(
        {{"first", range.first_frame}, {"last", range.last_frame}, {"room", range.room}});
  }
  return {{"id", walk.stored.id},
          {"name", recording.name},
          {"frames", walk.stored.next_frame_index},
          {"keyframes", walk.keyframes},
          {"finished", walk.stored.finished},
          {"recorded", recorded_json(walk, view)},
          {"camera",
           {{"width", recording.camera.width},
            {"height", recording.camera.height},
            {"fx", recording.camera.fx},
            {"fy", recording.camera.fy},
            {"cx", recording.camera.cx},
            {"cy", recording.camera.cy}}},
          {"ranges", ranges}};
}

Json changes_json(const HomeView& view) {
  if (!view.changes) return nullptr;
  const auto taken = view.walks_taken_away();
  if (taken.contains(view.changes->walk) || taken.contains(view.changes->since)) return nullptr;
  Json things = Json::array();
  for (const ViewedChange& one : view.changes->things) {
    things.push_back({{"what", one.what},
                      {"name", one.name},
                      {"room", or_null(one.room)},
                      {"moved_m", one.moved_m ? Json(*one.moved_m) : Json(nullptr)}});
  }
  return {{"walk", view.changes->walk}, {"since", view.changes->since}, {"things", things}};
}

// Of a home of several storeys.
void add_storeys(const HomeView& view, Json& json) {
  if (!view.map || !view.map->frame.storeys.are_several()) return;
  const fusion::Storeys& storeys = view.map->frame.storeys;
  Json all = Json::array(), flights = Json::array();
  for (std::size_t i = 0; i < storeys.count(); ++i) {
    const fusion::Storey& storey = storeys.all()[i];
    all.push_back({{"from_x", i > 0 ? Json(storey.plan_from_x_m) : Json(nullptr)},
                   {"plan_from_level", json_of(storey.plan_from_gravity)},
                   {"floor_m", storey.floor_m}});
  }
  for (const fusion::Staircase& stairs : storeys.stairs()) {
    const auto room_at = [&](const Eigen::Vector2d& place) {
      return or_null(view.layout ? view.layout->room_at(place) : std::nullopt);
    };
    flights.push_back({{"rooms", {room_at(stairs.below_plan), room_at(stairs.above_plan)}},
                       {"storeys", {stairs.lower, stairs.lower + 1}},
                       {"steps", stairs.steps},
                       {"left_rail", stairs.has_left_rail},
                       {"right_rail", stairs.has_right_rail}});
  }
  json["storeys"] = std::move(all);
  json["stairs"] = std::move(flights);
}

// What goes from the file when the home is closed, or when somebody says so.
Json to_erase_json(const HomeView& view) {
  Json walks = Json::array(), rooms = Json::array();
  for (const ViewedEdit& one : view.edits) {
    const pipeline::EditChange& change = one.edit.change;
    if (change.walk) {
      walks.push_back({{"id", *change.walk}, {"name", change.name}, {"edit", one.edit.id}});
    } else if (one.edit.kind == pipeline::EditKind::kRemoveRoom) {
      rooms.push_back({{"name", change.room}, {"edit", one.edit.id}});
    }
  }
  return {{"walks", std::move(walks)}, {"rooms", std::move(rooms)}, {"owed", view.owes_erasing}};
}

void put_float(float value, Bytes& bytes) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  for (unsigned i = 0; i < 4; ++i) bytes.push_back(static_cast<std::uint8_t>(bits >> (8 * i)));
}

}  // namespace

Json home_json(const HomeView& view, service::Role role) {
  Json json{{"name", view.name},       {"learned", nullptr},
            {"rooms", Json::array()},  {"doorways", Json::array()},
            {"things", Json::array()}, {"room_types", view.room_types}};
  if (!view.learned_network.empty()) {
    const Json report = Json::parse(view.learned_report, nullptr, false);
    std::size_t pictures = 0;
    if (report.is_object()) {
      for (const Json& room : report.value("rooms", Json::array())) {
        pictures += room.value("pictures", std::size_t{0});
      }
    }
    json["learned"] = {{"pictures", pictures}, {"network", view.learned_network}};
  }
  for (const rooms::Room& room : view.rooms) json["rooms"].push_back(room_json(room, view));
  if (view.layout) {
    for (const rooms::Doorway& doorway : view.layout->doorways()) {
      if (doorway.is_stairs) continue;
      json["doorways"].push_back({{"rooms", doorway.rooms},
                                  {"middle", json_of(doorway.middle_plan)},
                                  {"door", doorway.is_door()}});
    }
  }
  for (const guide::KnownThing& thing : view.things) json["things"].push_back(thing_json(thing));
  add_storeys(view, json);
  if (role != service::Role::kHelper) return json;
  json["recordings"] = Json::array();
  const auto taken = view.walks_taken_away();
  for (const ViewedWalk& walk : view.walks) {
    if (!taken.contains(walk.stored.id)) json["recordings"].push_back(walk_json(walk, view));
  }
  json["to_erase"] = to_erase_json(view);
  json["changes"] = changes_json(view);
  return json;
}

Json plan_json(const HomeView& view) {
  Json rooms = Json::array(), doors = Json::array();
  if (view.map && view.map->floor && view.layout) {
    const fusion::FloorGrid& grid = *view.map->floor;
    const auto& extents = view.layout->rooms();
    for (std::size_t i = 0; i < extents.size(); ++i) {
      Json polygons = Json::array();
      for (const auto& polygon :
           geometry::cell_outlines(pipeline::room_cells(grid, *view.layout, i))) {
        Json rings = Json::array({ring_json(polygon.outer, grid)});
        for (const auto& hole : polygon.holes) rings.push_back(ring_json(hole, grid));
        polygons.push_back(std::move(rings));
      }
      rooms.push_back({{"name", extents[i].name}, {"polygons", std::move(polygons)}});
    }
    for (const rooms::Doorway& door : view.layout->doorways()) {
      if (door.is_stairs) continue;
      doors.push_back({{"rooms", door.rooms},
                       {"middle", json_of(door.middle_plan)},
                       {"width_m", door.width_m},
                       {"door", door.is_door()}});
    }
  }
  const double right_rad = view.map ? view.map->right_rad : 0;
  return {{"rooms", std::move(rooms)},
          {"doors", std::move(doors)},
          {"right_degrees", right_rad * 180 / std::numbers::pi}};
}

Json edits_json(const HomeView& view) {
  Json edits = Json::array();
  for (const ViewedEdit& one : view.edits) {
    const pipeline::EditChange& change = one.edit.change;
    edits.push_back({{"edit", one.edit.id},
                     {"what", pipeline::to_string(one.edit.kind)},
                     {"made", one.edit.made_s},
                     {"by", one.edit.made_by},
                     {"name", change.name},
                     {"old_name", change.old_name},
                     {"note", change.note},
                     {"room", change.room},
                     {"other_room", change.other_room},
                     {"type", change.type},
                     {"without_effect", one.without_effect},
                     {"is_final", one.edit.before.empty()},
                     {"undo_first", one.why_not_undone}});
  }
  return {{"edits", std::move(edits)}};
}

Json keyframes_json(const HomeView& view) {
  Json keyframes = Json::array();
  if (view.map && !view.keyframes.empty()) {
    const auto taken = view.walks_taken_away();
    const TimestampNs first_ns = view.keyframes.front().keyframe.timestamp_ns;
    for (const ViewedKeyframe& one : view.keyframes) {
      if (!one.on_map || taken.contains(one.keyframe.recording)) continue;
      const geometry::RigidTransform gravity_from_keyframe =
          view.map->frame.gravity_from_world * one.keyframe.pose.world_from_keyframe;
      const Eigen::Quaterniond& q = gravity_from_keyframe.rotation;
      keyframes.push_back(
          {{"id", one.keyframe.id},
           {"frame", one.keyframe.frame_index},
           {"time_s", static_cast<double>(one.keyframe.timestamp_ns - first_ns) * 1e-9},
           {"position", json_of(gravity_from_keyframe.translation)},
           {"rotation_xyzw", {q.x(), q.y(), q.z(), q.w()}},
           {"room", one.room.empty() ? Json(nullptr) : Json(one.room)},
           {"recording", one.keyframe.recording}});
      const fusion::Storeys& storeys = view.map->frame.storeys;
      if (storeys.are_several()) {
        keyframes.back()["storey"] = storeys.at_height(gravity_from_keyframe.translation.z());
      }
    }
  }
  return {{"keyframes", keyframes}};
}

Bytes cloud_bytes(const geometry::PointCloud& cloud_gravity) {
  Bytes bytes;
  bytes.reserve(16 * cloud_gravity.size());
  for (std::size_t i = 0; i < cloud_gravity.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) put_float(cloud_gravity.points[i][axis], bytes);
    bytes.insert(bytes.end(), {cloud_gravity.colors[i].r, cloud_gravity.colors[i].g,
                               cloud_gravity.colors[i].b, 255});
  }
  return bytes;
}

Json decision_json(const rooms::RoomDecision& decision) {
  Json rooms = Json::array();
  for (const rooms::RoomScore& score : decision.rooms) {
    rooms.push_back({{"room", score.room}, {"probability", score.score}});
  }
  return {{"verdict", to_string(decision.verdict)},
          {"room", decision.rooms.front().room},
          {"probability", decision.rooms.front().score},
          {"known", decision.familiarity},
          {"why", decision.why},
          {"rooms", rooms}};
}

Json recognitions_json(const std::vector<Recognition>& recognitions) {
  Json all = Json::array();
  for (const Recognition& one : recognitions) {
    all.push_back({{"number", one.number},
                   {"device", one.who.device},
                   {"name", one.who.name},
                   {"time", one.time_s},
                   {"verdict", one.seen.room_decision},
                   {"room", one.seen.room},
                   {"probability", one.seen.probability},
                   {"why", one.seen.why}});
  }
  return {{"recognitions", all}};
}

}  // namespace roomwise::live
