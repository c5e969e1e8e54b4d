#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "roomwise/fusion/gravity_aligned_frame.h"
#include "roomwise/home/home.h"

// Places that people mark to come back to: "my chair". Each is a row beside what people changed by
// hand (home::Edit), hung on a key-frame, so that it moves with the map and stays where a walk is
// forgotten and another shows the place. No change of things or rooms: it is neither listed nor
// undone with these.
namespace roomwise::pipeline {

struct MarkedSpot {
  home::EditId id = 0;        // set when it is stored
  std::string name;           // empty: "remember where I am"
  std::string owner;          // the number of the device that marked it; empty: the computer itself
  std::int64_t marked_s = 0;  // since 1970
  home::EditPlace place = {};

  // Whether somebody is told of it: who marked it, and of the computer's everybody.
  [[nodiscard]] bool is_known_to(std::string_view who) const {
    return owner.empty() || owner == who;
  }
};
constexpr std::size_t kMaxSpots = 200;  // of a home

// By name; those without one first.
[[nodiscard]] Expected<std::vector<MarkedSpot>> marked_spots(const home::Home& home);

// A point of the map's largest component: it hangs on the key-frame that is nearest. Fails where
// the map is empty.
[[nodiscard]] Expected<home::EditPlace> spot_place(std::span<const home::Keyframe> keyframes,
                                                   const Eigen::Vector3d& point_world);
// Where that is in the map's world now; absent where its walk was forgotten, or is not part of the
// largest component. `keyframes` of the home, which lie by id.
[[nodiscard]] std::optional<Eigen::Vector3d> point_world(const home::EditPlace& place,
                                                         std::span<const home::Keyframe> keyframes);
// The same on the plan, where people are placed: storeys lie side by side on it (fusion::Storeys).
// The place that is kept does not change where the plan does.
[[nodiscard]] Expected<home::EditPlace> spot_place_on_plan(
    std::span<const home::Keyframe> keyframes, const fusion::GravityAlignedFrame& frame,
    const Eigen::Vector3d& point_plan);
[[nodiscard]] std::optional<Eigen::Vector3d> point_on_plan(
    const home::EditPlace& place, std::span<const home::Keyframe> keyframes,
    const fusion::GravityAlignedFrame& frame);

// Fails (ErrorCode::kRefused), with what to do, where it cannot be spoken or means something else:
// a room, a thing, one that was taught.
[[nodiscard]] Expected<void> check_spot_name(const home::Home& home, const std::string& name);

// Takes the place of the owner's spot of that name, capitals aside. Fails as check_spot_name()
// does, and where there are kMaxSpots.
[[nodiscard]] Expected<home::EditId> mark_spot(home::Home& home, const MarkedSpot& spot);
// Fails where it is another's of the owner already (ErrorCode::kRefused).
[[nodiscard]] Expected<void> rename_spot(home::Home& home, home::EditId id,
                                         const std::string& name);
// No byte of it stays once Home::erase_removed() ran.
[[nodiscard]] Expected<void> forget_spot(home::Home& home, home::EditId id);

}  // namespace roomwise::pipeline
