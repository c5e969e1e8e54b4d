#include "laboratory/simulation/home/home_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <set>

#include "laboratory/simulation/home/free_space.h"
#include "laboratory/simulation/home/home_geometry.h"
#include "laboratory/simulation/home/storeys.h"

namespace roomwise::simulation {
namespace {

constexpr double kTolerance = 0.002;
constexpr double kArmsReach = 0.5;  // beyond the walking person's rim

bool is_flat(const PlacedObject& object) {
  return !object.stands_on && object.size_m.z() < kCarpetHeight;
}

class Checks {
 public:
  explicit Checks(const HomeModel& home) : home_(home) {
    for (const PlacedObject& object : home.objects) footprints_.push_back(footprint_of(object));
  }

  std::vector<std::string> find_faults() {
    check_names();
    for (std::size_t i = 0; i < home_.objects.size(); ++i) {
      check_walls(i);
      check_support(i);
      check_windows(i);
      check_doors(i);
      for (std::size_t j = i + 1; j < home_.objects.size(); ++j) check_pair(i, j);
    }
    check_lights();
    for (std::string& fault : find_unreachable(home_)) faults_.push_back(std::move(fault));
    return std::move(faults_);
  }

 private:
  [[nodiscard]] const std::string& name(std::size_t i) const { return home_.objects[i].name; }

  void check_names() {
    std::set<std::string_view> seen;
    for (const Room& room : home_.rooms) {
      if (!seen.insert(room.name).second) add("two rooms are called '{}'", room.name);
    }
    seen.clear();
    for (const PlacedObject& object : home_.objects) {
      if (!seen.insert(object.name).second) add("two objects are called '{}'", object.name);
    }
  }

  void check_walls(std::size_t i) {
    const PlacedObject& object = home_.objects[i];
    Rectangle room = home_.rooms[object.room].interior;
    room.min.array() -= kTolerance;
    room.max.array() += kTolerance;
    if (!contains(room, footprints_[i])) add("{} stands in a wall", name(i));
    if (footprints_[i].top_m > home_.ceiling_height_m + kTolerance) {
      add("{} goes through the ceiling", name(i));
    }
    if (footprints_[i].bottom_m < -kTolerance) add("{} goes through the floor", name(i));
  }

  // On the floor, on another thing, or at a wall.
  void check_support(std::size_t i) {
    const PlacedObject& object = home_.objects[i];
    const Footprint& footprint = footprints_[i];
    if (object.stands_on) {
      const Footprint& carrier = footprints_[*object.stands_on];
      for (const Eigen::Vector2d& corner : footprint.corners()) {
        if (carrier.distance_m(corner) > kTolerance) {
          add("{} hangs over the edge of {}", name(i), name(*object.stands_on));
          break;
        }
      }
      if (footprint.bottom_m > carrier.top_m + kTolerance) {
        add("{} floats above {}", name(i), name(*object.stands_on));
      }
      if (home_.objects[*object.stands_on].room != object.room) {
        add("{} and {} that carries it are in different rooms", name(i), name(*object.stands_on));
      }
      return;
    }
    if (footprint.bottom_m <= kTolerance) return;
    const Eigen::Vector2d back =
        footprint.center - facing(footprint.yaw_rad) * (footprint.half_size.y() + 0.05);
    if (contains(home_.rooms[object.room].interior, back)) add("{} floats", name(i));
  }

  // Lamps and vases may stand before a window, furniture not.
  void check_windows(std::size_t i) {
    if (home_.objects[i].stands_on) return;
    for (const Window& window : home_.windows) {
      const Footprint light = as_footprint(hole_of(window.opening, home_.wall_thickness_m + 0.3),
                                           window.opening.bottom_m + 0.05, window.opening.top_m);
      if (bodies_overlap(footprints_[i], light, kTolerance)) {
        add("{} stands before a window", name(i));
      }
      for (const Footprint& curtain : curtains_of(window, home_.wall_thickness_m)) {
        const bool touches = bodies_overlap(footprints_[i], curtain, kTolerance);
        if (touches && !is_flat(home_.objects[i])) add("{} stands in a curtain", name(i));
      }
    }
  }

