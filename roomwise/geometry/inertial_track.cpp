#include "roomwise/geometry/inertial_track.h"

#include <algorithm>
#include <cmath>

namespace roomwise::geometry {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr TimestampNs kLongestGap_ns = 100'000'000;
// Two steps of somebody who walks, whose up and down and to and fro are then as good as 0; without
// turns less than a camera turns by much in.
constexpr TimestampNs kHalfWindow_ns = 500'000'000;
constexpr TimestampNs kHalfWindowOfForceAlone_ns = 100'000'000;
// Two sigmas of the offset of a phone's sensor (BMI160's data sheet): more is no gravity alone.
constexpr double kOffset_m_s2 = 2 * 0.04 * kGravity_m_s2;
// What the means of both halves differ by at most, two sigmas of each one.
constexpr double kMaxApart_rad = 2 * kUpSigma_rad;

double angle_between(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace

Quaterniond rotation_by(const Vector3d& vector_rad) {
  const double angle = vector_rad.norm();
  if (!(angle > 0)) return Quaterniond::Identity();
  return Quaterniond(Eigen::AngleAxisd(angle, vector_rad / angle));
}

Vector3d rotation_vector_rad(const Quaterniond& rotation) {
  const double sine = rotation.vec().norm();
  if (!(sine > 0)) return Vector3d::Zero();
  const double sign = rotation.w() < 0 ? -1 : 1;
  return sign * 2 * std::atan2(sine, std::abs(rotation.w())) / sine * rotation.vec();
}

InertialTrack::InertialTrack(std::vector<InertialSample> samples, bool tells_turns)
    : samples_(std::move(samples)), tells_turns_(tells_turns) {
  turned_.reserve(samples_.size());
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    if (i == 0 || !tells_turns_)
      turned_.push_back(Quaterniond::Identity());
    else
      turned_.push_back(turned(i - 1, samples_[i].timestamp_ns));
  }
}

std::optional<std::size_t> InertialTrack::interval(TimestampNs at_ns) const {
  const auto after = std::ranges::upper_bound(samples_, at_ns, {}, &InertialSample::timestamp_ns);
  if (after == samples_.begin()) return std::nullopt;
  const auto place = static_cast<std::size_t>(after - samples_.begin()) - 1;
  if (after != samples_.end()) return place;
  if (place == 0 || samples_[place].timestamp_ns != at_ns) return std::nullopt;
  return place - 1;
}

Quaterniond InertialTrack::turned(std::size_t interval, TimestampNs at_ns) const {
  const InertialSample& from = samples_[interval];
  const Vector3d mean_rad_s = (from.turning_rad_s + samples_[interval + 1].turning_rad_s) / 2;
  return (turned_[interval] * rotation_by(seconds_between(from.timestamp_ns, at_ns) * mean_rad_s))
      .normalized();
}

std::optional<Quaterniond> InertialTrack::world_from_camera(TimestampNs at_ns) const {
  if (!tells_turns_) {
    const auto up = up_camera(at_ns);
    if (!up) return std::nullopt;
    return Quaterniond::FromTwoVectors(*up, Vector3d::UnitZ());
  }
  const auto place = interval(at_ns);
  if (!place || !is_unbroken(at_ns, at_ns)) return std::nullopt;
  return turned(*place, at_ns);
}

std::optional<Quaterniond> InertialTrack::turn(TimestampNs from_ns, TimestampNs to_ns,
                                               const Vector3d& bias_rad_s) const {
  if (!tells_turns_ || to_ns < from_ns || !is_unbroken(from_ns, to_ns)) return std::nullopt;
  Quaterniond turned = Quaterniond::Identity();
  const std::size_t last = *interval(to_ns);
  for (std::size_t i = *interval(from_ns); i <= last; ++i) {
    const InertialSample &before = samples_[i], &after = samples_[i + 1];
    const double duration_s = seconds_between(std::max(from_ns, before.timestamp_ns),
                                              std::min(to_ns, after.timestamp_ns));
    turned = turned * rotation_by(duration_s *
                                  ((before.turning_rad_s + after.turning_rad_s) / 2 - bias_rad_s));
  }
  return turned.normalized();
}

std::optional<Vector3d> InertialTrack::turning_rad_s(TimestampNs at_ns) const {
  if (!tells_turns_ || !is_unbroken(at_ns, at_ns)) return std::nullopt;
  const std::size_t i = *interval(at_ns);
  const InertialSample &before = samples_[i], &after = samples_[i + 1];
  const double share = seconds_between(before.timestamp_ns, at_ns) /
                       seconds_between(before.timestamp_ns, after.timestamp_ns);
  return before.turning_rad_s + share * (after.turning_rad_s - before.turning_rad_s);
}

bool InertialTrack::is_unbroken(TimestampNs from_ns, TimestampNs to_ns) const {
  const auto first = interval(from_ns), last = interval(to_ns);
  if (!first || !last) return false;
  for (std::size_t i = *first; i <= *last; ++i) {
    if (samples_[i + 1].timestamp_ns - samples_[i].timestamp_ns > kLongestGap_ns) return false;
  }
  return true;
}

std::optional<Vector3d> InertialTrack::up_camera(TimestampNs at_ns) const {
  const TimestampNs half_ns = tells_turns_ ? kHalfWindow_ns : kHalfWindowOfForceAlone_ns;
  if (samples_.empty()) return std::nullopt;
  const TimestampNs from_ns = std::max(at_ns - half_ns, samples_.front().timestamp_ns);
  const TimestampNs to_ns = std::min(at_ns + half_ns, samples_.back().timestamp_ns);
  const auto place = interval(at_ns);
  // At the ends of a walk half of a half is enough.
  if (!place || 2 * (at_ns - from_ns) < half_ns || 2 * (to_ns - at_ns) < half_ns ||
      !is_unbroken(from_ns, to_ns)) {
    return std::nullopt;
  }
  const Quaterniond camera_from_first =
      tells_turns_ ? turned(*place, at_ns).conjugate() : Quaterniond::Identity();
  Vector3d before = Vector3d::Zero(), after = Vector3d::Zero();
  double count_before = 0, count_after = 0;
  auto one = std::ranges::lower_bound(samples_, from_ns, {}, &InertialSample::timestamp_ns);
  for (; one != samples_.end() && one->timestamp_ns <= to_ns; ++one) {
    const auto i = static_cast<std::size_t>(one - samples_.begin());
    const Vector3d force = camera_from_first * (turned_[i] * one->force_m_s2);
    (one->timestamp_ns < at_ns ? before : after) += force;
    (one->timestamp_ns < at_ns ? count_before : count_after) += 1;
  }
  if (!(count_before > 0 && count_after > 0)) return std::nullopt;
  const Vector3d mean = (before + after) / (count_before + count_after);
  if (!(std::abs(mean.norm() - kGravity_m_s2) < kOffset_m_s2) ||
      !(angle_between(before, after) < kMaxApart_rad)) {
    return std::nullopt;
  }
  return mean.normalized();
}

}  // namespace roomwise::geometry
