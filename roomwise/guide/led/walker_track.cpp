#include "roomwise/guide/led/walker_track.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "roomwise/guide/way/legs.h"

namespace roomwise::guide {
namespace {

constexpr double kKept_s = 4;
// A direction holds for two seconds, and words take one.
constexpr double kFresh_s = 1.2;
// Nobody who is led through a home goes or turns faster.
constexpr double kQuickest_m_s = 1.0;
constexpr double kQuickest_rad_s = 120 * kDegree_rad;
constexpr double kSlack_m = 0.6;
constexpr double kSlack_rad = 40 * kDegree_rad;
constexpr double kStanding_m_s = 0.15;

bool may_follow(const Pose& before, TimestampNs before_ns, const Pose& pose, TimestampNs at_ns) {
  const double passed_s = seconds_between(before_ns, at_ns);
  const double reach_m =
      kSlack_m + 3 * std::max(before.sigma_m, pose.sigma_m) + kQuickest_m_s * passed_s;
  return (pose.position_plan - before.position_plan).norm() <= reach_m &&
         std::abs(turn_rad(before.heading_rad, pose.heading_rad)) <=
             kSlack_rad + kQuickest_rad_s * passed_s;
}

}  // namespace

void WalkerTrack::add(const Pose& pose, TimestampNs at_ns) {
  if (!poses_.empty() && at_ns <= poses_.back().at_ns) return;
  if (!poses_.empty() && !may_follow(poses_.back().pose, poses_.back().at_ns, pose, at_ns)) {
    const bool is_confirmed = doubted_ && doubted_->at_ns < at_ns &&
                              may_follow(doubted_->pose, doubted_->at_ns, pose, at_ns);
    doubted_ = TimedPose{pose, at_ns};
    if (!is_confirmed) return;
    poses_.clear();
  }
  doubted_.reset();
  // By so much, so that poses that tremble are no walk.
  const double stride_m = std::max(0.3, 3 * pose.sigma_m);
  if (!counted_to_ || poses_.empty()) counted_to_ = pose.position_plan;
  const double ahead_m = (pose.position_plan - *counted_to_).norm();
  if (ahead_m > stride_m) {
    walked_m_ += ahead_m;
    counted_to_ = pose.position_plan;
  }
  poses_.push_back({pose, at_ns});
  while (seconds_between(poses_.front().at_ns, at_ns) > kKept_s) poses_.pop_front();
}

// Who has just begun to walk seems slow for a second, and is not: how fast they were before tells
// more. It fades, so that one wrong place is forgotten.
void WalkerTrack::keep_pace(TimestampNs now_ns) {
  constexpr double kFades = 0.99;
  constexpr double kMaxGap_s = 1.5;  // older poses tell nothing of where somebody is now
  const double speed = speed_m_s().value_or(0);
  if (speed > kMinWalkingSpeed_m_s) pace_m_s_ = std::max(kFades * pace_m_s_, speed);
  newest_pose_age_s_ = std::min(age_s(now_ns), kMaxGap_s);
}

double WalkerTrack::walked_since_m() const {
  return is_standing() ? 0 : pace_m_s_ * newest_pose_age_s_;
}

double WalkerTrack::left_when_heard_m(double distance_m, double spoken_s) const {
  const double speed = is_standing() ? 0 : pace_m_s_;
  return distance_m - walked_since_m() - speed * (spoken_s + kReaction_s);
}

const Pose* WalkerTrack::pose(TimestampNs now_ns) const {
  return age_s(now_ns) <= kFresh_s ? &poses_.back().pose : nullptr;
}

double WalkerTrack::age_s(TimestampNs now_ns) const {
  return poses_.empty() ? std::numeric_limits<double>::infinity()
                        : seconds_between(poses_.back().at_ns, now_ns);
}

const WalkerTrack::TimedPose* WalkerTrack::a_while_ago() const {
  constexpr double kShortest_s = 0.35, kLongest_s = 1.6;
  const TimedPose* found = nullptr;
  for (const TimedPose& earlier : poses_) {
    const double ago_s = seconds_between(earlier.at_ns, poses_.back().at_ns);
    if (ago_s < kShortest_s || ago_s > kLongest_s) continue;
    // The nearest to a second ago.
    if (found == nullptr || ago_s >= 0.9) found = &earlier;
  }
  return found;
}

std::optional<double> WalkerTrack::speed_m_s() const {
  const TimedPose* const before = a_while_ago();
  if (before == nullptr) return std::nullopt;
  const TimedPose& newest = poses_.back();
  const double apart_m = (newest.pose.position_plan - before->pose.position_plan).norm();
  const double walked_m = std::max(0.0, apart_m - 2 * newest.pose.sigma_m);
  return walked_m / seconds_between(before->at_ns, newest.at_ns);
}

bool WalkerTrack::is_standing() const {
  const auto speed = speed_m_s();
  return speed && *speed < kStanding_m_s;
}

// Who turns with the camera in their hand moves it along an arc.
bool WalkerTrack::is_walking() const {
  constexpr double kArm_m = 0.4;
  const TimedPose* const before = a_while_ago();
  if (before == nullptr) return false;
  const TimedPose& newest = poses_.back();
  const double turned = turn_rad(before->pose.heading_rad, newest.pose.heading_rad);
  const double arc_m = 2 * kArm_m * std::abs(std::sin(turned / 2));
  return *speed_m_s() - arc_m / seconds_between(before->at_ns, newest.at_ns) > kMinWalkingSpeed_m_s;
}

bool WalkerTrack::may_turn() const {
  constexpr double kTurning_rad_s = 10 * kDegree_rad;
  constexpr double kNewer_s = 0.15, kOlder_s = 0.85;
  for (auto before = poses_.rbegin(); before != poses_.rend(); ++before) {
    const double ago_s = seconds_between(before->at_ns, poses_.back().at_ns);
    if (ago_s < kNewer_s) continue;
    if (ago_s > kOlder_s) return true;
    const double turned =
        std::abs(turn_rad(before->pose.heading_rad, poses_.back().pose.heading_rad));
    return turned > kTurning_rad_s * ago_s;
  }
  return true;
}

}  // namespace roomwise::guide
