#include "laboratory/simulation/home/floor_layout.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "laboratory/simulation/home/home_geometry.h"
#include "roomwise/base/random.h"

namespace roomwise::simulation {
namespace {

// Plausible sizes, between the middle planes of walls.
struct RoomSize {
  double min_area_m2, max_area_m2, min_side_m, max_aspect;
};

RoomSize size_of(RoomKind kind) {
  switch (kind) {
    case RoomKind::kBedroom:
      return {10.5, 19, 2.9, 1.8};
    case RoomKind::kKitchen:
      return {8.5, 15, 2.5, 1.9};
    case RoomKind::kToilet:
      return {4.4, 7.4, 1.75, 2.4};
    case RoomKind::kLivingRoom:
      return {17, 30, 3.6, 1.8};
    case RoomKind::kDiningRoom:
      return {11, 17, 3.0, 1.7};
    case RoomKind::kStudy:
      return {8, 13, 2.5, 1.9};
    case RoomKind::kHall:
      break;
  }
  return {4.5, 22, 1.4, 12};
}

bool is_plausible(const LayoutCell& cell) {
  const RoomSize limits = size_of(cell.kind);
  const Eigen::Vector2d sides = size(cell.outline);
  const double area = area_m2(cell.outline);
  return area >= limits.min_area_m2 && area <= limits.max_area_m2 &&
         sides.minCoeff() >= limits.min_side_m &&
         sides.maxCoeff() <= limits.max_aspect * sides.minCoeff();
}

struct Wish {
  RoomKind kind;
  double area_m2;
};

double total_area(const std::vector<Wish>& row) {
  return std::accumulate(row.begin(), row.end(), 0.0,
                         [](double sum, const Wish& wish) { return sum + wish.area_m2; });
}

// Rooms side by side along x, from `from` to `to`.
void add_row(const std::vector<Wish>& row, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
             std::vector<LayoutCell>& cells) {
  const double total = total_area(row);
  double x = from.x();
  for (const Wish& wish : row) {
    const double next = x + (to.x() - from.x()) * wish.area_m2 / total;
    cells.push_back({wish.kind, {{x, from.y()}, {next, to.y()}}});
    x = next;
  }
}

// The whole in its own frame: the hall runs along x, row a below it, row b above it, and perhaps a
// large room that closes the hall's end and reaches over row b.
std::vector<LayoutCell> try_layout(RandomStream& random, std::span<const RoomKind> rooms) {
  std::vector<Wish> a, b;
  std::optional<Wish> end;
  const bool one_sided = rooms.size() <= 4 && random.uniform() < 0.5;
  const bool has_end = rooms.size() >= 5 && random.uniform() < 0.6;
  for (const RoomKind kind : rooms) {
    if (kind == RoomKind::kHall) continue;
    const RoomSize limits = size_of(kind);
    const Wish wish{kind, random.between(limits.min_area_m2, limits.max_area_m2)};
    if (has_end && !end && kind == RoomKind::kLivingRoom) {
      end = wish;
    } else {
      (one_sided || random.uniform() < 0.5 ? a : b).push_back(wish);
    }
  }
  if (a.empty() || (b.empty() && (!one_sided || end))) return {};
  std::shuffle(a.begin(), a.end(), random);
  std::shuffle(b.begin(), b.end(), random);

  const double hall = random.between(1.45, 1.85);
  double depth_a = random.between(2.7, 4.7), depth_b = 0, end_width = 0;
  double length = total_area(a) / depth_a;
  if (end) {
    depth_b = random.between(2.7, 4.4);
    end_width = end->area_m2 / (hall + depth_b);
    length = total_area(b) / depth_b + end_width;
    depth_a = total_area(a) / length;
  } else if (!b.empty()) {
    depth_b = total_area(b) / length;
  }
  if (depth_a < 2.5 || (!b.empty() && depth_b < 2.5)) return {};

  const double hall_end = length - end_width;
  std::vector<LayoutCell> cells;
  cells.push_back({RoomKind::kHall, {{0, depth_a}, {hall_end, depth_a + hall}}});
  add_row(a, {0, 0}, {length, depth_a}, cells);
  add_row(b, {0, depth_a + hall}, {hall_end, depth_a + hall + depth_b}, cells);
  if (end) {
    cells.push_back({end->kind, {{hall_end, depth_a}, {length, depth_a + hall + depth_b}}});
  }
  return cells;
}

// Whether every room touches the hall, or an open-plan neighbour that does.
bool has_ways_in(const std::vector<LayoutCell>& cells, double wall_thickness_m) {
  const auto touches = [&](const LayoutCell& a, const LayoutCell& b, double least) {
    const auto wall = shared_wall(a.outline, b.outline, wall_thickness_m);
    return wall && wall->length() >= least;
  };
  const auto at_hall = [&](const LayoutCell& cell) {
    return std::ranges::any_of(cells, [&](const LayoutCell& other) {
      return other.kind == RoomKind::kHall && touches(cell, other, kDoorWall);
    });
  };
  return std::ranges::all_of(cells, [&](const LayoutCell& cell) {
    if (cell.kind == RoomKind::kHall || at_hall(cell)) return true;
    return std::ranges::any_of(cells, [&](const LayoutCell& other) {
      return may_be_open_plan(cell.kind, other.kind) && at_hall(other) &&
             touches(cell, other, kPassageWall);
    });
  });
}

// Flats lie every way round: turned and mirrored, with a corner in the origin.
void turn(std::vector<LayoutCell>& cells, bool swap_axes, bool mirror_x, bool mirror_y) {
  Eigen::Vector2d extent = Eigen::Vector2d::Zero();
  for (const LayoutCell& cell : cells) extent = extent.cwiseMax(cell.outline.max);
  const auto turned = [&](Eigen::Vector2d point) {
    if (mirror_x) point.x() = extent.x() - point.x();
    if (mirror_y) point.y() = extent.y() - point.y();
    if (swap_axes) std::swap(point.x(), point.y());
    return point;
  };
  for (LayoutCell& cell : cells) {
    const Eigen::Vector2d a = turned(cell.outline.min), b = turned(cell.outline.max);
    cell.outline = {a.cwiseMin(b), a.cwiseMax(b)};
  }
}

}  // namespace

std::optional<std::vector<LayoutCell>> lay_out(std::uint64_t seed, std::span<const RoomKind> rooms,
                                               double wall_thickness_m) {
  constexpr int kTries = 200'000;
  RandomStream random(seed, {0x6c61796f7574});
  for (int i = 0; i < kTries; ++i) {
    std::vector<LayoutCell> cells = try_layout(random, rooms);
    if (cells.empty() || !std::ranges::all_of(cells, is_plausible)) continue;
    if (!has_ways_in(cells, wall_thickness_m)) continue;
    const bool swap_axes = random.uniform() < 0.5;
    const bool mirror_x = random.uniform() < 0.5;
    turn(cells, swap_axes, mirror_x, random.uniform() < 0.5);
    return cells;
  }
  return std::nullopt;
}

std::optional<SharedWall> shared_wall(const Rectangle& a, const Rectangle& b,
                                      double wall_thickness_m) {
  constexpr double kSame = 1e-9;
  for (const int across : {0, 1}) {
    const int along = 1 - across;
    const bool touch = std::abs(a.max[across] - b.min[across]) < kSame ||
                       std::abs(b.max[across] - a.min[across]) < kSame;
    const double from = std::max(a.min[along], b.min[along]) + wall_thickness_m / 2;
    const double to = std::min(a.max[along], b.max[along]) - wall_thickness_m / 2;
    if (!touch || to <= from) continue;
    const double at =
        std::abs(a.max[across] - b.min[across]) < kSame ? a.max[across] : a.min[across];
    return SharedWall{along == 0, at, from, to};
  }
  return std::nullopt;
}

bool may_be_open_plan(RoomKind a, RoomKind b) {
  const auto is_common = [](RoomKind kind) {
    return kind == RoomKind::kLivingRoom || kind == RoomKind::kDiningRoom ||
           kind == RoomKind::kKitchen;
  };
  return is_common(a) && is_common(b) && a != b;
}

}  // namespace roomwise::simulation
