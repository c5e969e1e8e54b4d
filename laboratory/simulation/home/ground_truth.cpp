#include "laboratory/simulation/home/ground_truth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "laboratory/simulation/home/free_space.h"
#include "laboratory/simulation/home/home_geometry.h"
#include "roomwise/base/file.h"

namespace roomwise::simulation {
namespace {

using Json = nlohmann::ordered_json;

// Tenths of a millimetre, so that files stay readable.
double rounded(double value) {
  constexpr double kUnits = 1e4;
  return std::round(value * kUnits) / kUnits;
}

Json point(const Eigen::Vector2d& value) {
  return {rounded(value.x()), rounded(value.y())};
}
Json point(const Eigen::Vector3d& value) {
  return {rounded(value.x()), rounded(value.y()), rounded(value.z())};
}

template <int Size>
Eigen::Matrix<double, Size, 1> read_point(const Json& json) {
  const auto values = json.get<std::array<double, Size>>();
  return Eigen::Map<const Eigen::Matrix<double, Size, 1>>(values.data());
}

// A file's JSON given to `read`; what is missing or of another type becomes an error.
template <typename Value, typename Read>
Expected<Value> read_json(const std::filesystem::path& path, const Read& read) {
  ROOMWISE_TRY(const std::string text, read_text_file(path));
  try {
    return read(Json::parse(text));
  } catch (const Json::exception& error) {
    return fail("{}: is no truth of a simulated recording: {}; simulate it again", path.string(),
                error.what());
  }
}

Json as_json(const ObjectTruth& object) {
  Json seen = Json::array();
  for (const ObjectObservation& observation : object.seen) {
    seen.push_back({observation.frame, observation.pixels, observation.share});
  }
  return {{"name", object.name},
          {"kind", object.kind},
          {"label", object.label},
          {"room", object.room},
          {"center", point(object.center_m)},
          {"size", point(object.size_m)},
          {"yaw_rad", rounded(object.yaw_rad)},
          {"model", object.model},
          {"creator", object.creator},
          {"license", object.license},
          {"seen", std::move(seen)}};
}

ObjectTruth object_from(const Json& json) {
  ObjectTruth object;
  json.at("name").get_to(object.name);
  json.at("kind").get_to(object.kind);
  json.at("label").get_to(object.label);
  json.at("room").get_to(object.room);
  object.center_m = read_point<3>(json.at("center"));
  object.size_m = read_point<3>(json.at("size"));
  json.at("yaw_rad").get_to(object.yaw_rad);
  json.at("model").get_to(object.model);
  json.at("creator").get_to(object.creator);
  json.at("license").get_to(object.license);
  for (const Json& observation : json.at("seen")) {
    object.seen.push_back({observation.at(0).get<std::uint64_t>(),
                           observation.at(1).get<std::uint64_t>(),
                           observation.at(2).get<double>()});
  }
  return object;
}

Json rooms_json(const HomeModel& home) {
  Json rooms = Json::array();
  for (const Room& room : home.rooms) {
    rooms.push_back({{"name", room.name},
                     {"kind", name_of(room.kind)},
                     {"min", point(room.interior.min)},
                     {"max", point(room.interior.max)}});
    if (home.storeys.size() > 1) rooms.back()["storey"] = room.storey;
    if (room.open_floor) {
      rooms.back()["open_floor"] = {{"min", point(room.open_floor->min)},
                                    {"max", point(room.open_floor->max)}};
    }
  }
  return rooms;
}

Json storeys_json(const HomeModel& home) {
  Json storeys = Json::array();
  for (const Storey& storey : home.storeys) {
    storeys.push_back({{"world_from_plan", point(storey.world_from_plan)}});
  }
  return storeys;
}

Json stairs_json(const HomeModel& home) {
  Json all = Json::array();
  for (const Staircase& stairs : home.stairs) {
    Json rails = Json::array();
    if (stairs.has_left_rail) rails.push_back("left");
    if (stairs.has_right_rail) rails.push_back("right");
    all.push_back(
        {{"rooms", {home.rooms[stairs.lower_room].name, home.rooms[stairs.upper_room].name}},
         {"foot", point(stairs.foot)},
         {"up", point(stairs.up)},
         {"width", rounded(stairs.width_m)},
         {"steps", stairs.steps},
         {"rise", rounded(stairs.rise_m)},
         {"going", rounded(stairs.going_m)},
         {"rails", std::move(rails)}});
  }
  return all;
}

Json doors_json(const HomeModel& home) {
  Json doors = Json::array();
  for (const Door& door : home.doors) {
    Json rooms{home.rooms[door.room].name};
    if (door.other_room) rooms.push_back(home.rooms[*door.other_room].name);
    doors.push_back({{"center", point(door.opening.center)},
                     {"along_x", door.opening.along_x},
                     {"width", rounded(door.opening.width_m)},
                     {"top", rounded(door.opening.top_m)},
                     {"rooms", std::move(rooms)},
                     {"has_leaf", door.has_leaf},
                     {"open_rad", rounded(door.open_rad)}});
  }
  return doors;
}

Json windows_json(const HomeModel& home) {
  Json windows = Json::array();
  for (const Window& window : home.windows) {
    windows.push_back({{"center", point(window.opening.center)},
                       {"along_x", window.opening.along_x},
                       {"width", rounded(window.opening.width_m)},
                       {"bottom", rounded(window.opening.bottom_m)},
                       {"top", rounded(window.opening.top_m)},
                       {"room", home.rooms[window.room].name}});
  }
  return windows;
}

Json free_space_json(const HomeModel& home) {
  const FreeSpace space = FreeSpace::of(home);
  Json rows = Json::array();
  for (int row = 0; row < space.rows(); ++row) {
    std::string cells;
    for (int column = 0; column < space.columns(); ++column) {
      cells += space.clearance_m(column, row) >= kPersonRadius ? '.' : '#';
    }
    rows.push_back(std::move(cells));
  }
  return {{"origin", point(space.origin())},
          {"cell", FreeSpace::kCellSize},
          {"person_radius", kPersonRadius},
          {"rows", std::move(rows)}};
}

class FloorPlanReader {
 public:
  explicit FloorPlanReader(const Json& json) : json_(json) {}

