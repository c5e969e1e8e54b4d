#include "roomwise/rooms/room_layout.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <queue>
#include <set>

#include "roomwise/base/disjoint_sets.h"
#include "roomwise/geometry/distance_transform.h"

namespace roomwise::rooms {
namespace {

using Eigen::Vector2d;
using fusion::FloorCell;
using fusion::FloorGrid;

constexpr std::int16_t kNoRoom = -1;
constexpr double kNowhere = std::numeric_limits<double>::infinity();
constexpr double kMostCells = 1e6;  // along a side: what is farther is a fault
// Who walked there took so much room; between two places farther apart than a step the walk is not
// known.
constexpr double kWalkerRadius_m = 0.25, kLongestStep_m = 1.0;
// Between two places farther apart than that, the walk may have led through another room.
constexpr double kLongestGap_m = 2.0;

struct Cell {
  int column = 0, row = 0;
};
constexpr std::array kSides{Cell{1, 0}, Cell{-1, 0}, Cell{0, 1}, Cell{0, -1}};
using RoomCells = image::Image<std::int16_t>;

// Where the walk goes from one named room into another.
struct Crossing {
  std::int16_t from = kNoRoom, to = kNoRoom;
  Vector2d place = Vector2d::Zero();
};

// A walked place and how far along the path the nearest crossing is.
struct Evidence {
  std::int16_t room = kNoRoom;
  Vector2d place = Vector2d::Zero();
  double from_crossing_m = kNowhere;
};

struct ReadWalks {
  std::vector<std::string> names;  // of the rooms, sorted
  std::vector<Evidence> evidence;  // named places
  std::vector<Crossing> crossings;
};

std::vector<std::string> room_names(std::span<const WalkedPath> walks) {
  std::set<std::string> names;
  for (const WalkedPath& walk : walks) {
    for (const WalkedPlace& place : walk) {
      if (!place.room.empty()) names.insert(place.room);
    }
  }
  return {names.begin(), names.end()};
}

void read_walk(const WalkedPath& walk, ReadWalks& read) {
  std::vector<Evidence> named;
  std::vector<double> along_m, crossings_m;  // along the path
  double length_m = 0;
  const WalkedPlace* before = nullptr;
  bool is_unbroken = true;  // since the last named place
  for (const WalkedPlace& place : walk) {
    if (before != nullptr) length_m += (place.point_level - before->point_level).norm();
    before = &place;
    if (place.room.empty()) {
      is_unbroken = false;
      continue;
    }
    const auto room = static_cast<std::int16_t>(std::ranges::lower_bound(read.names, place.room) -
                                                read.names.begin());
    if (!named.empty() && named.back().room != room) {
      // Where the walk was lost or unnamed in between, there may be other rooms.
      const double gap_m = (place.point_level - named.back().place).norm();
      if (is_unbroken && gap_m <= kLongestGap_m) {
        read.crossings.push_back(
            {named.back().room, room, (named.back().place + place.point_level) / 2});
      }
      crossings_m.push_back((along_m.back() + length_m) / 2);
    }
    named.push_back({room, place.point_level, kNowhere});
    is_unbroken = true;
    along_m.push_back(length_m);
  }
  for (std::size_t i = 0; i < named.size(); ++i) {
    for (const double crossing_m : crossings_m) {
      named[i].from_crossing_m =
          std::min(named[i].from_crossing_m, std::abs(along_m[i] - crossing_m));
    }
  }
  read.evidence.insert(read.evidence.end(), named.begin(), named.end());
}

// Free floor: what the map shows, and where somebody walked.
using Floor = image::Image<std::uint8_t>;

Floor free_floor(const FloorGrid& grid, std::span<const WalkedPath> walks) {
  Floor floor(grid.columns(), grid.rows(), 0);
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      floor.at(column, row) = grid.at(column, row) == FloorCell::kFree ? 1 : 0;
    }
  }
  const int reach = static_cast<int>(std::ceil(kWalkerRadius_m / grid.cell_m()));
  const auto stand_at = [&](const Vector2d& place) {
    const Eigen::Array2d at = ((place - grid.origin_m()) / grid.cell_m()).array().floor();
    if (!(at.abs() < kMostCells).all()) return;
    const Cell middle{static_cast<int>(at.x()), static_cast<int>(at.y())};
    for (int row = middle.row - reach; row <= middle.row + reach; ++row) {
      for (int column = middle.column - reach; column <= middle.column + reach; ++column) {
        if (!floor.contains(column, row) || grid.at(column, row) != FloorCell::kUnknown) continue;
        if ((grid.cell_middle_m(column, row) - place).norm() > kWalkerRadius_m) continue;
        floor.at(column, row) = 1;
      }
    }
  };
  for (const WalkedPath& walk : walks) {
    for (std::size_t i = 0; i < walk.size(); ++i) {
      stand_at(walk[i].point_level);
      if (i == 0) continue;
      const Vector2d step = walk[i].point_level - walk[i - 1].point_level;
      if (!(step.norm() <= kLongestStep_m)) continue;
      const int parts = static_cast<int>(std::ceil(step.norm() / grid.cell_m()));
      for (int part = 1; part < parts; ++part) {
        stand_at(walk[i - 1].point_level + step * part / parts);
      }
    }
  }
  return floor;
}

