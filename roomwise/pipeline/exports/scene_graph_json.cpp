#include "roomwise/pipeline/exports/scene_graph_json.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "roomwise/pipeline/exports/floor_places.h"

namespace roomwise::pipeline {
namespace {

using nlohmann::ordered_json;

// Layers as Spark-DSG numbers them.
constexpr int kObjects = 2, kPlaces = 3, kRooms = 4, kBuildings = 5;
constexpr double kFarthest_m = 1e3;  // where nothing stands: JSON has no infinity
constexpr std::uint32_t kNoLabel = std::numeric_limits<std::uint32_t>::max();

// A node's number: a letter of its layer in the highest byte, a count below.
std::uint64_t node_id(char letter, std::uint64_t count) {
  return std::uint64_t{static_cast<std::uint8_t>(letter)} << 56U | count;
}

ordered_json vector_json(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

ordered_json quaternion_json(const Eigen::Quaterniond& q) {
  return {{"w", q.w()}, {"x", q.x()}, {"y", q.y()}, {"z", q.z()}};
}

ordered_json box_json(const std::string& type, const geometry::OrientedBox& box) {
  return {{"type", type},
          {"dimensions", vector_json(box.size_m)},
          {"world_P_center", vector_json(box.center())},
          {"world_R_center", quaternion_json(box.world_from_box.rotation)}};
}

ordered_json no_box_json() {
  return {{"type", "INVALID"},
          {"dimensions", {0, 0, 0}},
          {"world_P_center", {0, 0, 0}},
          {"world_R_center", quaternion_json(Eigen::Quaterniond::Identity())}};
}

// What nodes of all layers have. A node whose place is not known is not made.
ordered_json semantic_attributes(const std::string& type, const std::string& name,
                                 const Eigen::Vector3d& position, ordered_json box) {
  return {{"type", type},
          {"metadata", ordered_json::object()},
          {"position", vector_json(position)},
          {"last_update_time_ns", 0},
          {"is_active", false},
          {"is_predicted", false},
          {"name", name},
          {"color", {{"r", 160}, {"g", 160}, {"b", 160}, {"a", 255}}},
          {"bounding_box", std::move(box)},
          {"semantic_label", kNoLabel},
          {"semantic_feature", {{"rows", 0}, {"cols", 0}, {"data", ordered_json::array()}}}};
}

ordered_json layer_key(int layer) {
  return {{"layer", layer}, {"partition", 0}};
}

class SceneGraphWriter {
 public:
  explicit SceneGraphWriter(const HomeContents& contents) : contents_(contents) {}

  std::string write() {
    graph_ = {{"SPARK_DSG_header",
               {{"project_name", "main"}, {"version", {{"major", 1}, {"minor", 1}, {"patch", 3}}}}},
              {"directed", false},
              {"multigraph", false},
              {"layer_keys",
               {layer_key(kObjects), layer_key(kPlaces), layer_key(kRooms), layer_key(kBuildings)}},
              {"layer_names",
               {{"OBJECTS", layer_key(kObjects)},
                {"PLACES", layer_key(kPlaces)},
                {"ROOMS", layer_key(kRooms)},
                {"BUILDINGS", layer_key(kBuildings)}}},
              {"metadata", {{"made_by", "roomwise"}, {"frame", "z up, z = 0 the floor, m"}}},
              {"nodes", ordered_json::array()},
              {"edges", ordered_json::array()}};
    add_building();
    if (contents_.layout) add_rooms();
    if (contents_.floor.grid) add_places();
    add_things();
    return graph_.dump(1, ' ', false, ordered_json::error_handler_t::replace) + "\n";
  }

 private:
  void add_node(std::uint64_t id, int layer, ordered_json attributes) {
    graph_["nodes"].push_back(
        {{"id", id}, {"layer", layer}, {"partition", 0}, {"attributes", std::move(attributes)}});
  }
  void add_edge(std::uint64_t source, std::uint64_t target, ordered_json metadata) {
    graph_["edges"].push_back({{"source", source},
                               {"target", target},
                               {"info",
                                {{"type", "EdgeAttributes"},
                                 {"metadata", std::move(metadata)},
                                 {"weighted", false},
                                 {"weight", 1.0}}}});
  }

  // In the middle of all that is known to be in it.
  void add_building() {
    Eigen::AlignedBox3d extent;
    for (const WalkContent& walk : contents_.walks) {
      for (const home::Keyframe& keyframe : walk.keyframes) {
        if (keyframe.pose.component != 0) continue;
        extent.extend(contents_.gravity_from_world() *
                      keyframe.pose.world_from_keyframe.translation);
      }
    }
    const Eigen::Vector3d middle = extent.center();
    add_node(kBuilding, kBuildings,
             semantic_attributes("SemanticNodeAttributes", "home", middle, no_box_json()));
  }

  // Flat, on the floor: how high rooms are is not known.
  [[nodiscard]] geometry::OrientedBox floor_box(std::size_t room) const {
    const fusion::FloorGrid& grid = *contents_.floor.grid;
    Eigen::AlignedBox2d extent;
    for (int row = 0; row < grid.rows(); ++row) {
      for (int column = 0; column < grid.columns(); ++column) {
        if (contents_.layout->room_of_cell(column, row) != room ||
            !contents_.layout->is_floor(column, row)) {
          continue;
        }
        const Eigen::Vector2d middle = grid.cell_middle_m(column, row);
        const Eigen::Vector2d half = Eigen::Vector2d::Constant(grid.cell_m() / 2);
        extent.extend(Eigen::AlignedBox2d(middle - half, middle + half));
      }
    }
    if (extent.isEmpty()) {
      extent = Eigen::AlignedBox2d(contents_.layout->rooms()[room].middle_plan);
    }
    geometry::OrientedBox box;
    box.world_from_box.translation = contents_.place_gravity(extent.center());
    box.size_m << extent.sizes(), 0;
    return box;
  }

  void add_rooms() {
    const auto& extents = contents_.layout->rooms();
    for (std::size_t i = 0; i < extents.size(); ++i) {
      if (extents[i].floor_m2 == 0) continue;
      const std::uint64_t id = node_id('R', rooms_.size());
      rooms_[extents[i].name] = id;
      const Eigen::Vector3d middle = contents_.place_gravity(extents[i].middle_plan);
      ordered_json attributes = semantic_attributes("RoomNodeAttributes", extents[i].name, middle,
                                                    box_json("AABB", floor_box(i)));
      attributes["semantic_class_probabilities"] = ordered_json::object();
      attributes["metadata"] = {{"floor_m2", extents[i].floor_m2}};
      const auto named = std::ranges::find(contents_.rooms, extents[i].name, &rooms::Room::name);
      if (named != contents_.rooms.end() && !named->type.empty()) {
        attributes["metadata"]["type"] = named->type;
      }
      add_node(id, kRooms, std::move(attributes));
      add_edge(kBuilding, id, ordered_json::object());
    }
    add_doors();
  }

  // On the floor; a place's edges lead to those that touch it.
  void add_places() {
    const FloorPlaces found =
        floor_places(*contents_.floor.grid, contents_.layout ? &*contents_.layout : nullptr);
    for (std::size_t i = 0; i < found.places.size(); ++i) {
      const FloorPlace& place = found.places[i];
      ordered_json attributes = semantic_attributes(
          "PlaceNodeAttributes", "", contents_.place_gravity(place.middle_plan), no_box_json());
      attributes["distance"] = std::min(place.clearance_m, kFarthest_m);
      attributes["num_basis_points"] = 0;
      for (const char* unused : {"voxblox_mesh_connections", "pcl_mesh_connections",
                                 "mesh_vertex_labels", "deformation_connections"})
        attributes[unused] = ordered_json::array();
      attributes["real_place"] = true;
      attributes["active_frontier"] = false;
      attributes["frontier_scale"] = {0, 0, 0};
      attributes["orientation"] = quaternion_json(Eigen::Quaterniond::Identity());
      attributes["need_cleanup"] = false;
      attributes["num_frontier_voxels"] = 0;
      attributes["anti_frontier"] = false;
      add_node(node_id('p', i), kPlaces, std::move(attributes));
      if (!place.room) continue;
      const auto room = rooms_.find(contents_.layout->rooms()[*place.room].name);
      if (room != rooms_.end()) add_edge(room->second, node_id('p', i), ordered_json::object());
    }
    for (const auto& [one, other] : found.edges)
      add_edge(node_id('p', one), node_id('p', other), ordered_json::object());
  }

  // What a way between rooms is, as the edge calls its place.
  static const char* way_of(const rooms::Doorway& door) {
    if (door.is_stairs) return "stairs_m";
    return door.is_door() ? "door_m" : "opening_m";  // where rooms are open to each other
  }

  // What is known of a way between rooms, at its middle; of stairs, which the layout draws where
  // they begin.
  ordered_json way_json(const rooms::Doorway& door) const {
    const Eigen::Vector3d middle = contents_.place_gravity(door.middle_plan);
    double width_m = door.width_m;
    ordered_json way;
    way[way_of(door)] = {middle.x(), middle.y()};
    const auto& flights = contents_.storeys().stairs();
    const auto flight = std::ranges::find_if(flights, [&](const fusion::Staircase& one) {
      return door.is_stairs && one.below_plan == door.middle_plan;
    });
    if (flight != flights.end()) {
      width_m = flight->width_m;
      way["top_m"] = {flight->top_gravity.x(), flight->top_gravity.y()};
      way["storeys"] = {flight->lower, flight->lower + 1};
      way["height_m"] = flight->height_m;
      way["steps"] = flight->steps > 0 ? ordered_json(flight->steps) : ordered_json(nullptr);
    }
    way["width_m"] = width_m > 0 ? ordered_json(width_m) : ordered_json(nullptr);
    way["walked"] = door.is_walked;
    return way;
  }

  // Two rooms are joined once, by their widest door.
  void add_doors() {
    std::set<std::array<std::string, 2>> joined;
    for (const rooms::Doorway& door : contents_.layout->doorways()) {
      const auto from = rooms_.find(door.rooms[0]), to = rooms_.find(door.rooms[1]);
      if (from == rooms_.end() || to == rooms_.end() || !joined.insert(door.rooms).second) continue;
      add_edge(from->second, to->second, way_json(door));
    }
  }

  void add_things() {
    std::uint64_t count = 0;
    for (const ThingContent& thing : contents_.things) {
      if (!thing.box_gravity) continue;
      const std::uint64_t id = node_id('O', count++);
      const geometry::OrientedBox& box = *thing.box_gravity;
      ordered_json attributes = semantic_attributes("ObjectNodeAttributes", thing.instance.name,
                                                    box.center(), box_json("OBB", box));
      if (thing.last_seen) attributes["last_update_time_ns"] = stamp(thing.last_seen->time_ns);
      attributes["mesh_connections"] = ordered_json::array();
      attributes["registered"] = false;
      attributes["world_R_object"] = quaternion_json(box.world_from_box.rotation);
      attributes["metadata"] = {
          {"probability", thing.instance.probability},
          {"names", thing.instance.names},
          {"room", thing.room ? ordered_json(*thing.room) : ordered_json(nullptr)}};
      if (thing.first_seen) {
        attributes["metadata"]["first_seen_ns"] = thing.first_seen->time_ns;
        attributes["metadata"]["last_seen_ns"] = thing.last_seen->time_ns;
      }
      add_node(id, kObjects, std::move(attributes));
      if (!thing.room) continue;
      const auto room = rooms_.find(*thing.room);
      if (room != rooms_.end()) add_edge(room->second, id, ordered_json::object());
    }
  }

  // Spark-DSG counts from 0 on.
  static std::uint64_t stamp(TimestampNs time_ns) {
    return time_ns < 0 ? 0 : static_cast<std::uint64_t>(time_ns);
  }

  static inline const std::uint64_t kBuilding = node_id('B', 0);
  const HomeContents& contents_;
  ordered_json graph_;
  std::map<std::string, std::uint64_t> rooms_;  // nodes, by name
};

}  // namespace

std::string scene_graph_json(const HomeContents& contents) {
  return SceneGraphWriter(contents).write();
}

}  // namespace roomwise::pipeline
