#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/fusion/floor_grid.h"
#include "roomwise/image/image.h"
#include "roomwise/rooms/layout/layout_edit.h"
#include "roomwise/rooms/layout/named_walks.h"

namespace roomwise::rooms {

struct RoomLayoutOptions {
  // The walk says least about where a room ends while it goes from one to the next: people name a
  // room a step early or late. So much of the path before and after is not believed.
  double unsure_path_m = 0.8;
  // Beside free floor, what stands on it belongs to a room too: so far from the floor, m.
  double furniture_depth_m = 1.2;
  double farthest_seed_m = 0.4;  // from a walked place to free floor
  double min_doorway_m = 0.35;   // a narrower gap between two rooms is a fault of the grid

  [[nodiscard]] Expected<void> validate() const;
};

// Where one comes from a room into another: by a door, or over the border of two rooms that are
// open to each other.
struct Doorway {
  std::array<std::string, 2> rooms;                       // by name
  Eigen::Vector2d middle_plan = Eigen::Vector2d::Zero();  // m; of stairs where they begin below
  // Of the free floor there; 0: the map shows none, but the walk led through, or somebody says so.
  double width_m = 0;
  // From one side to the other, counter-clockwise from x; of a known width.
  double direction_rad = 0;
  bool is_walked = false;  // the walk led through it, or somebody does who says so
  bool is_stairs = false;  // they lead to the other room, on another storey
  // Of stairs: where one stands before them in each of the rooms, on the plan.
  std::array<Eigen::Vector2d, 2> stairs_ends = {Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
  // A wall, or what stands at one, ends the free floor on both sides, or somebody says that it is a
  // door: chairs and tables in the midst of floor frame none. Else the width is at least what was
  // seen.
  bool is_framed = false;

  // What a hand can find: a door's frame, an opening in a wall. Else it is an open border.
  [[nodiscard]] bool is_door() const { return !is_stairs && is_framed && width_m <= kWidestDoor_m; }
  // A walk led through, and no more floor was seen than a door has, nor a frame: rooms meet there,
  // and nobody knows what stands beside it.
  [[nodiscard]] bool is_opening() const {
    return !is_stairs && !is_framed && is_walked && width_m > 0 && width_m <= kWidestDoor_m;
  }
  [[nodiscard]] bool joins(const std::string& room) const {
    return rooms[0] == room || rooms[1] == room;
  }
  // Where it is for who comes from that room.
  [[nodiscard]] const Eigen::Vector2d& place_in(const std::string& room) const {
    return is_stairs ? stairs_ends[rooms[0] == room ? 0 : 1] : middle_plan;
  }
};

struct RoomExtent {
  std::string name;
  double floor_m2 = 0;  // free floor, as far as it was seen or walked on
  // The place of its free floor farthest from walls, furniture and other rooms, m: where to send
  // somebody.
  Eigen::Vector2d middle_plan = Eigen::Vector2d::Zero();
};

// The rooms on the floor, and how they hang together: on the plan, on which storeys lie side by
// side (fusion/storeys.h).
//
// Every free cell belongs to one room; free is also what is unknown to the map, but somebody walked
// there. From the places that the walk names, rooms spread over free floor where it is widest first
// (a watershed of the clearance: Meyer, "Topographic distance and watershed lines", 1994), so that
// two of them meet at the narrowest place between them that is not far from where the name changed,
// which is the door. All that is wider than a door counts alike, so that rooms that are open to
// each other meet about halfway. What is not free belongs to the room whose floor is nearest to it
// along the grid. Where somebody walked for a while without naming a room, a room without a name
// spreads likewise: its floor is no named room's.
class RoomLayout {
 public:
  // A room that the walk names, but never on free floor, has no extent and stands in rooms() all
  // the same. `edits` overrule what the walks show. Fails where options are wrong.
  [[nodiscard]] static Expected<RoomLayout> make(const fusion::FloorGrid& grid,
                                                 std::span<const WalkedPath> walks,
                                                 const RoomLayoutOptions& options = {},
                                                 std::span<const LayoutEdit> edits = {});

  // Stairs join the rooms in which these places lie; nothing where one lies in none.
  void add_stairs(const Eigen::Vector2d& below_plan, const Eigen::Vector2d& above_plan);

  [[nodiscard]] const std::vector<RoomExtent>& rooms() const { return rooms_; }  // by name
  // Whether any walked place with a name lies on free floor; else nothing lies in a room.
  [[nodiscard]] bool has_floor() const;
  // By the rooms' names; of one pair the widest first. One place has one doorway, and two rooms
  // that are open to each other around something that stands between them have one open border
  // there.
  [[nodiscard]] const std::vector<Doorway>& doorways() const { return doorways_; }
  // The room that the point lies in; absent outside, far from all floor, and in a room without a
  // name.
  [[nodiscard]] std::optional<std::string> room_at(const Eigen::Vector2d& point_plan) const;
  // The same for a point that is known with this standard deviation along each direction, m: the
  // probability of each of rooms(), in their order. What they lack of 1 is outside, or in a room
  // without a name.
  [[nodiscard]] std::vector<double> room_probabilities(const Eigen::Vector2d& point_plan,
                                                       double sigma_m) const;
  // The probability that it lies in a room that somebody walked in and nobody named.
  [[nodiscard]] double nameless_share_around(const Eigen::Vector2d& point_plan,
                                             double sigma_m) const;
  // The same for a cell of the grid: index into rooms().
  [[nodiscard]] std::optional<std::size_t> room_of_cell(int column, int row) const;
  // Whether the cell is floor: free, as the map shows it or because somebody walked there.
  [[nodiscard]] bool is_floor(int column, int row) const {
    return floor_.contains(column, row) && floor_.at(column, row) != 0;
  }
  // The rooms that a doorway leads to from this one, by name.
  [[nodiscard]] std::vector<std::string> neighbors(const std::string& room) const;

 private:
  RoomLayout() = default;
  void add_doors(std::span<const LayoutEdit> edits, double unsure_path_m);
  // As room_of_cell_ has it.
  [[nodiscard]] std::int16_t room_around(const Eigen::Vector2d& point_plan) const;

  Eigen::Vector2d origin_m_ = Eigen::Vector2d::Zero();
  double cell_m_ = 0;
  image::Image<std::uint8_t> floor_;         // not 0 where a cell is floor
  image::Image<std::int16_t> room_of_cell_;  // index into rooms_, or below 0 (floor_rooms.h)
  std::vector<RoomExtent> rooms_;
  std::vector<Doorway> doorways_;
};

}  // namespace roomwise::rooms