// The nearest free cell within reach.
std::optional<Cell> free_cell_near(const FloorGrid& grid, const Floor& floor, const Vector2d& point,
                                   double reach_m) {
  const Eigen::Array2d at = (point - grid.origin_m()) / grid.cell_m();
  const double reach = reach_m / grid.cell_m();
  if (!(at.abs() < kMostCells).all()) return std::nullopt;
  const auto first = (at - reach).floor().cast<int>().max(0).eval();
  const int last_column =
      std::min(grid.columns() - 1, static_cast<int>(std::floor(at.x() + reach)));
  const int last_row = std::min(grid.rows() - 1, static_cast<int>(std::floor(at.y() + reach)));
  std::optional<Cell> best;
  double best_m = reach_m;
  for (int row = first.y(); row <= last_row; ++row) {
    for (int column = first.x(); column <= last_column; ++column) {
      if (floor.at(column, row) == 0) continue;
      const double distance_m = (grid.cell_middle_m(column, row) - point).norm();
      if (distance_m >= best_m) continue;
      best_m = distance_m;
      best = Cell{column, row};
    }
  }
  return best;
}

// From the middle of each free cell to the nearest that is not free, in cells, by row.
std::vector<double> free_widths(const Floor& floor) {
  // One cell around it: what lies outside is not free.
  const int columns = floor.width() + 2, rows = floor.height() + 2;
  std::vector<double> cells(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), 0);
  for (int row = 0; row < floor.height(); ++row) {
    for (int column = 0; column < floor.width(); ++column) {
      if (floor.at(column, row) == 0) continue;
      cells[static_cast<std::size_t>((row + 1) * columns + column + 1)] = geometry::kFarFromAll;
    }
  }
  const std::vector<double> squared = geometry::squared_distances(std::move(cells), columns, rows);
  std::vector<double> widths;
  for (int row = 0; row < floor.height(); ++row) {
    for (int column = 0; column < floor.width(); ++column) {
      widths.push_back(
          std::sqrt(squared[static_cast<std::size_t>((row + 1) * columns + column + 1)]));
    }
  }
  return widths;
}

// Cells by level, the highest first and of one level those that came first.
class Flood {
 public:
  void push(double level, Cell cell) { queue_.push({level, next_--, cell}); }
  [[nodiscard]] bool empty() const { return queue_.empty(); }
  std::pair<double, Cell> pop() {
    const Entry entry = queue_.top();
    queue_.pop();
    return {entry.level, entry.cell};
  }

 private:
  struct Entry {
    double level;
    std::int64_t order;
    Cell cell;
    bool operator<(const Entry& other) const {
      return level != other.level ? level < other.level : order < other.order;
    }
  };
  std::priority_queue<Entry> queue_;
  std::int64_t next_ = 0;
};

