#include "laboratory/simulation/home/floor_openings.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "laboratory/simulation/home/home_geometry.h"
#include "roomwise/base/random.h"

namespace roomwise::simulation {
namespace {

constexpr double kDoorWidth = 0.9;
constexpr double kFrame = 0.12;  // between a door and the wall that crosses beside it
constexpr Rgb8 kDoorColors[] = {{238, 236, 230}, {168, 122, 78}, {206, 178, 138}, {226, 228, 230}};
constexpr Rgb8 kFrontDoorColors[] = {{118, 78, 50}, {88, 100, 112}, {122, 48, 42}};

Eigen::Vector2d point_on(const SharedWall& wall, double along) {
  return wall.along_x ? Eigen::Vector2d(along, wall.across) : Eigen::Vector2d(wall.across, along);
}

// Whether a cell lies on the side of the wall where the coordinate across it grows.
bool lies_beyond(const Rectangle& cell, const SharedWall& wall) {
  return center(cell)[wall.along_x ? 1 : 0] > wall.across;
}

// The parts of a cell's outline that lie on the outline of the whole flat.
std::vector<SharedWall> outside_walls(const Rectangle& cell, const Rectangle& flat,
                                      double wall_thickness_m) {
  std::vector<SharedWall> walls;
  for (const int across : {0, 1}) {
    const int along = 1 - across;
    const double from = cell.min[along] + wall_thickness_m / 2;
    const double to = cell.max[along] - wall_thickness_m / 2;
    if (std::abs(cell.min[across] - flat.min[across]) < 1e-9) {
      walls.push_back({along == 0, cell.min[across], from, to});
    }
    if (std::abs(cell.max[across] - flat.max[across]) < 1e-9) {
      walls.push_back({along == 0, cell.max[across], from, to});
    }
  }
  return walls;
}

class OpeningsBuilder {
 public:
  OpeningsBuilder(std::uint64_t seed, std::span<const LayoutCell> cells, HomeModel& home)
      : seed_(seed), cells_(cells), home_(home), random_(seed, {0x646f6f7273}) {
    flat_ = cells.front().outline;
    for (const LayoutCell& cell : cells) {
      flat_.min = flat_.min.cwiseMin(cell.outline.min);
      flat_.max = flat_.max.cwiseMax(cell.outline.max);
    }
    door_color_ = kDoorColors[random_.index(std::size(kDoorColors))];
  }

  void build() {
    add_front_door();
    // Passages first: a leaf must not stand before one.
    for_neighbours([&](std::size_t i, std::size_t j, const SharedWall& wall) {
      if (i < j && may_be_open_plan(cells_[i].kind, cells_[j].kind) &&
          wall.length() >= kPassageWall) {
        add_passage(i, j, wall);
      }
    });
    for_neighbours([&](std::size_t i, std::size_t j, const SharedWall& wall) {
      if (cells_[i].kind == RoomKind::kHall && wall.length() >= kDoorWall) {
        add_room_door(i, j, wall);
      }
    });
    for (std::size_t i = 0; i < cells_.size(); ++i) add_windows(i);
  }

 private:
  template <typename Body>
  void for_neighbours(const Body& body) {
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      for (std::size_t j = 0; j < cells_.size(); ++j) {
        if (i == j) continue;
        const auto wall = shared_wall(cells_[i].outline, cells_[j].outline, home_.wall_thickness_m);
        if (wall) body(i, j, *wall);
      }
    }
  }

  void add_front_door() {
    const std::size_t hall = hall_index();
    auto walls = outside_walls(cells_[hall].outline, flat_, home_.wall_thickness_m);
    // At an end of the hall: its long walls are for the rooms.
    const auto wall = std::ranges::min_element(walls, {}, &SharedWall::length);
    if (wall == walls.end()) return;
    Door door;
    door.opening.center = point_on(*wall, (wall->from + wall->to) / 2);
    door.opening.along_x = wall->along_x;
    door.opening.width_m = kDoorWidth;
    door.room = hall;
    door.hinge_at_min = random_.uniform() < 0.5;
    door.opens_to_positive = lies_beyond(cells_[hall].outline, *wall);
    door.open_rad = 0;
    door.color = kFrontDoorColors[random_.index(std::size(kFrontDoorColors))];
    home_.doors.push_back(door);
  }

  [[nodiscard]] std::size_t hall_index() const {
    const auto hall = std::ranges::find(cells_, RoomKind::kHall, &LayoutCell::kind);
    return static_cast<std::size_t>(hall - cells_.begin());
  }

  // Into the room, in a corner of it, so that the leaf rests at a wall and furniture has room.
  void add_room_door(std::size_t hall, std::size_t room, const SharedWall& wall) {
    Door door;
    door.opening.along_x = wall.along_x;
    door.opening.width_m = kDoorWidth;
    door.room = room;
    door.other_room = hall;
    door.opens_to_positive = lies_beyond(cells_[room].outline, wall);
    door.hinge_at_min = random_.uniform() < 0.5;
    door.open_rad = 1.45 + 0.12 * random_.uniform();
    door.color = door_color_;
    door.has_leaf = cells_[room].kind != RoomKind::kLivingRoom || random_.uniform() < 0.5;
    const double from = wall.from + kFrame + kDoorWidth / 2;
    const double to = wall.to - kFrame - kDoorWidth / 2;
    const auto hang = [&](bool at_min) {
      door.hinge_at_min = at_min;
      door.opening.center = point_on(wall, at_min ? from : to);
    };
    hang(door.hinge_at_min);
    if (door.has_leaf && leaf_is_in_the_way(door)) hang(!door.hinge_at_min);
    if (door.has_leaf && leaf_is_in_the_way(door)) door.has_leaf = false;
    home_.doors.push_back(door);
  }

