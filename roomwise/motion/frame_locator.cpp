#include "roomwise/motion/frame_locator.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <utility>

namespace roomwise::motion {
namespace {

bool is_sure(const ViewAlignment& alignment, const PosePrior& prior,
             const LocatorOptions& options) {
  if (!alignment.found || alignment.is_ambiguous || alignment.pose.rms > options.sure_rms ||
      alignment.agreement.overlap < options.sure_overlap ||
      alignment.agreement.agreeing < options.sure_agreeing ||
      squared_mahalanobis(alignment.pose.reference_from_current, prior) >
          options.sure_squared_mahalanobis) {
    return false;
  }
  const Eigen::SelfAdjointEigenSolver<geometry::Matrix6d> solver(alignment.measured_information,
                                                                 Eigen::EigenvaluesOnly);
  return solver.eigenvalues()[0] >= 1 / (options.sure_sigma * options.sure_sigma);
}

bool is_large(const geometry::RigidTransform& motion, const LocatorOptions& options) {
  return motion.distance_m() >= options.cross_check_min_translation_m ||
         motion.angle_rad() >= options.cross_check_min_rotation_rad;
}

// Not the same minimum, found from another side.
bool is_elsewhere(const RefinedPose& pose, const RefinedPose& than) {
  constexpr double kTranslation_m = 0.03;
  constexpr double kRotation_rad = 0.02;
  const geometry::RigidTransform apart =
      than.reference_from_current.inverse() * pose.reference_from_current;
  return apart.distance_m() > kTranslation_m || apart.angle_rad() > kRotation_rad;
}

MotionOutcome found_by_views(const ViewAlignment& alignment) {
  MotionOutcome outcome;
  outcome.status = MotionStatus::kFound;
  outcome.pose = alignment.pose;
  return outcome;
}

// What features say, as a prior for the alignment of views: their own uncertainty, and what their
// residuals do not show.
PosePrior prior_from(const RefinedPose& pose) {
  constexpr double kTranslation_m = 0.01;
  constexpr double kHalfAngle = 0.5 * 0.005;
  return {pose.reference_from_current,
          with_systematic_error(pose.information, kTranslation_m, kHalfAngle)};
}

}  // namespace

Expected<void> LocatorOptions::validate() const {
  ROOMWISE_RETURN_IF_ERROR(features.validate());
  ROOMWISE_RETURN_IF_ERROR(views.validate());
  if (!(sure_rms > 0) || !(max_rms >= sure_rms)) {
    return fail("sure_rms = {} must be positive and not above max_rms = {}", sure_rms, max_rms);
  }
  for (const auto& [name, value] :
       {std::pair("sure_sigma", sure_sigma),
        std::pair("cross_check_min_translation_m", cross_check_min_translation_m),
        std::pair("cross_check_min_rotation_rad", cross_check_min_rotation_rad)}) {
    if (!(value > 0)) return fail("{} = {} must be positive", name, value);
  }
  if (!(sure_squared_mahalanobis > 0) || !(max_squared_mahalanobis >= sure_squared_mahalanobis)) {
    return fail(
        "sure_squared_mahalanobis = {} must be positive and not above max_squared_mahalanobis = {}",
        sure_squared_mahalanobis, max_squared_mahalanobis);
  }
  for (const auto& [name, share] :
       {std::pair("sure_overlap", sure_overlap), std::pair("sure_agreeing", sure_agreeing)}) {
    if (!(share >= 0 && share <= 1)) return fail("{} = {} must be between 0 and 1", name, share);
  }
  if (min_inliers_against_prior < 0) {
    return fail("min_inliers_against_prior = {} must not be negative", min_inliers_against_prior);
  }
  return {};
}

MotionOutcome locate_frame(const FrameMeasurements& reference, const FrameMeasurements& current,
                           const std::optional<PosePrior>& prior,
                           const geometry::PinholeCamera& camera, const LocatorOptions& options,
                           RandomStream random) {
  const auto fits = [&](const ViewAlignment& alignment) {
    return alignment.found && alignment.pose.rms <= options.max_rms;
  };
  const auto contradicts_prior = [&](const RefinedPose& pose) {
    return prior && squared_mahalanobis(pose.reference_from_current, *prior) >
                        options.max_squared_mahalanobis;
  };
  if (reference.view().empty() || current.view().empty()) {
    return estimate_motion(reference.features(), current.features(), camera, options.features,
                           random);
  }
  std::optional<ViewAlignment> predicted;
  if (prior) {
    predicted = align_views(reference.view(), current.view(), *prior, options.views);
    if (contradicts_prior(predicted->pose)) predicted->found = false;
    if (!options.rests_on_prior || !options.counts_prior)
      predicted->pose.information = predicted->measured_information;
  }
  const bool is_predicted = predicted && is_sure(*predicted, *prior, options);
  if (is_predicted && !is_large(predicted->pose.reference_from_current, options) &&
      !is_large(prior->reference_from_current, options)) {
    return found_by_views(*predicted);
  }

  MotionOutcome outcome =
      estimate_motion(reference.features(), current.features(), camera, options.features, random);
  const auto align_from_features = [&] {
    return align_views(reference.view(), current.view(), prior_from(outcome.pose), options.views);
  };
  if (is_predicted) {
    // What features say, if it is something else, is one start more: the better fit counts.
    if (!outcome.found() || !is_elsewhere(outcome.pose, predicted->pose)) {
      return found_by_views(*predicted);
    }
    const ViewAlignment other = align_from_features();
    if (!other.found || contradicts_prior(other.pose) ||
        !is_elsewhere(other.pose, predicted->pose) || other.pose.rms >= predicted->pose.rms) {
      return found_by_views(*predicted);
    }
    outcome.pose = other.pose;
    return outcome;
  }
  if (outcome.found() && contradicts_prior(outcome.pose) &&
      outcome.inliers < options.min_inliers_against_prior) {
    outcome.status = MotionStatus::kContradictsPrior;
  } else if (outcome.found()) {
    const ViewAlignment refined = align_from_features();
    if (fits(refined)) {
      outcome.pose = refined.pose;
      return outcome;
    }
    const ViewAgreement agreement =
        compare_views(reference.view(), current.view(), outcome.pose.reference_from_current);
    if (agreement.agreeing >= options.views.min_agreeing &&
        agreement.seen_through <= options.views.max_seen_through) {
      return outcome;
    }
    outcome.status = MotionStatus::kContradicted;
  }
  if (options.rests_on_prior && predicted && !predicted->is_ambiguous && fits(*predicted)) {
    // Not sure, so believed less: a bare wall fits in many places.
    constexpr double kSigmas = 7;
    outcome = found_by_views(*predicted);
    outcome.pose.information /= kSigmas * kSigmas;
    outcome.rests_on_prior = true;
  }
  return outcome;
}

}  // namespace roomwise::motion
