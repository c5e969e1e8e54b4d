#include "roomwise/rooms/layout/room_layout.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "roomwise/base/disjoint_sets.h"
#include "roomwise/rooms/layout/floor_rooms.h"

namespace roomwise::rooms {
namespace {

using Eigen::Vector2d;
using fusion::FloorGrid;

// The middles of the edges between free cells of two rooms, by pair.
std::map<std::pair<std::int16_t, std::int16_t>, std::vector<Vector2d>> borders(
    const FloorGrid& grid, const FreeFloor& floor, const RoomCells& room_of) {
  std::map<std::pair<std::int16_t, std::int16_t>, std::vector<Vector2d>> found;
  const auto room = [&](int column, int row) {
    return room_of.contains(column, row) && floor.at(column, row) != 0 ? room_of.at(column, row)
                                                                       : kNoRoom;
  };
  for (int row = 0; row < grid.rows(); ++row) {
    for (int column = 0; column < grid.columns(); ++column) {
      const std::int16_t here = room(column, row);
      for (const Eigen::Vector2i& side : {Eigen::Vector2i(1, 0), Eigen::Vector2i(0, 1)}) {
        const std::int16_t there = room(column + side.x(), row + side.y());
        if (here < 0 || there < 0 || here == there) continue;
        const Vector2d middle =
            grid.cell_middle_m(column, row) + grid.cell_m() / 2 * side.cast<double>();
        found[std::minmax(here, there)].push_back(middle);
      }
    }
  }
  return found;
}

// Of points, of which those that are nearer than one and a half cells, give or take, are joined.
std::vector<std::vector<Vector2d>> connected_components(const std::vector<Vector2d>& points,
                                                        double cell_m) {
  DisjointSets sets(points.size());
  for (std::size_t a = 0; a < points.size(); ++a) {
    for (std::size_t b = a + 1; b < points.size(); ++b) {
      if ((points[a] - points[b]).norm() < 1.6 * cell_m) sets.join(a, b);
    }
  }
  std::map<std::size_t, std::vector<Vector2d>> components;
  for (std::size_t i = 0; i < points.size(); ++i) components[sets.find(i)].push_back(points[i]);
  std::vector<std::vector<Vector2d>> result;
  for (auto& [first, component] : components) result.push_back(std::move(component));
  return result;
}

using Mask = image::Image<std::uint8_t>;  // by cell: not 0 where something holds

// What is no floor and hangs together.
struct Solid {
  std::vector<Eigen::Vector2i> cells;
  std::set<std::int16_t> rooms;  // whose floor lies beside it
  bool is_at_edge = false;       // of the grid, beyond which nobody knows
  Eigen::Vector2i least = Eigen::Vector2i::Constant(std::numeric_limits<int>::max());
  Eigen::Vector2i most = Eigen::Vector2i::Constant(-1);
};

Solid solid_from(const Eigen::Vector2i& first, const FreeFloor& floor, const RoomCells& room_of,
                 Mask& seen) {
  Solid solid;
  solid.cells.push_back(first);
  seen.at(first.x(), first.y()) = 1;
  for (std::size_t i = 0; i < solid.cells.size(); ++i) {
    const Eigen::Vector2i cell = solid.cells[i];
    solid.least = solid.least.cwiseMin(cell);
    solid.most = solid.most.cwiseMax(cell);
    for (int row = cell.y() - 1; row <= cell.y() + 1; ++row) {
      for (int column = cell.x() - 1; column <= cell.x() + 1; ++column) {
        if (!floor.contains(column, row)) {
          solid.is_at_edge = true;
        } else if (floor.at(column, row) != 0) {
          solid.rooms.insert(room_of.at(column, row));
        } else if (seen.at(column, row) == 0) {
          seen.at(column, row) = 1;
          solid.cells.emplace_back(column, row);
        }
      }
    }
  }
  return solid;
}

// Where a wall may be, or what stands at one. What stands in the midst of floor is none, unless it
// is longer than what people set up there, or three rooms meet at it.
Mask walls_of(const FreeFloor& floor, const RoomCells& room_of, double cell_m) {
  constexpr double kLongestThing_m = 2.5;  // a long sofa; a table for ten
  Mask walls(floor.width(), floor.height(), 0), seen = walls;
  for (int row = 0; row < floor.height(); ++row) {
    for (int column = 0; column < floor.width(); ++column) {
      if (floor.at(column, row) != 0 || seen.at(column, row) != 0) continue;
      const Solid solid = solid_from({column, row}, floor, room_of, seen);
      const double length_m =
          cell_m * (solid.most - solid.least + Eigen::Vector2i::Ones()).cast<double>().norm();
      if (!solid.is_at_edge && solid.rooms.size() < 3 && length_m < kLongestThing_m) continue;
      for (const Eigen::Vector2i& cell : solid.cells) walls.at(cell.x(), cell.y()) = 1;
    }
  }
  return walls;
}

// Whether a wall, or what stands at one, is near one end of a border, not on the border's own side.
bool is_framed_at(const FloorGrid& grid, const Mask& walls, const Vector2d& end,
                  const Vector2d& outwards) {
  // Who walks through leaves so much room, in which a cell may not have been seen.
  constexpr double kReach_m = 0.25;
  const Eigen::Array2d at = (end - grid.origin_m()) / grid.cell_m();
  const double reach = kReach_m / grid.cell_m();
  const Eigen::Array2i first = (at - reach).floor().cast<int>().max(0);
  const Eigen::Array2i last =
      (at + reach).floor().cast<int>().min(Eigen::Array2i(grid.columns() - 1, grid.rows() - 1));
  for (int row = first.y(); row <= last.y(); ++row) {
    for (int column = first.x(); column <= last.x(); ++column) {
      if (grid.at(column, row) != fusion::FloorCell::kOccupied) continue;
      if (walls.at(column, row) == 0) continue;
      const Vector2d from_end = grid.cell_middle_m(column, row) - end;
      if (from_end.norm() <= kReach_m && from_end.dot(outwards) >= 0) return true;
    }
  }
  return false;
}

// The two of them that lie farthest apart stand at the doorway's sides.
Doorway doorway_across(const FloorGrid& grid, const Mask& walls,
                       const std::vector<Vector2d>& border) {
  const double cell_m = grid.cell_m();
  Doorway doorway;
  doorway.middle_plan = border.front();
  double widest = 0;
  Vector2d from = border.front(), to = border.front();
  for (std::size_t a = 0; a < border.size(); ++a) {
    for (std::size_t b = a + 1; b < border.size(); ++b) {
      const double apart = (border[a] - border[b]).norm();
      if (apart <= widest) continue;
      widest = apart;
      from = border[a];
      to = border[b];
    }
  }
  doorway.middle_plan = (from + to) / 2;
  doorway.width_m = widest + cell_m;
  doorway.direction_rad = std::atan2(to.y() - from.y(), to.x() - from.x());
  doorway.is_framed =
      is_framed_at(grid, walls, from, from - to) && is_framed_at(grid, walls, to, to - from);
  return doorway;
}

// The nearest so near, of those that `counts` holds for; null where there is none.
Doorway* nearest_doorway(std::vector<Doorway>& doorways, const Vector2d& place, double reach_m,
                         const auto& counts) {
  Doorway* nearest = nullptr;
  for (Doorway& doorway : doorways) {
    const double distance_m = (doorway.middle_plan - place).norm();
    if (distance_m > reach_m || !counts(doorway)) continue;
    nearest = &doorway;
    reach_m = distance_m;
  }
  return nearest;
}

// Of two rooms that are open to each other around a table there is one border, the widest part of
// it. Of `doorways`, which are ordered, the widest of one pair first.
void join_open_borders(std::vector<Doorway>& doorways) {
  std::vector<Doorway> joined;
  for (const Doorway& one : doorways) {
    const auto is_same = [&](const Doorway& other) {
      return !one.is_door() && !other.is_door() && other.rooms == one.rooms &&
             (other.middle_plan - one.middle_plan).norm() - (other.width_m + one.width_m) / 2 <
                 kWidestDoor_m;
    };
    const auto other = std::ranges::find_if(joined, is_same);
    if (other == joined.end()) {
      joined.push_back(one);
    } else {
      other->is_walked = other->is_walked || one.is_walked;
    }
  }
  doorways = std::move(joined);
}

void order_doorways(std::vector<Doorway>& doorways) {
  std::ranges::stable_sort(doorways, [](const Doorway& a, const Doorway& b) {
    return a.rooms != b.rooms ? a.rooms < b.rooms : a.width_m > b.width_m;
  });
}

// Marks where walks lead through, and adds where one went over what the map shows no border of.
void add_crossings(const NamedWalks& walks, double unsure_path_m, std::vector<Doorway>& doorways) {
  std::vector<Crossing> unseen;
  for (const Crossing& crossing : walks.crossings) {
    const auto [a, b] = std::minmax(crossing.from, crossing.to);
    const std::array rooms{walks.names[static_cast<std::size_t>(a)],
                           walks.names[static_cast<std::size_t>(b)]};
    Doorway* const crossed =
        nearest_doorway(doorways, crossing.place, 2 * unsure_path_m,
                        [&](const Doorway& doorway) { return doorway.rooms == rooms; });
    if (crossed != nullptr) {
      crossed->is_walked = true;
    } else {
      unseen.push_back(crossing);
    }
  }
  // A name came early or late, so that the map shows another room's border at the place: it is that
  // one, where the two rooms are known to hang together elsewhere.
  for (const Crossing& crossing : unseen) {
    const auto [a, b] = std::minmax(crossing.from, crossing.to);
    const std::array rooms{walks.names[static_cast<std::size_t>(a)],
                           walks.names[static_cast<std::size_t>(b)]};
    const bool are_joined = std::ranges::find(doorways, rooms, &Doorway::rooms) != doorways.end();
    const auto is_at_place = [&](const Doorway& doorway) {
      if (doorway.rooms == rooms) return true;
      const bool is_near = (doorway.middle_plan - crossing.place).norm() <= unsure_path_m;
      return are_joined && is_near && (doorway.joins(rooms[0]) || doorway.joins(rooms[1]));
    };
    Doorway* const there =
        nearest_doorway(doorways, crossing.place, 2 * unsure_path_m, is_at_place);
    if (there != nullptr) {
      there->is_walked = true;
    } else {
      doorways.push_back({.rooms = rooms, .middle_plan = crossing.place, .is_walked = true});
    }
  }
}

std::vector<Doorway> find_doorways(const FloorGrid& grid, const FreeFloor& floor,
                                   const RoomCells& room_of, const NamedWalks& walks,
                                   const RoomLayoutOptions& options) {
  std::vector<Doorway> doorways;
  const Mask walls = walls_of(floor, room_of, grid.cell_m());
  for (const auto& [pair, border] : borders(grid, floor, room_of)) {
    for (const auto& component : connected_components(border, grid.cell_m())) {
      Doorway doorway = doorway_across(grid, walls, component);
      if (doorway.width_m < options.min_doorway_m) continue;
      doorway.rooms = {walks.names[static_cast<std::size_t>(pair.first)],
                       walks.names[static_cast<std::size_t>(pair.second)]};
      doorways.push_back(doorway);
    }
  }
  add_crossings(walks, options.unsure_path_m, doorways);
  order_doorways(doorways);
  join_open_borders(doorways);
  return doorways;
}

std::vector<RoomExtent> find_extents(const FloorGrid& grid, const FreeFloor& floor,
                                     const RoomCells& room_of, const NamedWalks& walks) {
  std::vector<RoomExtent> extents(walks.names.size());
  for (std::size_t i = 0; i < extents.size(); ++i) extents[i].name = walks.names[i];
  for (const WalkEvidence& one : walks.evidence) {
    extents[static_cast<std::size_t>(one.room)].middle_plan = one.place;
  }
  for (std::size_t i = 0; i < extents.size(); ++i) {
    // What lies beyond a border to another room is not free here, nor its own.
    FreeFloor own(floor.width(), floor.height());
    for (int row = 0; row < grid.rows(); ++row) {
      for (int column = 0; column < grid.columns(); ++column) {
        const bool is_own = room_of.at(column, row) == static_cast<std::int16_t>(i);
        own.at(column, row) = is_own ? floor.at(column, row) : 0;
      }
    }
    const std::vector<double> widths = free_widths(own);
    const auto free_cells = std::ranges::count_if(widths, [](double width) { return width > 0; });
    if (free_cells == 0) continue;
    const auto widest = static_cast<int>(std::ranges::max_element(widths) - widths.begin());
    extents[i].floor_m2 = static_cast<double>(free_cells) * grid.cell_m() * grid.cell_m();
    extents[i].middle_plan = grid.cell_middle_m(widest % grid.columns(), widest / grid.columns());
  }
  return extents;
}

// As walks named their places before lines and outlines made them other rooms'.
NamedWalks read_walks_before_edits(std::span<const WalkedPath> walks, double unsure_path_m) {
  std::vector<WalkedPath> before(walks.begin(), walks.end());
  for (WalkedPath& walk : before) {
    for (WalkedPlace& place : walk) {
      if (!place.room_before_edits.empty()) place.room = place.room_before_edits;
    }
  }
  return read_walks(before, unsure_path_m);
}

// Looked at every half standard deviation: where, in standard deviations, and how much of it.
std::vector<std::pair<Vector2d, double>> normal_distribution() {
  constexpr int kReach = 6;
  constexpr double kStep = 0.5;
  std::vector<std::pair<Vector2d, double>> parts;
  double sum = 0;
  for (int y = -kReach; y <= kReach; ++y) {
    for (int x = -kReach; x <= kReach; ++x) {
      const Vector2d offset = kStep * Vector2d(x, y);
      parts.emplace_back(offset, std::exp(-offset.squaredNorm() / 2));
      sum += parts.back().second;
    }
  }
  for (auto& [offset, share] : parts) share /= sum;
  return parts;
}

}  // namespace

Expected<void> RoomLayoutOptions::validate() const {
  for (const auto& [name, value] : {std::pair{"unsure_path_m", unsure_path_m},
                                    {"furniture_depth_m", furniture_depth_m},
                                    {"farthest_seed_m", farthest_seed_m},
                                    {"min_doorway_m", min_doorway_m}}) {
    if (!(value >= 0 && std::isfinite(value))) {
      return fail("{} must be a length of 0 m or more, not {}", name, value);
    }
  }
  return {};
}

Expected<RoomLayout> RoomLayout::make(const FloorGrid& grid, std::span<const WalkedPath> walks,
                                      const RoomLayoutOptions& options,
                                      std::span<const LayoutEdit> edits) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  NamedWalks read = read_walks(walks, options.unsure_path_m);
  add_edited_rooms(edits, read);
  // Edits are laid over what is spread without them, so that they change no room beside theirs.
  NamedWalks before = read_walks_before_edits(walks, options.unsure_path_m);
  add_rooms(before.names, read);
  add_rooms(read.names, before);

