#pragma once

#include <Eigen/Core>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include "roomwise/guide/way/route.h"
#include "roomwise/rooms/layout/room_layout.h"

namespace roomwise::guide {

constexpr double kDegree_rad = std::numbers::pi / 180;
constexpr double kNoTurn_rad = 20 * kDegree_rad;  // of two legs: one goes on nearly straight
constexpr double kHand_m = 0.7;                   // beside the way a hand finds what stands there
constexpr double kLegEnd_m = 0.35;                // half a step before a leg's end one is at it
constexpr double kAtEnd_m = 0.22;                 // a foot's length from the way's end one is there
// Of who is placed by pictures: who is told to be somewhere is to be there.
constexpr double kPlaceError_m = 0.05;

// A straight part of a way, as it is spoken of.
struct Leg {
  Eigen::Vector2d from = Eigen::Vector2d::Zero();
  Eigen::Vector2d to = Eigen::Vector2d::Zero();
  double length_m = 0;                      // along corners that are not spoken of
  std::optional<StairsOnWay> stairs = {};   // it leads over them, to another part of the plan
  const rooms::Doorway* doorway = nullptr;  // at which it ends: a door or an opening

  [[nodiscard]] bool ends_at_door() const { return doorway != nullptr && doorway->is_door(); }
  // Counter-clockwise from x.
  [[nodiscard]] double heading_rad() const;
  [[nodiscard]] Eigen::Vector2d along() const;  // of length 1
};

// The legs of a way: corners, doors and openings (of the `doorways`) end one. Corners that hardly
// turn, and legs shorter than a step, are joined with what comes after them, unless rooms meet
// between. Stairs are a leg. Borrows from the doorways.
[[nodiscard]] std::vector<Leg> legs_of(const Route& route, std::span<const rooms::Doorway> doorways,
                                       std::span<const fusion::Staircase> stairs = {});

// Of the places where rooms meet those that a hand can find, see rooms::Doorway::is_door.
[[nodiscard]] std::vector<rooms::Doorway> doors_of(std::span<const rooms::Doorway> doorways);

// Straight enough to begin to walk a leg of that length.
[[nodiscard]] double straight_enough_rad(double length_m);

[[nodiscard]] double heading_to(const Eigen::Vector2d& from, const Eigen::Vector2d& to);
// From one heading to another, from -pi to pi, positive to the left.
[[nodiscard]] double turn_rad(double from_rad, double to_rad);

}  // namespace roomwise::guide