// The places that say for certain whose floor they are on: those far enough from a crossing, or a
// room's farthest where none is.
std::vector<Evidence> believed(const std::vector<Evidence>& evidence, std::size_t rooms,
                               double unsure_path_m) {
  std::vector<double> farthest_m(rooms, 0);
  for (const Evidence& one : evidence) {
    double& farthest = farthest_m[static_cast<std::size_t>(one.room)];
    farthest = std::max(farthest, std::min(one.from_crossing_m, unsure_path_m));
  }
  std::vector<Evidence> kept;
  std::ranges::copy_if(evidence, std::back_inserter(kept), [&](const Evidence& one) {
    return one.from_crossing_m >= farthest_m[static_cast<std::size_t>(one.room)];
  });
  return kept;
}

// Rooms spread over the free floor from their seeds, over wide floor before narrow. Floor by a
// crossing counts as narrower: of two narrow places, a door and what is left beside its leaf, the
// one by which the name changed is more likely the border.
void spread_over_floor(const FloorGrid& grid, const Floor& floor, const ReadWalks& walks,
                       const RoomLayoutOptions& options, RoomCells& room_of) {
  constexpr double kLean = 0.35;  // m of width for a metre from the crossing
  const std::vector<double> widths = free_widths(floor);
  const auto width = [&](Cell cell) {
    double from_crossing_m = options.unsure_path_m;
    for (const Crossing& crossing : walks.crossings) {
      from_crossing_m = std::min(
          from_crossing_m, (grid.cell_middle_m(cell.column, cell.row) - crossing.place).norm());
    }
    return widths[static_cast<std::size_t>(cell.row) * static_cast<std::size_t>(grid.columns()) +
                  static_cast<std::size_t>(cell.column)] +
           kLean * from_crossing_m / grid.cell_m();
  };
  Flood flood;
  for (const Evidence& seed : believed(walks.evidence, walks.names.size(), options.unsure_path_m)) {
    const auto cell = free_cell_near(grid, floor, seed.place, options.farthest_seed_m);
    if (!cell || room_of.at(cell->column, cell->row) != kNoRoom) continue;
    room_of.at(cell->column, cell->row) = seed.room;
    flood.push(width(*cell), *cell);
  }
  while (!flood.empty()) {
    const auto [level, cell] = flood.pop();
    for (const Cell side : kSides) {
      const Cell next{cell.column + side.column, cell.row + side.row};
      if (!room_of.contains(next.column, next.row) ||
          room_of.at(next.column, next.row) != kNoRoom || floor.at(next.column, next.row) == 0) {
        continue;
      }
      room_of.at(next.column, next.row) = room_of.at(cell.column, cell.row);
      flood.push(std::min(level, width(next)), next);
    }
  }
}

// What is not free goes to the room whose floor is nearest along the grid.
void take_furniture_in(const FloorGrid& grid, const Floor& floor, double depth_m,
                       RoomCells& room_of) {
  Flood flood;
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      if (room_of.at(column, row) != kNoRoom) flood.push(0, {column, row});
    }
  }
  while (!flood.empty()) {
    const auto [level, cell] = flood.pop();
    if (-level + grid.cell_m() > depth_m) continue;
    for (const Cell side : kSides) {
      const Cell next{cell.column + side.column, cell.row + side.row};
      if (!room_of.contains(next.column, next.row) ||
          room_of.at(next.column, next.row) != kNoRoom || floor.at(next.column, next.row) != 0) {
        continue;
      }
      room_of.at(next.column, next.row) = room_of.at(cell.column, cell.row);
      flood.push(level - grid.cell_m(), next);
    }
  }
}