  RoomLayout layout;
  layout.origin_m_ = grid.origin_m();
  layout.cell_m_ = grid.cell_m();
  layout.room_of_cell_ = RoomCells(grid.columns(), grid.rows(), kNoRoom);
  layout.floor_ = free_floor(grid, walks);
  const FreeFloor& floor = layout.floor_;
  spread_over_floor(grid, floor, before, options.unsure_path_m, options.farthest_seed_m,
                    layout.room_of_cell_);
  take_furniture_in(grid, floor, options.furniture_depth_m, layout.room_of_cell_);
  apply_edits(grid, floor, edits, read.names, layout.room_of_cell_);
  layout.rooms_ = find_extents(grid, floor, layout.room_of_cell_, read);
  if (!layout.has_floor()) return layout;
  layout.doorways_ = find_doorways(grid, floor, layout.room_of_cell_, read, options);
  layout.add_doors(edits, options.unsure_path_m);
  return layout;
}

void RoomLayout::add_doors(std::span<const LayoutEdit> edits, double unsure_path_m) {
  const auto is_room = [&](const std::string& name) {
    return std::ranges::find(rooms_, name, &RoomExtent::name) != rooms_.end();
  };
  for (const LayoutEdit& edit : edits) {
    const auto* const door = std::get_if<AddedDoor>(&edit);
    if (door == nullptr || !std::ranges::all_of(door->rooms, is_room)) continue;
    // What the map shows at the place is the same door.
    Doorway said{.rooms = door->rooms,
                 .middle_plan = door->middle_plan,
                 .is_walked = true,
                 .is_framed = true};
    Doorway* const there =
        nearest_doorway(doorways_, said.middle_plan, unsure_path_m, [&](const Doorway& one) {
          return std::ranges::is_permutation(one.rooms, said.rooms) && !one.is_stairs;
        });
    if (there == nullptr) {
      doorways_.push_back(said);
      continue;
    }
    if (there->is_door()) {
      said.width_m = there->width_m;
      said.direction_rad = there->direction_rad;
    }
    *there = said;
  }
  std::ranges::stable_sort(doorways_, {}, &Doorway::rooms);
}

