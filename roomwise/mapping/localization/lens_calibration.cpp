#include "roomwise/mapping/localization/lens_calibration.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace roomwise::mapping {
namespace {

using motion::IntrinsicsEstimate;

// What the residuals of one view do not show, of (logarithm of the focal length, k1): the map's own
// errors, a principal point beside the middle.
constexpr double kViewFocalSigma = 0.02, kViewDistortionSigma = 0.02;
// The focal length is never known better than this, relative to it: lenses breathe as they focus.
constexpr double kMinFocalSigma = 0.01;
// Views no further apart and no further turned than this are one, m and rad.
constexpr double kSameView_m = 0.4, kSameView_rad = 0.3;
// After so many pictures without a pose one is asked as of another lens, which costs most.
constexpr int kManyWithoutPose = 10;
// By then a lens is known as well as it can be, and what older views told is a small part of it.
constexpr std::size_t kMaxCounted = 200;
// Two focal lengths this many standard deviations apart are of two lenses.
constexpr double kOtherLensSigmas = 5;

// What a picture told alone, as information and information times mean.
struct Told {
  Eigen::Matrix2d information;
  Eigen::Vector2d weighted_mean;
};

// That is the difference of what was known before and after it, weakened by what it does not show:
// (I^-1 + S)^-1 = (I S + 1)^-1 I.
Told told_by(const IntrinsicsEstimate& before, const IntrinsicsEstimate& after) {
  const Eigen::Matrix2d information = after.information - before.information;
  const Eigen::Vector2d weighted =
      after.information * after.mean - before.information * before.mean;
  const Eigen::Vector2d systematic(kViewFocalSigma * kViewFocalSigma,
                                   kViewDistortionSigma * kViewDistortionSigma);
  const Eigen::Matrix2d weaken =
      (information * systematic.asDiagonal() + Eigen::Matrix2d::Identity()).inverse();
  return {weaken * information, weaken * weighted};
}

IntrinsicsEstimate with(const IntrinsicsEstimate& known, const Told& told) {
  IntrinsicsEstimate both;
  both.information = known.information + told.information;
  both.mean = both.information.inverse() * (known.information * known.mean + told.weighted_mean);
  const double share = both.relative_focal_sigma() / kMinFocalSigma;
  both.information *= std::min(1.0, share * share);
  return both;
}

bool are_of_two_lenses(const IntrinsicsEstimate& a, const IntrinsicsEstimate& b) {
  return std::abs(a.mean[0] - b.mean[0]) >
         kOtherLensSigmas * std::hypot(a.relative_focal_sigma(), b.relative_focal_sigma());
}

// Only what a doubt remains of says nothing; a vague pose is right, and says how much it knows.
bool has_sure_pose(const Localization& answer) {
  return answer.found() || answer.status == LocalizationStatus::kVague;
}

}  // namespace

bool LensCalibration::is_asked_anew() const {
  return without_pose_ > 0 && without_pose_ % kManyWithoutPose == 0;
}

IntrinsicsEstimate LensCalibration::estimate() const {
  return is_asked_anew() ? IntrinsicsEstimate::typical_of_phones() : known_;
}

bool LensCalibration::counts(const geometry::RigidTransform& world_from_camera) const {
  return std::ranges::none_of(counted_, [&](const geometry::RigidTransform& counted) {
    const geometry::RigidTransform apart = counted.inverse() * world_from_camera;
    return apart.distance_m() <= kSameView_m && apart.angle_rad() <= kSameView_rad;
  });
}

bool LensCalibration::add(const Localization& answer) {
  if (!answer.lens) return false;
  if (!has_sure_pose(answer)) {
    ++without_pose_;
    return false;
  }
  const IntrinsicsEstimate asked = estimate();
  if (is_asked_anew() && are_of_two_lenses(known_, *answer.lens)) {
    known_ = asked;
    counted_.clear();
  }
  without_pose_ = 0;
  if (!counts(answer.world_from_camera)) return false;
  if (counted_.size() >= kMaxCounted) counted_.erase(counted_.begin());
  counted_.push_back(answer.world_from_camera);
  known_ = with(known_, told_by(asked, *answer.lens));
  return true;
}

}  // namespace roomwise::mapping