  Expected<FloorPlanTruth> read() {
    json_.at("ceiling_height").get_to(plan_.ceiling_height_m);
    json_.at("wall_thickness").get_to(plan_.wall_thickness_m);
    ROOMWISE_RETURN_IF_ERROR(read_rooms());
    ROOMWISE_RETURN_IF_ERROR(read_storeys());
    for (const Json& wall : json_.at("walls")) {
      plan_.walls.push_back({read_point<2>(wall.at("from")), read_point<2>(wall.at("to"))});
    }
    ROOMWISE_RETURN_IF_ERROR(read_doors());
    ROOMWISE_RETURN_IF_ERROR(read_windows());
    const Json& space = json_.at("free_space");
    plan_.free_space = {read_point<2>(space.at("origin")), space.at("cell").get<double>(),
                        space.at("person_radius").get<double>(),
                        space.at("rows").get<std::vector<std::string>>()};
    return std::move(plan_);
  }

 private:
  Expected<void> read_rooms() {
    for (const Json& json : json_.at("rooms")) {
      Room room;
      json.at("name").get_to(room.name);
      ROOMWISE_TRY(room.kind, parse_room_kind(json.at("kind").get<std::string>()));
      room.interior = {read_point<2>(json.at("min")), read_point<2>(json.at("max"))};
      room.storey = json.value("storey", std::size_t{0});
      if (json.contains("open_floor")) {
        const Json& open = json.at("open_floor");
        room.open_floor = {read_point<2>(open.at("min")), read_point<2>(open.at("max"))};
      }
      plan_.rooms.push_back(std::move(room));
    }
    return {};
  }

  // Truths that were written before homes had several have none.
  Expected<void> read_storeys() {
    if (!json_.contains("storeys")) return {};
    plan_.storeys.clear();
    for (const Json& json : json_.at("storeys")) {
      plan_.storeys.push_back({read_point<3>(json.at("world_from_plan"))});
    }
    for (const Room& room : plan_.rooms) {
      if (room.storey >= plan_.storeys.size()) return fail("'{}' is on no storey", room.name);
    }
    for (const Json& json : json_.at("stairs")) {
      Staircase stairs;
      ROOMWISE_TRY(stairs.lower_room, room_called(json.at("rooms").at(0)));
      ROOMWISE_TRY(stairs.upper_room, room_called(json.at("rooms").at(1)));
      stairs.foot = read_point<2>(json.at("foot"));
      stairs.up = read_point<2>(json.at("up"));
      json.at("width").get_to(stairs.width_m);
      json.at("steps").get_to(stairs.steps);
      json.at("rise").get_to(stairs.rise_m);
      json.at("going").get_to(stairs.going_m);
      for (const Json& rail : json.at("rails")) {
        (rail == "left" ? stairs.has_left_rail : stairs.has_right_rail) = true;
      }
      plan_.stairs.push_back(stairs);
    }
    return {};
  }