// The middles of the edges between free cells of two rooms, by pair.
std::map<std::pair<std::int16_t, std::int16_t>, std::vector<Vector2d>> borders(
    const FloorGrid& grid, const Floor& floor, const RoomCells& room_of) {
  std::map<std::pair<std::int16_t, std::int16_t>, std::vector<Vector2d>> found;
  const auto room = [&](int column, int row) {
    return room_of.contains(column, row) && floor.at(column, row) != 0 ? room_of.at(column, row)
                                                                       : kNoRoom;
  };
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      const std::int16_t here = room(column, row);
      for (const Cell side : {Cell{1, 0}, Cell{0, 1}}) {
        const std::int16_t there = room(column + side.column, row + side.row);
        if (here == kNoRoom || there == kNoRoom || here == there) continue;
        const Vector2d middle =
            grid.cell_middle_m(column, row) + grid.cell_m() / 2 * Vector2d(side.column, side.row);
        found[std::minmax(here, there)].push_back(middle);
      }
    }
  }
  return found;
}

// Points that hang together: nearer than one and a half cells, give or take.
std::vector<std::vector<Vector2d>> pieces_of(const std::vector<Vector2d>& points, double cell_m) {
  DisjointSets sets(points.size());
  for (std::size_t a = 0; a < points.size(); ++a) {
    for (std::size_t b = a + 1; b < points.size(); ++b) {
      if ((points[a] - points[b]).norm() < 1.6 * cell_m) sets.join(a, b);
    }
  }
  std::map<std::size_t, std::vector<Vector2d>> pieces;
  for (std::size_t i = 0; i < points.size(); ++i) pieces[sets.find(i)].push_back(points[i]);
  std::vector<std::vector<Vector2d>> result;
  for (auto& [first, piece] : pieces) result.push_back(std::move(piece));
  return result;
}

// The two of them that lie farthest apart stand at the doorway's sides.
Doorway doorway_across(const std::vector<Vector2d>& border, double cell_m) {
  Doorway doorway;
  doorway.middle_level = border.front();
  double widest = 0;
  for (std::size_t a = 0; a < border.size(); ++a) {
    for (std::size_t b = a + 1; b < border.size(); ++b) {
      const double apart = (border[a] - border[b]).norm();
      if (apart <= widest) continue;
      widest = apart;
      doorway.middle_level = (border[a] + border[b]) / 2;
    }
  }
  doorway.width_m = widest + cell_m;
  return doorway;
}

std::vector<Doorway> find_doorways(const FloorGrid& grid, const Floor& floor,
                                   const RoomCells& room_of, const ReadWalks& walks,
                                   const RoomLayoutOptions& options) {
  std::vector<Doorway> doorways;
  for (const auto& [pair, border] : borders(grid, floor, room_of)) {
    for (const auto& piece : pieces_of(border, grid.cell_m())) {
      Doorway doorway = doorway_across(piece, grid.cell_m());
      if (doorway.width_m < options.least_doorway_m) continue;
      doorway.rooms = {walks.names[static_cast<std::size_t>(pair.first)],
                       walks.names[static_cast<std::size_t>(pair.second)]};
      doorways.push_back(doorway);
    }
  }
  for (const Crossing& crossing : walks.crossings) {
    const auto [a, b] = std::minmax(crossing.from, crossing.to);
    const std::array rooms{walks.names[static_cast<std::size_t>(a)],
                           walks.names[static_cast<std::size_t>(b)]};
    Doorway* nearest = nullptr;
    double nearest_m = 2 * options.unsure_path_m;
    for (Doorway& doorway : doorways) {
      const double distance_m = (doorway.middle_level - crossing.place).norm();
      if (doorway.rooms != rooms || distance_m > nearest_m) continue;
      nearest = &doorway;
      nearest_m = distance_m;
    }
    if (nearest != nullptr) {
      nearest->is_walked = true;
    } else {
      doorways.push_back({rooms, crossing.place, 0, true});
    }
  }
  std::ranges::stable_sort(doorways, [](const Doorway& a, const Doorway& b) {
    return a.rooms != b.rooms ? a.rooms < b.rooms : a.width_m > b.width_m;
  });
  return doorways;
}

