#include "roomwise/mapping/frontend/motion_prediction.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace roomwise::mapping {
namespace {

using geometry::RigidTransform;

// How far a hand-held camera's motion is from one of constant velocity.
constexpr double kTranslationSigma_m = 0.02;
constexpr double kTranslationSigma_m_s = 0.4;
constexpr double kRotationSigma_rad = 0.05;
constexpr double kRotationSigma_rad_s = 0.5;
constexpr double kMaxExtrapolation = 3;

// The motion of `ratio` times as long.
RigidTransform scaled(const RigidTransform& motion, double ratio) {
  const Eigen::AngleAxisd turn(motion.rotation);
  return {Eigen::Quaterniond(Eigen::AngleAxisd(ratio * turn.angle(), turn.axis())),
          ratio * motion.translation};
}

}  // namespace

double walk_sigma_m(double ahead_s) {
  return kTranslationSigma_m + kTranslationSigma_m_s * ahead_s;
}

motion::PosePrior predict_motion(const std::optional<StampedMotion>& older,
                                 const StampedMotion& newer, TimestampNs later_ns) {
  const double ahead_s = seconds_between(newer.timestamp_ns, later_ns);
  // How far a person's movement can differ from what is predicted.
  const double translation_m = walk_sigma_m(ahead_s);
  const double rotation_rad = kRotationSigma_rad + kRotationSigma_rad_s * ahead_s;
  const RigidTransform& pose = newer.keyframe_from_camera;
  const double behind_s = older ? seconds_between(older->timestamp_ns, newer.timestamp_ns) : 0;
  if (behind_s > 0) {
    const RigidTransform step = older->keyframe_from_camera.inverse() * pose;
    const double ratio = std::min(ahead_s / behind_s, kMaxExtrapolation);
    motion::PosePrior prior =
        motion::PosePrior::around(pose * scaled(step, ratio), translation_m, rotation_rad);
    prior.other_start = pose;
    return prior;
  }
  return motion::PosePrior::around(pose, 2 * translation_m, 2 * rotation_rad);
}

}  // namespace roomwise::mapping