  Expected<std::size_t> room_called(const Json& json) const {
    const auto name = json.get<std::string>();
    const auto room = std::ranges::find(plan_.rooms, name, &Room::name);
    if (room == plan_.rooms.end()) return fail("no room is called '{}'", name);
    return static_cast<std::size_t>(room - plan_.rooms.begin());
  }

  static WallOpening opening_from(const Json& json) {
    WallOpening opening;
    opening.center = read_point<2>(json.at("center"));
    json.at("along_x").get_to(opening.along_x);
    json.at("width").get_to(opening.width_m);
    json.at("top").get_to(opening.top_m);
    return opening;
  }

  Expected<void> read_doors() {
    for (const Json& json : json_.at("doors")) {
      Door door;
      door.opening = opening_from(json);
      const Json& rooms = json.at("rooms");
      ROOMWISE_TRY(door.room, room_called(rooms.at(0)));
      if (rooms.size() > 1) {
        ROOMWISE_TRY(door.other_room, room_called(rooms.at(1)));
      }
      json.at("has_leaf").get_to(door.has_leaf);
      json.at("open_rad").get_to(door.open_rad);
      plan_.doors.push_back(door);
    }
    return {};
  }

  Expected<void> read_windows() {
    for (const Json& json : json_.at("windows")) {
      Window window;
      window.opening = opening_from(json);
      json.at("bottom").get_to(window.opening.bottom_m);
      ROOMWISE_TRY(window.room, room_called(json.at("room")));
      plan_.windows.push_back(window);
    }
    return {};
  }

  const Json& json_;
  FloorPlanTruth plan_;
};

// What people call a kind of the catalogue.
std::string label_of(std::string kind) {
  if (kind == "toilet") return "toilet seat";  // as the paper's database has it
  if (kind == "floor_lamp") return "lamp";
  std::ranges::replace(kind, '_', ' ');
  return kind;
}

}  // namespace

void ObservationCounter::add(std::uint64_t frame, const image::Image<std::uint16_t>& object_image) {
  std::vector<std::uint64_t> pixels(seen_.size());
  for (const std::uint16_t index : object_image.pixels()) {
    if (index > 0 && index <= pixels.size()) ++pixels[index - 1U];
  }
  const auto all = static_cast<double>(object_image.pixels().size());
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (pixels[i] == 0) continue;
    seen_[i].push_back({frame, pixels[i], static_cast<double>(pixels[i]) / all});
  }
}

std::vector<ObjectObservation> ObservationCounter::of(std::size_t object) const {
  std::vector<ObjectObservation> seen = seen_[object];
  std::ranges::sort(seen, {}, &ObjectObservation::frame);
  return seen;
}

std::vector<ObjectTruth> objects_truth(const HomeModel& home,
                                       std::span<const FurnitureModel> models,
                                       const ObservationCounter& observations) {
  std::vector<ObjectTruth> objects;
  for (std::size_t i = 0; i < home.objects.size(); ++i) {
    const PlacedObject& placed = home.objects[i];
    ObjectTruth object;
    object.name = placed.name;
    object.kind = placed.kind;
    object.label = label_of(placed.kind);
    object.room = home.rooms[placed.room].name;
    object.center_m = placed.world_from_object * Eigen::Vector3d(0, 0, placed.size_m.z() / 2);
    object.size_m = placed.size_m;
    object.yaw_rad = yaw_of(placed.world_from_object);
    object.model = placed.model;
    const auto model = std::ranges::find(models, placed.model, &FurnitureModel::id);
    if (model != models.end()) {
      object.creator = model->creator;
      object.license = model->license;
    }
    object.seen = observations.of(i);
    objects.push_back(std::move(object));
  }
  return objects;
}

Expected<void> write_objects_truth(const std::filesystem::path& path,
                                   std::span<const ObjectTruth> objects) {
  std::string text = "{\"objects\": [";
  for (std::size_t i = 0; i < objects.size(); ++i) {
    text += i == 0 ? "\n" : ",\n";
    text += as_json(objects[i]).dump();
  }
  return write_file(path, text + "\n]}\n");
}

