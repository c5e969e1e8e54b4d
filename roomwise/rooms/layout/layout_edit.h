#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "roomwise/fusion/floor_grid.h"
#include "roomwise/rooms/layout/floor_rooms.h"
#include "roomwise/rooms/layout/named_walks.h"

// What somebody who knows the home says of where its rooms lie, on the plan (fusion/storeys.h), m.
// Each overrules what walks show, and what was said before it.
namespace roomwise::rooms {

// Of the cells of both rooms, those left of the line, as one looks from its beginning to its end,
// are `left`'s, the others `right`'s.
struct BorderLine {
  std::string left, right;
  Eigen::Vector2d from_plan = Eigen::Vector2d::Zero(), to_plan = Eigen::Vector2d::Zero();

  [[nodiscard]] bool is_left(const Eigen::Vector2d& point_plan) const;
};

// The floor inside the outline is the room's, and what stands on it.
struct DrawnRoom {
  std::string room;
  std::vector<Eigen::Vector2d> outline_plan;  // its corners, three or more

  [[nodiscard]] bool contains(const Eigen::Vector2d& point_plan) const;
};

// One gets from one room to the other here.
struct AddedDoor {
  std::array<std::string, 2> rooms;  // by name
  Eigen::Vector2d middle_plan = Eigen::Vector2d::Zero();
};

using LayoutEdit = std::variant<BorderLine, DrawnRoom, AddedDoor>;

// The rooms that lines and outlines name beside those of the walks, which so get a number.
void add_edited_rooms(std::span<const LayoutEdit> edits, NamedWalks& walks);
// Those of other walks likewise.
void add_rooms(std::span<const std::string> rooms, NamedWalks& walks);

// Gives the cells of lines and outlines to their rooms, in the order of edits. `room_of`: by the
// numbers of `names`. A room drawn takes floor and what already belongs to a room; cells that are
// nobody's stay so.
void apply_edits(const fusion::FloorGrid& grid, const FreeFloor& floor,
                 std::span<const LayoutEdit> edits, std::span<const std::string> names,
                 RoomCells& room_of);

}  // namespace roomwise::rooms
