#pragma once

#include <optional>
#include <span>

#include "roomwise/base/timestamp.h"
#include "roomwise/guide/led/followed_way.h"
#include "roomwise/guide/places/obstacle.h"

namespace roomwise::guide {

// What depth shows in the way, as seen along the leg.
struct InTheWay {
  ObstacleAhead seen;
  Pose from;               // where they stand, along the leg
  bool is_on_map = false;  // the map knows it

  [[nodiscard]] double ahead_m() const { return seen.ahead_left_m.x(); }
  // Of who faces so.
  [[nodiscard]] ObstacleAhead::Side side_by(const Pose& pose) const;
};

// Finds before what somebody who walks must stop. About the line to the leg's end a body's width of
// what is new. The plan leads past what the map knows, as narrow as ways are: that counts for who
// has left the plan's line so far that theirs is not clear on the map, or who does not head along
// it.
class HazardWatch {
 public:
  // Nothing for some seconds after it found one. What the map knows is found once: the way leads
  // past it all the same, and a cane finds it. Who comes back hears of it again.
  [[nodiscard]] std::optional<InTheWay> look(const FollowedWay& way, const Pose& pose,
                                             std::span<const Eigen::Vector2d> obstacles,
                                             const BarredFloor& floor, TimestampNs now_ns);

 private:
  std::optional<Eigen::Vector2d> known_stop_at_;  // before what the map knows
  std::optional<TimestampNs> found_ns_;
};

// Whether what the map does not know is on the line to the leg's end, also for who does not walk.
[[nodiscard]] bool is_newly_barred(const FollowedWay& way, const Pose& pose,
                                   std::span<const Eigen::Vector2d> obstacles,
                                   const BarredFloor& floor);

constexpr double kSameHazard_s = 4;

}  // namespace roomwise::guide