  void check_doors(std::size_t i) {
    if (is_flat(home_.objects[i])) return;
    for (const Door& door : home_.doors) {
      const auto blocks = [&](const Rectangle& zone) {
        return bodies_overlap(footprints_[i], as_footprint(zone, 0, door.opening.top_m),
                              kTolerance);
      };
      if (blocks(passage_of(door, home_.wall_thickness_m))) {
        add("{} stands in the way of a door", name(i));
      }
      const auto swing = swing_of(door, home_.wall_thickness_m);
      if (door.other_room && swing && blocks(*swing)) {
        add("{} stands in a door's swing", name(i));
      }
    }
  }

  void check_pair(std::size_t i, std::size_t j) {
    const PlacedObject &a = home_.objects[i], &b = home_.objects[j];
    if (a.stands_on == j || b.stands_on == i || is_flat(a) || is_flat(b)) return;
    if (bodies_overlap(footprints_[i], footprints_[j], kTolerance)) {
      add("{} is inside {}", name(i), name(j));
    }
  }

  void check_lights() {
    for (const Light& light : home_.lights) {
      const Rectangle& room = home_.rooms[light.room].interior;
      const bool is_inside = contains(room, Eigen::Vector2d(light.position.head<2>())) &&
                             light.position.z() < home_.ceiling_height_m;
      if (!is_inside) add("a light of the {} is outside of it", home_.rooms[light.room].name);
    }
  }

  template <typename... Args>
  void add(fmt::format_string<Args...> format, Args&&... args) {
    faults_.push_back(fmt::format(format, std::forward<Args>(args)...));
  }

  const HomeModel& home_;
  std::vector<Footprint> footprints_;
  std::vector<std::string> faults_;
};

}  // namespace

std::vector<std::string> find_faults(const HomeModel& home) {
  return Checks(home).find_faults();
}

std::vector<std::string> find_unreachable(const HomeModel& home) {
  const FreeSpace space = FreeSpace::of(home);
  // From inside the front door, or where there is none from the first free place.
  const auto front =
      std::ranges::find_if(home.doors, [](const Door& door) { return !door.other_room; });
  const Eigen::Vector2d inside =
      center(home.rooms[front != home.doors.end() ? front->room : std::size_t{0}].interior);
  const auto start = space.nearest_free(front != home.doors.end() ? front->opening.center : inside,
                                        kWalkingRadius);
  if (!start) return {"nobody can stand inside the front door"};
  std::vector<bool> reached = space.reachable_from(*start, kWalkingRadius);
  for (const Staircase& stairs : home.stairs) {
    const auto above = space.reachable_from(place_above(home, stairs), kWalkingRadius);
    std::transform(reached.begin(), reached.end(), above.begin(), reached.begin(),
                   std::logical_or<>());
  }

  std::vector<int> cells(home.rooms.size());
  std::vector<bool> is_near(home.objects.size());
  std::vector<Footprint> footprints;
  for (const PlacedObject& object : home.objects) footprints.push_back(footprint_of(object));
  for (int row = 0; row < space.rows(); ++row) {
    for (int column = 0; column < space.columns(); ++column) {
      if (!reached[static_cast<std::size_t>(row * space.columns() + column)]) continue;
      const Eigen::Vector2d place = space.cell_center(column, row);
      const std::size_t room = room_at(home, place);
      ++cells[room];
      for (std::size_t i = 0; i < footprints.size(); ++i) {
        if (is_near[i] || home.objects[i].room != room) continue;
        is_near[i] = footprints[i].distance_m(place) < kWalkingRadius + kArmsReach;
      }
    }
  }
  std::vector<std::string> faults;
  constexpr int kFewestCells = 100;  // a quarter of a square metre to stand on
  for (std::size_t i = 0; i < home.rooms.size(); ++i) {
    if (cells[i] < kFewestCells)
      faults.push_back(fmt::format("the {} cannot be reached", home.rooms[i].name));
  }
  for (std::size_t i = 0; i < home.objects.size(); ++i) {
    const PlacedObject& object = home.objects[i];
    const bool stands =
        !object.stands_on && !is_flat(object) && footprints[i].bottom_m < kBodyFromHeight;
    if (stands && !is_near[i]) faults.push_back(fmt::format("{} cannot be reached", object.name));
  }
  return faults;
}

}  // namespace roomwise::simulation
