#include "laboratory/simulation/home/room_furnisher.h"

#include <algorithm>
#include <cmath>

#include "laboratory/simulation/home/free_space.h"

namespace roomwise::simulation {
namespace {

constexpr double kBetween = 0.02;   // between neighbours
constexpr int kFewestCells = 120;   // of free floor where the person's middle can be
constexpr double kUseReach = 0.35;  // from the person's rim to what is to be reached

Footprint zone_before(const Footprint& footprint, double depth_m) {
  Footprint zone = footprint;
  const Eigen::Vector2d front = facing(footprint.yaw_rad);
  zone.center += front * (footprint.half_size.y() + depth_m / 2);
  zone.half_size.y() = depth_m / 2;
  return zone;
}

Eigen::Vector2d inward_of(const Door& door, const Rectangle& room) {
  const int across = door.opening.along_x ? 1 : 0;
  Eigen::Vector2d inward = Eigen::Vector2d::Zero();
  inward[across] = center(room)[across] > door.opening.center[across] ? 1 : -1;
  return inward;
}

bool is_same_thing(const PlacedObject& a, const PlacedObject& b) {
  return !a.name.empty() && a.name == b.name;
}

bool is_flat(const Footprint& footprint) {
  return footprint.top_m < kCarpetHeight;
}

}  // namespace

std::array<WallSide, 4> sides_of(const Rectangle& room) {
  const Eigen::Vector2d extent = size(room);
  const Eigen::Vector2d x = Eigen::Vector2d::UnitX(), y = Eigen::Vector2d::UnitY();
  return {WallSide{room.min, y, x, extent.y()},
          WallSide{{room.min.x(), room.max.y()}, x, -y, extent.x()},
          WallSide{room.max, -y, -x, extent.y()},
          WallSide{{room.max.x(), room.min.y()}, -x, y, extent.x()}};
}

RoomFurnisher::RoomFurnisher(HomeModel& home, std::size_t room,
                             std::span<const FurnitureModel> models, RandomStream random)
    : home_(home), room_(room), models_(models), random_(random) {
  const double thickness = home.wall_thickness_m;
  for (const Door& door : home.doors) {
    if (door.room != room && door.other_room != room) continue;
    door_zones_.push_back(as_footprint(passage_of(door, thickness), 0, door.opening.top_m));
    if (!door.other_room) continue;
    if (const auto swing = swing_of(door, thickness)) {
      door_zones_.push_back(as_footprint(*swing, 0, door.opening.top_m));
    }
  }
  for (const Window& window : home.windows) {
    if (window.room != room) continue;
    for (const Footprint& curtain : curtains_of(window, thickness)) curtains_.push_back(curtain);
  }
}

std::size_t RoomFurnisher::count(std::string_view kind) const {
  return static_cast<std::size_t>(std::ranges::count_if(home_.objects, [&](const auto& object) {
    return object.room == room_ && object.kind == kind;
  }));
}

std::vector<const FurnitureModel*> RoomFurnisher::choose(const FurnitureRule& rule) {
  std::vector<const FurnitureModel*> chosen;
  for (const FurnitureModel& model : models_) {
    if (model.kind == rule.kind && model.size_m.x() <= rule.max_width_m &&
        model.size_m.y() >= rule.min_depth_m && model.size_m.z() <= rule.max_height_m) {
      chosen.push_back(&model);
    }
  }
  std::shuffle(chosen.begin(), chosen.end(), random_);
  return chosen;
}

std::vector<const FurnitureModel*> RoomFurnisher::choose(std::string_view kind, double max_width_m,
                                                         double max_height_m) {
  return choose({.kind = kind,
                 .placing = Placing::kAgainstWall,
                 .max_width_m = max_width_m,
                 .max_height_m = max_height_m});
}

void RoomFurnisher::follow(const FurnitureRule& rule) {
  if (area_m2(room().interior) < rule.min_room_m2) return;
  if (!rule.unless.empty() && count(rule.unless) > 0) return;
  const std::size_t before = count(rule.kind);
  const FurnitureModel* same = nullptr;  // chairs of one table are alike
  for (std::size_t i = before; i < static_cast<std::size_t>(rule.most); ++i) {
    if (random_.uniform() >= rule.chance) continue;
    if (same != nullptr && rule.placing != Placing::kOnTop) {
      if (!place(rule, *same)) return;
      continue;
    }
    for (const FurnitureModel* model : choose(rule)) {
      if (!place(rule, *model)) continue;
      same = model;
      break;
    }
    if (same == nullptr) return;
  }
}

PlacedObject RoomFurnisher::make(const FurnitureModel& model, const Eigen::Vector3d& bottom,
                                 double yaw_rad) const {
  PlacedObject object;
  object.kind = model.kind;
  object.model = model.id;
  object.room = room_;
  object.world_from_object = upright_pose(bottom, yaw_rad);
  object.size_m = model.size_m;
  object.is_small = is_small_kind(model.kind);
  object.is_movable = is_movable_kind(model.kind);
  return object;
}

PlacedObject RoomFurnisher::against(const FurnitureModel& model, const WallSide& side,
                                    double along_m) const {
  const double gap = model.elevation_m > 0 ? kHangingWallGap : kStandingWallGap;
  const Eigen::Vector2d middle =
      side.from + side.along * along_m + side.inward * (gap + model.size_m.y() / 2);
  return make(model, {middle.x(), middle.y(), model.elevation_m}, yaw_facing(side.inward));
}

bool RoomFurnisher::covers_window(const Footprint& footprint) const {
  return std::ranges::any_of(home_.windows, [&](const Window& window) {
    if (window.room != room_ || footprint.top_m <= window.opening.bottom_m + 0.02) return false;
    Footprint light = as_footprint(hole_of(window.opening, home_.wall_thickness_m + 0.5),
                                   window.opening.bottom_m, window.opening.top_m);
    return overlap_on_floor(footprint, light, 0);
  });
}

bool RoomFurnisher::touches_curtain(const Footprint& footprint) const {
  return std::ranges::any_of(curtains_, [&](const Footprint& curtain) {
    return bodies_overlap(footprint, curtain, 1e-6);
  });
}

bool RoomFurnisher::touches_anything(const PlacedObject& object) const {
  const Footprint footprint = footprint_of(object).grown(kBetween / 2);
  for (std::size_t i = 0; i < home_.objects.size(); ++i) {
    if (home_.objects[i].room != room_ || object.stands_on == i) continue;
    if (is_same_thing(object, home_.objects[i])) continue;
    const Footprint other = footprint_of(home_.objects[i]).grown(kBetween / 2);
    if (is_flat(other) || is_flat(footprint)) continue;
    if (bodies_overlap(footprint, other, 1e-6)) return true;
  }
  return false;
}

bool RoomFurnisher::fits(const PlacedObject& object, double front_m) const {
  const Footprint footprint = footprint_of(object);
  if (!contains(room().interior, footprint) || footprint.top_m > home_.ceiling_height_m) {
    return false;
  }
  if (touches_anything(object)) return false;
  if (object.stands_on) return true;
  if (covers_window(footprint)) return false;
  if (touches_curtain(footprint)) return false;
  for (const Footprint& zone : door_zones_) {
    if (overlap_on_floor(footprint, zone, 1e-6)) return false;
  }
  if (is_flat(footprint)) return true;
  for (const AccessZone& access : access_zones_) {
    if (anchor_ != access.owner && overlap_on_floor(footprint, access.zone, 1e-6)) return false;
  }
  if (front_m > 0) {
    const Footprint zone = zone_before(footprint, front_m);
    if (!contains(room().interior, zone)) return false;
    for (const PlacedObject& other : home_.objects) {
      const Footprint solid = footprint_of(other);
      if (other.room == room_ && !other.stands_on && !is_flat(solid) &&
          overlap_on_floor(zone, solid, 1e-6)) {
        return false;
      }
    }
  }
  return true;
}

bool RoomFurnisher::keeps_ways_free(const PlacedObject& object) const {
  std::vector<Rectangle> floors{room().interior};
  std::vector<Eigen::Vector2d> goals;
  std::vector<Footprint> obstacles, to_reach;
  for (const Door& door : home_.doors) {
    if (door.room != room_ && door.other_room != room_) continue;
    if (!door.other_room) {
      const Eigen::Vector2d inward = inward_of(door, room().interior);
      goals.push_back(door.opening.center + 0.5 * inward);
    } else {
      floors.push_back(passage_of(door, home_.wall_thickness_m));
      goals.push_back(door.opening.center);
      if (const auto leaf = leaf_of(door, home_.wall_thickness_m)) obstacles.push_back(*leaf);
    }
  }
  if (goals.empty()) return true;
  const auto consider = [&](const PlacedObject& other) {
    const Footprint footprint = footprint_of(other);
    if (!other.stands_on && !is_flat(footprint) && footprint.bottom_m < kBodyFromHeight) {
      to_reach.push_back(footprint);
    }
    if (footprint.top_m <= kBodyFromHeight || footprint.bottom_m >= kBodyToHeight) return;
    obstacles.push_back(footprint);
  };
  for (const PlacedObject& other : home_.objects) {
    if (other.room == room_ && !is_same_thing(other, object)) consider(other);
  }
  consider(object);
  obstacles.insert(obstacles.end(), curtains_.begin(), curtains_.end());
  const FreeSpace space(floors, obstacles);
  const std::vector<bool> reached = space.reachable_from(goals.front(), kWalkingRadius);
  std::vector<double> nearest(to_reach.size(), 1e9);
  std::vector<double> nearest_goal(goals.size(), 1e9);
  int free_cells = 0;
  for (int row = 0; row < space.rows(); ++row) {
    for (int column = 0; column < space.columns(); ++column) {
      if (!reached[static_cast<std::size_t>(row * space.columns() + column)]) continue;
      const Eigen::Vector2d place = space.cell_center(column, row);
      if (contains(room().interior, place)) ++free_cells;
      for (std::size_t i = 0; i < to_reach.size(); ++i) {
        nearest[i] = std::min(nearest[i], to_reach[i].distance_m(place));
      }
      for (std::size_t i = 0; i < goals.size(); ++i) {
        nearest_goal[i] = std::min(nearest_goal[i], (goals[i] - place).norm());
      }
    }
  }
  return free_cells >= kFewestCells && std::ranges::max(nearest_goal) < 2 * FreeSpace::kCellSize &&
         std::ranges::all_of(nearest,
                             [](double distance) { return distance < kWalkingRadius + kUseReach; });
}

void RoomFurnisher::add(PlacedObject object, double front_m) {
  if (front_m > 0) {
    access_zones_.push_back({home_.objects.size(), zone_before(footprint_of(object), front_m)});
  }
  home_.objects.push_back(std::move(object));
}

bool RoomFurnisher::may_stand(const PlacedObject& object, double front_m) const {
  if (!fits(object, front_m)) return false;
  const bool in_the_way = !object.stands_on && !is_flat(footprint_of(object));
  return !in_the_way || keeps_ways_free(object);
}

std::optional<PlacedObject> RoomFurnisher::place_on(const FurnitureModel& model,
                                                    std::size_t carrier, const std::string& name) {
  std::vector<Candidate> options;
  on_top(model, carrier, options);
  for (Candidate& option : options) {
    option.object.name = name;
    if (fits(option.object, 0)) return std::move(option.object);
  }
  return std::nullopt;
}

bool RoomFurnisher::try_add(PlacedObject object, double front_m) {
  if (!may_stand(object, front_m)) return false;
  add(std::move(object), front_m);
  return true;
}

std::vector<std::size_t> RoomFurnisher::anchors_of(const FurnitureRule& rule) const {
  std::vector<std::size_t> anchors;
  for (std::size_t i = 0; i < home_.objects.size(); ++i) {
    const PlacedObject& object = home_.objects[i];
    if (object.room == room_ &&
        std::ranges::find(rule.anchors, object.kind) != rule.anchors.end()) {
      anchors.push_back(i);
    }
  }
  return anchors;
}

bool RoomFurnisher::place(const FurnitureRule& rule, const FurnitureModel& model) {
  // Folded towels and the like are no floor covering.
  const bool may_be_flat = rule.placing == Placing::kOnFloor || rule.placing == Placing::kOnTop;
  if (!may_be_flat && model.elevation_m + model.size_m.z() < kCarpetHeight) return false;
  const bool has_anchor = !rule.anchors.front().empty();
  std::vector<std::size_t> anchors = anchors_of(rule);
  if (has_anchor && anchors.empty()) return false;
  std::shuffle(anchors.begin(), anchors.end(), random_);
  if (!has_anchor) anchors.push_back(home_.objects.size());  // none
  for (const std::size_t anchor : anchors) {
    anchor_ = has_anchor ? std::optional(anchor) : std::nullopt;
    std::vector<Candidate> options = candidates(rule, model);
    std::ranges::stable_sort(options, std::ranges::greater{}, &Candidate::score);
    constexpr int kMaxWayChecks = 12;
    int way_checks = 0;
    const double front_m = rule.placing == Placing::kInMiddle ? 0 : rule.front_m;
    for (Candidate& option : options) {
      if (rule.placing == Placing::kInMiddle) {
        PlacedObject with_margin = option.object;
        with_margin.size_m.head<2>().array() += 2 * rule.front_m;
        if (touches_anything(with_margin) ||
            !contains(room().interior, footprint_of(with_margin))) {
          continue;
        }
      }
      if (!fits(option.object, front_m)) continue;
      if (++way_checks > kMaxWayChecks) break;
      if (try_add(std::move(option.object), front_m)) return true;
    }
  }
  return false;
}

}  // namespace roomwise::simulation
