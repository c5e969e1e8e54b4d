#include "roomwise/mapping/frontend/gyroscope.h"

#include <cmath>

namespace roomwise::mapping {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

// Of a phone's sensor, by the data sheet of Bosch's BMI160: its scale, and how its bias changes
// with the temperature (0.05 degrees a second a Kelvin, of which a minute brings one).
constexpr double kScaleSigma = 0.03;
constexpr double kBiasWalk_rad_s = 1.1e-4;  // in a second; with the square root of time
// By so much picture and sensor may be out of step, rows that are exposed one after the other among
// it; as depth and picture may be (UpMeasurementOptions::delay_s). Where it turns evenly that
// changes nothing.
constexpr double kOutOfStep_s = 0.028;
constexpr double kLeastSigma_rad = 0.001;
// What pictures err by although they are sure.
constexpr double kPicturesSigma_rad = 0.01;
// Longer ago somebody may have turned to anywhere.
constexpr double kLongestLesson_s = 1;
// e^T Omega e with three degrees of freedom is above this once in a thousand times.
constexpr double kContradiction = 16.3;

}  // namespace

std::optional<MeasuredTurn> Gyroscope::turn(TimestampNs from_ns, TimestampNs to_ns) const {
  const auto turned = track_.turn(from_ns, to_ns, bias_rad_s_);
  if (!turned) return std::nullopt;
  const double angle_rad = geometry::rotation_vector_rad(*turned).norm();
  const double duration_s = seconds_between(from_ns, to_ns);
  const Vector3d change_rad_s = *track_.turning_rad_s(to_ns) - *track_.turning_rad_s(from_ns);
  return MeasuredTurn{
      *turned, std::hypot(kLeastSigma_rad,
                          std::hypot(kScaleSigma * angle_rad, kOutOfStep_s * change_rad_s.norm(),
                                     bias_sigma_rad_s_ * duration_s))};
}

void Gyroscope::learn(TimestampNs from_ns, TimestampNs to_ns, const Quaterniond& shown) {
  const double duration_s = seconds_between(from_ns, to_ns);
  if (!(duration_s > 0) || duration_s > kLongestLesson_s) return;
  bias_sigma_rad_s_ = std::hypot(bias_sigma_rad_s_, kBiasWalk_rad_s * std::sqrt(duration_s));
  const auto expected = turn(from_ns, to_ns);
  if (!expected) return;
  // What it turned too far, in the frame at the end: about that at the beginning, the turns between
  // two pictures being small.
  const Vector3d excess_rad =
      geometry::rotation_vector_rad(shown.conjugate() * expected->from_from_to);
  const double variance =
      expected->sigma_rad * expected->sigma_rad + kPicturesSigma_rad * kPicturesSigma_rad;
  if (excess_rad.squaredNorm() > kContradiction * variance) return;
  const double bias_variance = bias_sigma_rad_s_ * bias_sigma_rad_s_;
  const double gain = bias_variance * duration_s / variance;  // the bias' own part is in variance
  bias_rad_s_ += gain * excess_rad;
  bias_sigma_rad_s_ *= std::sqrt(1 - gain * duration_s);
}

}  // namespace roomwise::mapping
