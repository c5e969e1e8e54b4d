#include "roomwise/guide/walker_track.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "roomwise/guide/legs.h"

namespace roomwise::guide {
namespace {

constexpr double kKept_s = 4;
// A direction holds for two seconds, and words take one.
constexpr double kFresh_s = 1.2;
// Nobody goes farther, at home.
constexpr double kQuickest_m_s = 1.8;
constexpr double kSlack_m = 0.6;
constexpr double kStanding_m_s = 0.15;

bool may_follow(const Pose& before, TimestampNs before_ns, const Pose& pose, TimestampNs at_ns) {
  const double reach_m = kSlack_m + 3 * std::max(before.sigma_m, pose.sigma_m) +
                         kQuickest_m_s * seconds_between(before_ns, at_ns);
  return (pose.position_gravity - before.position_gravity).norm() <= reach_m;
}

}  // namespace

void WalkerTrack::add(const Pose& pose, TimestampNs at_ns) {
  if (!stops_.empty() && at_ns <= stops_.back().at_ns) return;
  if (!stops_.empty() && !may_follow(stops_.back().pose, stops_.back().at_ns, pose, at_ns)) {
    const bool is_confirmed = doubted_ && doubted_->at_ns < at_ns &&
                              may_follow(doubted_->pose, doubted_->at_ns, pose, at_ns);
    doubted_ = Stop{pose, at_ns};
    if (!is_confirmed) return;
    stops_.clear();
  }
  doubted_.reset();
  // By so much, so that poses that tremble are no walk.
  const double stride_m = std::max(0.3, 3 * pose.sigma_m);
  if (!counted_to_ || stops_.empty()) counted_to_ = pose.position_gravity;
  const double ahead_m = (pose.position_gravity - *counted_to_).norm();
  if (ahead_m > stride_m) {
    walked_m_ += ahead_m;
    counted_to_ = pose.position_gravity;
  }
  stops_.push_back({pose, at_ns});
  while (seconds_between(stops_.front().at_ns, at_ns) > kKept_s) stops_.pop_front();
}

void WalkerTrack::forget() {
  stops_.clear();
  doubted_.reset();
}

const Pose* WalkerTrack::pose(TimestampNs now_ns) const {
  return age_s(now_ns) <= kFresh_s ? &stops_.back().pose : nullptr;
}

double WalkerTrack::age_s(TimestampNs now_ns) const {
  return stops_.empty() ? std::numeric_limits<double>::infinity()
                        : seconds_between(stops_.back().at_ns, now_ns);
}

double WalkerTrack::speed_m_s() const {
  if (stops_.size() < 2) return 0;
  const Stop& newest = stops_.back();
  const auto first = std::ranges::find_if(
      stops_, [&](const Stop& stop) { return seconds_between(stop.at_ns, newest.at_ns) <= 1.05; });
  const double seconds = seconds_between(first->at_ns, newest.at_ns);
  const double apart_m = (newest.pose.position_gravity - first->pose.position_gravity).norm();
  const double walked_m = std::max(0.0, apart_m - 2 * newest.pose.sigma_m);
  return seconds > 0 ? walked_m / seconds : 0;
}

bool WalkerTrack::is_standing() const {
  return speed_m_s() < kStanding_m_s;
}

double WalkerTrack::turned_rad(double seconds) const {
  double most_rad = 0;
  for (const Stop& stop : stops_) {
    if (seconds_between(stop.at_ns, stops_.back().at_ns) > seconds) continue;
    most_rad = std::max(most_rad,
                        std::abs(turn_rad(stop.pose.heading_rad, stops_.back().pose.heading_rad)));
  }
  return most_rad;
}

}  // namespace roomwise::guide
