#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "roomwise/base/calendar_time.h"
#include "roomwise/objects/instances/instances.h"
#include "roomwise/rooms/layout/room_layout.h"

namespace roomwise::guide {

// Where the rooms of two places are not both known, what is farther away may well stand behind a
// wall.
constexpr double kSameRoom_m = 3;

// Where somebody stands on the floor: on the plan (fusion/storeys.h), metres.
struct Pose {
  Eigen::Vector2d position_plan = Eigen::Vector2d::Zero();
  double heading_rad = 0;  // which way they look, counter-clockwise from x
  double sigma_m = 0;      // standard deviation of the position

  // Of what they see so far ahead and to their left, m.
  [[nodiscard]] Eigen::Vector2d place_of(const Eigen::Vector2d& ahead_left_m) const;
  [[nodiscard]] Eigen::Vector2d ahead_left_of(const Eigen::Vector2d& place_plan) const;
};

// What is known of where somebody is: a pose, a room, both or nothing.
struct UserLocation {
  // With a pose less sure, "at 2 o'clock" would be a guess for all that is in reach of a few steps.
  static constexpr double kMaxSigma_m = 0.5;

  std::optional<Pose> pose = std::nullopt;
  std::optional<std::string> room = std::nullopt;

  // The pose, if it is known well enough to tell directions by.
  [[nodiscard]] const Pose* sure_pose() const;
};

// A thing of the home and where it stands.
struct KnownThing : objects::Instance {
  std::optional<Eigen::Vector3d> position_plan = std::nullopt;  // its middle
  std::optional<std::string> room = std::nullopt;
  // When a walk or a visit last saw it; absent where its stamps do not tell.
  std::optional<CalendarTime> seen = std::nullopt;
  double yaw_rad = 0;              // of its box about z, from x of the plan
  std::string note;                // that a helper wrote on it, to be said with it; may be empty
  std::int64_t added_by_edit = 0;  // the helper's change that added it; 0: pictures show it
  bool is_confirmed = false;       // a helper who was there says that it is there and is called so
  bool is_taught = false;  // somebody taught it; where it was seen last is all that is known

  // The probability that it is there still and is called so: less the longer ago it was seen
  // (objects::probability_still_there()), where that and the present are known. What a helper added
  // stays as certain as it was said.
  [[nodiscard]] double probability_at(const std::optional<CalendarTime>& today) const;
  [[nodiscard]] bool is_sure(const std::optional<CalendarTime>& today) const;
  [[nodiscard]] const Eigen::Vector3d& size_m() const { return box_keyframe.size_m; }
};

// Where something is, seen by somebody.
struct Bearing {
  int hour = 12;          // of a clock whose 12 is straight ahead: 1 to 12
  double distance_m = 0;  // along the floor, to its side that is nearest; 0 at least
  bool is_sure = true;    // the pose is known well enough for this hour

  [[nodiscard]] bool is_close() const;
};
[[nodiscard]] Bearing bearing_of(const Eigen::Vector2d& point_plan, const Pose& pose,
                                 double radius_m = 0);
// Nothing where the thing's place is not known. A thing reaches from its middle as far as half its
// narrow side.
[[nodiscard]] std::optional<Bearing> bearing_of(const KnownThing& thing, const Pose& pose);

// The rooms from one to another through the fewest doors, both included; of several such ways
// always the same one. Empty where doors do not lead there.
[[nodiscard]] std::vector<std::string> way_between_rooms(const std::string& from,
                                                         const std::string& to,
                                                         std::span<const rooms::Doorway> doorways);

}  // namespace roomwise::guide