std::vector<RoomExtent> find_extents(const FloorGrid& grid, const Floor& floor,
                                     const RoomCells& room_of, const ReadWalks& walks) {
  std::vector<RoomExtent> extents(walks.names.size());
  for (std::size_t i = 0; i < extents.size(); ++i) extents[i].name = walks.names[i];
  for (const Evidence& one : walks.evidence) {
    extents[static_cast<std::size_t>(one.room)].middle_level = one.place;
  }
  const std::vector<double> widths = free_widths(floor);
  std::vector<double> widest(extents.size(), 0);
  std::size_t cell = 0;
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column, ++cell) {
      const std::int16_t room = room_of.at(column, row);
      if (room == kNoRoom || floor.at(column, row) == 0) continue;
      const auto index = static_cast<std::size_t>(room);
      extents[index].floor_m2 += grid.cell_m() * grid.cell_m();
      if (widths[cell] <= widest[index]) continue;
      widest[index] = widths[cell];
      extents[index].middle_level = grid.cell_middle_m(column, row);
    }
  }
  return extents;
}

}  // namespace

Expected<void> RoomLayoutOptions::validate() const {
  for (const auto& [name, value] : {std::pair{"unsure_path_m", unsure_path_m},
                                    {"furniture_depth_m", furniture_depth_m},
                                    {"farthest_seed_m", farthest_seed_m},
                                    {"least_doorway_m", least_doorway_m}}) {
    if (!(value >= 0 && std::isfinite(value))) {
      return fail("{} must be a length of 0 m or more, not {}", name, value);
    }
  }
  return {};
}

Expected<RoomLayout> RoomLayout::make(const FloorGrid& grid, std::span<const WalkedPath> walks,
                                      const RoomLayoutOptions& options) {
  ROOMWISE_CHECK_OK(options.validate());
  ReadWalks read{room_names(walks), {}, {}};
  for (const WalkedPath& walk : walks) read_walk(walk, read);

  RoomLayout layout;
  layout.origin_m_ = grid.origin_m();
  layout.cell_m_ = grid.cell_m();
  layout.room_of_cell_ = RoomCells(grid.columns(), grid.rows(), kNoRoom);
  const Floor floor = free_floor(grid, walks);
  spread_over_floor(grid, floor, read, options, layout.room_of_cell_);
  take_furniture_in(grid, floor, options.furniture_depth_m, layout.room_of_cell_);
  layout.rooms_ = find_extents(grid, floor, layout.room_of_cell_, read);
  if (std::ranges::all_of(layout.rooms_, [](const RoomExtent& r) { return r.floor_m2 == 0; })) {
    return fail(
        "no named place of the walk lies on free floor; name the rooms of the walk, or walk with "
        "the camera tilted down a little");
  }
  layout.doorways_ = find_doorways(grid, floor, layout.room_of_cell_, read, options);
  return layout;
}

std::optional<std::size_t> RoomLayout::room_of_cell(int column, int row) const {
  if (!room_of_cell_.contains(column, row)) return std::nullopt;
  const std::int16_t room = room_of_cell_.at(column, row);
  return room == kNoRoom ? std::nullopt : std::optional<std::size_t>(room);
}

std::optional<std::string> RoomLayout::room_at(const Vector2d& point_level) const {
  const Eigen::Array2d cell = ((point_level - origin_m_) / cell_m_).array().floor();
  if (!(cell.abs() < kMostCells).all()) return std::nullopt;
  const auto room = room_of_cell(static_cast<int>(cell.x()), static_cast<int>(cell.y()));
  return room ? std::optional(rooms_[*room].name) : std::nullopt;
}

std::vector<std::string> RoomLayout::neighbors(const std::string& room) const {
  std::set<std::string> found;
  for (const Doorway& doorway : doorways_) {
    if (doorway.joins(room)) found.insert(doorway.rooms[doorway.rooms[0] == room ? 1 : 0]);
  }
  return {found.begin(), found.end()};
}

}  // namespace roomwise::rooms
