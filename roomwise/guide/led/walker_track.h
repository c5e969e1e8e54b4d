#pragma once

#include <deque>
#include <optional>

#include "roomwise/base/timestamp.h"
#include "roomwise/guide/places/places.h"

namespace roomwise::guide {

// What people hear, they do within a second and a half (see docs/guide.md).
constexpr double kReaction_s = 1.3;           // and the next picture tells of it
constexpr double kMinWalkingSpeed_m_s = 0.3;  // nobody turns on the spot so fast

// Where somebody was in the last seconds, by poses that may be late, missing or wrong.
class WalkerTrack {
 public:
  // A pose as of `at_ns`; older ones than the newest are ignored. One that is farther from the last
  // than anybody walks is believed once the next one agrees with it.
  void add(const Pose& pose, TimestampNs at_ns);
  // Some times a second, whether or not there is a pose.
  void keep_pace(TimestampNs now_ns);

  // The newest that is believed, if it is fresh: what is said rests on it.
  [[nodiscard]] const Pose* pose(TimestampNs now_ns) const;
  // The newest that is believed, however old; null where there is none.
  [[nodiscard]] const Pose* newest() const {
    return poses_.empty() ? nullptr : &poses_.back().pose;
  }
  // Since that one; infinity where there is none.
  [[nodiscard]] double age_s(TimestampNs now_ns) const;
  // Over the last second or so; nothing where too few poses tell. What the poses' own uncertainty
  // may be is not walked.
  [[nodiscard]] std::optional<double> speed_m_s() const;
  // False where it is not known.
  [[nodiscard]] bool is_standing() const;
  // And not only turns on the spot; false where it is not known.
  [[nodiscard]] bool is_walking() const;
  // Turns, or may turn: true where it is not known.
  [[nodiscard]] bool may_turn() const;
  // How far the person walked in all, m.
  [[nodiscard]] double walked_m() const { return walked_m_; }
  // Since the newest pose: it is as old as its picture, and who walks has gone on.
  [[nodiscard]] double walked_since_m() const;
  // Of so much from the newest pose, what will be left when words of so many seconds have been
  // heard: who walks goes on meanwhile.
  [[nodiscard]] double left_when_heard_m(double distance_m, double spoken_s) const;

 private:
  struct TimedPose {
    Pose pose;
    TimestampNs at_ns = 0;
  };
  // A second or so before the newest; null where there is none.
  [[nodiscard]] const TimedPose* a_while_ago() const;

  std::deque<TimedPose> poses_;  // of the last seconds, believed
  std::optional<TimedPose> doubted_;
  double walked_m_ = 0;
  double pace_m_s_ = 0.5;  // at which they walk when they walk
  double newest_pose_age_s_ = 0;
  std::optional<Eigen::Vector2d> counted_to_;  // of walked_m_
};

}  // namespace roomwise::guide