void RoomLayout::add_stairs(const Vector2d& below_plan, const Vector2d& above_plan) {
  const auto below = room_at(below_plan), above = room_at(above_plan);
  if (!below || !above || below == above) return;
  const bool is_below_first = *below < *above;
  doorways_.push_back({.rooms = {std::min(*below, *above), std::max(*below, *above)},
                       .middle_plan = below_plan,
                       .is_stairs = true,
                       .stairs_ends = {is_below_first ? below_plan : above_plan,
                                       is_below_first ? above_plan : below_plan}});
  std::ranges::stable_sort(doorways_, {}, &Doorway::rooms);
}

bool RoomLayout::has_floor() const {
  return std::ranges::any_of(rooms_, [](const RoomExtent& room) { return room.floor_m2 > 0; });
}

std::optional<std::size_t> RoomLayout::room_of_cell(int column, int row) const {
  if (!room_of_cell_.contains(column, row)) return std::nullopt;
  const std::int16_t room = room_of_cell_.at(column, row);
  return room < 0 ? std::nullopt : std::optional<std::size_t>(room);
}

std::int16_t RoomLayout::room_around(const Vector2d& point_plan) const {
  const Eigen::Array2d at = ((point_plan - origin_m_) / cell_m_).array().floor();
  if (!(at.abs() < kMaxCells).all()) return kNoRoom;
  const int column = static_cast<int>(at.x()), row = static_cast<int>(at.y());
  return room_of_cell_.contains(column, row) ? room_of_cell_.at(column, row) : kNoRoom;
}