Expected<std::vector<ObjectTruth>> read_objects_truth(const std::filesystem::path& path) {
  return read_json<std::vector<ObjectTruth>>(path, [](const Json& json) {
    std::vector<ObjectTruth> objects;
    for (const Json& object : json.at("objects")) objects.push_back(object_from(object));
    return objects;
  });
}

Eigen::Vector2d FloorPlanTruth::plan_from_world(const Eigen::Vector3d& place_world) const {
  constexpr double kSag_m = 0.2;  // what was measured may lie a little lower than its floor
  std::size_t storey = 0;
  for (std::size_t i = 1; i < storeys.size(); ++i) {
    if (place_world.z() > storeys[i].world_from_plan.z() - kSag_m) storey = i;
  }
  return (place_world - storeys[storey].world_from_plan).head<2>();
}

Eigen::Vector3d FloorPlanTruth::world_from_plan(const Eigen::Vector2d& place_plan) const {
  std::size_t storey = 0;
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const Room& room : rooms) {
    const double distance_m = as_footprint(room.interior, 0, 0).distance_m(place_plan);
    if (distance_m >= nearest_m) continue;
    nearest_m = distance_m;
    storey = room.storey;
  }
  return Eigen::Vector3d(place_plan.x(), place_plan.y(), 0) + storeys[storey].world_from_plan;
}

std::vector<WallSegment> walls_of(const HomeModel& home) {
  // The sides of all rooms by the line on which they lie, in tenths of millimetres; those that
  // touch or overlap are one wall.
  std::map<std::pair<int, std::int64_t>, std::vector<std::pair<double, double>>> lines;
  for (const Room& room : home.rooms) {
    const Eigen::Array2d min = room.interior.min.array() - home.wall_thickness_m / 2;
    const Eigen::Array2d max = room.interior.max.array() + home.wall_thickness_m / 2;
    for (const int along : {0, 1}) {
      for (const double across : {min[1 - along], max[1 - along]}) {
        lines[{along, std::llround(across * 1e4)}].emplace_back(min[along], max[along]);
      }
    }
  }
  std::vector<WallSegment> walls;
  for (auto& [line, pieces] : lines) {
    std::ranges::sort(pieces);
    const auto [along, place] = line;
    const auto point_at = [&](double position) {
      const double across = static_cast<double>(place) * 1e-4;
      return along == 0 ? Eigen::Vector2d(position, across) : Eigen::Vector2d(across, position);
    };
    double from = pieces.front().first, to = pieces.front().second;
    for (const auto& [next_from, next_to] : pieces) {
      constexpr double kTouch = 1e-3;
      if (next_from > to + kTouch) {
        walls.push_back({point_at(from), point_at(to)});
        from = next_from;
      }
      to = std::max(to, next_to);
    }
    walls.push_back({point_at(from), point_at(to)});
  }
  return walls;
}

Expected<void> write_floor_plan(const std::filesystem::path& path, const HomeModel& home) {
  Json walls = Json::array();
  for (const WallSegment& wall : walls_of(home)) {
    walls.push_back({{"from", point(wall.from)}, {"to", point(wall.to)}});
  }
  Json plan{{"home_seed", home.seed},
            {"scenario", name_of(home.scenario)},
            {"ceiling_height", rounded(home.ceiling_height_m)},
            {"wall_thickness", rounded(home.wall_thickness_m)},
            {"rooms", rooms_json(home)},
            {"walls", std::move(walls)},
            {"doors", doors_json(home)},
            {"windows", windows_json(home)},
            {"free_space", free_space_json(home)}};
  if (home.storeys.size() > 1) {
    plan["storeys"] = storeys_json(home);
    plan["stairs"] = stairs_json(home);
  }
  return write_file(path, plan.dump(1) + "\n");
}

Expected<FloorPlanTruth> read_floor_plan(const std::filesystem::path& path) {
  auto plan = read_json<Expected<FloorPlanTruth>>(
      path, [](const Json& json) { return FloorPlanReader(json).read(); });
  if (!plan) return Unexpected(std::move(plan).error());
  if (!*plan) return Unexpected(std::move(*plan).error().with_context(path.string()));
  return *std::move(*plan);
}

}  // namespace roomwise::simulation