  [[nodiscard]] bool leaf_is_in_the_way(const Door& door) const {
    const Footprint swing = as_footprint(*swing_of(door, home_.wall_thickness_m), 0, 2);
    return std::ranges::any_of(home_.doors, [&](const Door& other) {
      if (other.room != door.room && other.other_room != door.room) return false;
      const Footprint passage = as_footprint(passage_of(other, home_.wall_thickness_m), 0, 2);
      return overlap_on_floor(swing, passage, 1e-6);
    });
  }

  void add_passage(std::size_t a, std::size_t b, const SharedWall& wall) {
    const bool is_only_way = !touches_hall(a) || !touches_hall(b);
    if (!is_only_way && random_.uniform() < 0.25) return;
    Door door;
    door.opening.along_x = wall.along_x;
    door.opening.width_m = std::min(wall.length() - 0.5, 1.0 + 0.9 * random_.uniform());
    door.opening.top_m = 2.15;
    const double slack = (wall.length() - door.opening.width_m) / 2 - 0.2;
    door.opening.center =
        point_on(wall, (wall.from + wall.to) / 2 + slack * (2 * random_.uniform() - 1));
    door.room = a;
    door.other_room = b;
    door.has_leaf = false;
    home_.doors.push_back(door);
  }

  [[nodiscard]] bool touches_hall(std::size_t room) const {
    const auto wall =
        shared_wall(cells_[room].outline, cells_[hall_index()].outline, home_.wall_thickness_m);
    return wall && wall->length() >= kDoorWall;
  }

  void add_windows(std::size_t room) {
    RandomStream random(seed_, {0x77696e646f77, room});
    auto walls = outside_walls(cells_[room].outline, flat_, home_.wall_thickness_m);
    if (walls.empty()) return;
    const std::size_t main = main_wall(room, walls);
    const bool has_curtains = cells_[room].kind != RoomKind::kToilet &&
                              cells_[room].kind != RoomKind::kKitchen && random.uniform() < 0.7;
    for (std::size_t i = 0; i < walls.size(); ++i) {
      const SharedWall& wall = walls[i];
      if (cells_[room].kind == RoomKind::kHall) {
        // A hall's end takes the front door; its long side may look out.
        if (wall.length() < 3 || random.uniform() < 0.4) continue;
      } else if (i != main && (cells_[room].kind == RoomKind::kToilet || random.uniform() < 0.5)) {
        continue;
      }
      add_windows_in(room, wall, has_curtains, random);
    }
  }

  // Opposite to the hall where that looks out; else the longest.
  [[nodiscard]] std::size_t main_wall(std::size_t room,
                                      const std::vector<SharedWall>& walls) const {
    const Eigen::Vector2d hall = center(cells_[hall_index()].outline);
    std::size_t best = 0;
    double most = -1;
    for (std::size_t i = 0; i < walls.size(); ++i) {
      const int across = walls[i].along_x ? 1 : 0;
      const double away = std::abs(walls[i].across - hall[across]);
      const bool faces_hall = (walls[i].across - center(cells_[room].outline)[across]) *
                                  (walls[i].across - hall[across]) >
                              0;
      const double score = (faces_hall ? 1 : 0) * away + 0.5 * walls[i].length();
      if (score <= most) continue;
      most = score;
      best = i;
    }
    return best;
  }

  void add_windows_in(std::size_t room, const SharedWall& wall, bool has_curtains,
                      RandomStream& random) {
    Window window;
    window.room = room;
    window.opening.along_x = wall.along_x;
    window.has_curtains = has_curtains;
    window.outside_is_positive = !lies_beyond(cells_[room].outline, wall);
    window.opening.bottom_m = 0.85 + 0.1 * random.uniform();
    window.opening.top_m = 2.15 + 0.1 * random.uniform();
    double width = 1.1 + 0.7 * random.uniform();
    if (cells_[room].kind == RoomKind::kToilet) {
      width = 0.6 + 0.2 * random.uniform();
      window.opening.bottom_m = 1.4;
    } else if (cells_[room].kind == RoomKind::kKitchen) {
      window.opening.bottom_m = 1.2;
    }
    window.opening.width_m = std::min(width, wall.length() - 0.6);
    if (window.opening.width_m < 0.5) return;
    const int count = wall.length() > 4.4 && cells_[room].kind != RoomKind::kToilet ? 2 : 1;
    for (int i = 0; i < count; ++i) {
      const double along = wall.from + wall.length() * (i + 0.5) / count;
      window.opening.center = point_on(wall, along);
      home_.windows.push_back(window);
    }
  }

  std::uint64_t seed_;
  std::span<const LayoutCell> cells_;
  HomeModel& home_;
  RandomStream random_;
  Rectangle flat_;
  Rgb8 door_color_;
};

}  // namespace

void add_openings(std::uint64_t seed, std::span<const LayoutCell> cells, HomeModel& home) {
  OpeningsBuilder(seed, cells, home).build();
}

}  // namespace roomwise::simulation