std::optional<std::string> RoomLayout::room_at(const Vector2d& point_plan) const {
  const std::int16_t room = room_around(point_plan);
  return room < 0 ? std::nullopt : std::optional(rooms_[static_cast<std::size_t>(room)].name);
}

std::vector<double> RoomLayout::room_probabilities(const Vector2d& point_plan,
                                                   double sigma_m) const {
  std::vector<double> shares(rooms_.size(), 0);
  for (const auto& [offset, share] : normal_distribution()) {
    const std::int16_t room = room_around(point_plan + sigma_m * offset);
    if (room >= 0) shares[static_cast<std::size_t>(room)] += share;
  }
  return shares;
}

double RoomLayout::nameless_share_around(const Vector2d& point_plan, double sigma_m) const {
  double nameless = 0;
  for (const auto& [offset, share] : normal_distribution()) {
    if (room_around(point_plan + sigma_m * offset) == kNamelessRoom) nameless += share;
  }
  return nameless;
}

std::vector<std::string> RoomLayout::neighbors(const std::string& room) const {
  std::set<std::string> found;
  for (const Doorway& doorway : doorways_) {
    if (doorway.joins(room)) found.insert(doorway.rooms[doorway.rooms[0] == room ? 1 : 0]);
  }
  return {found.begin(), found.end()};
}

}  // namespace roomwise::rooms
