#pragma once

#include <array>
#include <span>
#include <string_view>

#include "laboratory/simulation/home/home_model.h"

namespace roomwise::simulation {

// Where people put a thing.
enum class Placing {
  kAgainstWall,  // its back to a wall
  kInCorner,     // the same, as near to a corner as can be
  kBeside,       // its back to the wall of the anchor, next to it
  kBefore,       // before the anchor's front, turned to it (a chair at a desk)
  kAlong,        // before the anchor's front, turned as it is (a low table before a sofa)
  kAround,       // at the anchor's sides, turned to it (chairs)
  kOpposite,     // its back to a wall, looking at the anchor
  kInMiddle,     // with room all around
  kOnFloor,      // flat: before the anchor or in the middle (rugs)
  kOnTop,        // on the anchor's surface
  kUnderWindow,  // at the wall below a window
};

struct FurnitureRule {
  std::string_view kind;
  Placing placing;
  std::array<std::string_view, 4> anchors{};  // kinds that it belongs to
  int most = 1;                               // pieces in the room, those of earlier rules counted
  double chance = 1;                          // of every piece
  double front_m = 0;  // free floor before its front; for kInMiddle on all sides
  double max_width_m = 9;
  double max_height_m = 9;
  double min_depth_m = 0;
  double min_room_m2 = 0;     // not in rooms smaller than that
  std::string_view unless{};  // not where the room has one of this kind
};

// In the order in which a room is furnished: what is large and bound to its place first. The row of
// a kitchen (sink, stove, fridge, cabinets) stands before these.
[[nodiscard]] std::span<const FurnitureRule> furniture_rules(RoomKind room);

// Without these a room of that kind is not what it is called.
[[nodiscard]] std::span<const std::string_view> essential_kinds(RoomKind room);

// Things that lie about and may lie elsewhere; things that stand but are shifted in passing.
[[nodiscard]] bool is_small_kind(std::string_view kind);
[[nodiscard]] bool is_movable_kind(std::string_view kind);

}  // namespace roomwise::simulation
