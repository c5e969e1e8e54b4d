#include "roomwise/mapping/localization/localization.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace roomwise::mapping {
namespace {

double worst_sigma(const geometry::Matrix6d& information, Eigen::Index first) {
  const Eigen::LDLT<geometry::Matrix6d> solver(information);
  if (solver.info() != Eigen::Success || !(solver.vectorD().minCoeff() > 0)) {
    return std::numeric_limits<double>::infinity();
  }
  const geometry::Matrix6d covariance = solver.solve(geometry::Matrix6d::Identity());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> block(covariance.block<3, 3>(first, first),
                                                             Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, block.eigenvalues()[2]));
}

}  // namespace

double PoseModel::probability(const PoseEvidence& evidence) const {
  double log_odds = bias;
  for (std::size_t i = 0; i < evidence.size(); ++i) log_odds += weights[i] * evidence[i];
  return 1 / (1 + std::exp(-log_odds));
}

PoseModel PoseModel::fitted() {
  return {7.9080, {1.2611, 0.5250, 3.7270, -0.0380}, 0.96083};
}

LocalizerOptions::LocalizerOptions() {
  // Of all that a place shows much was moved or lies in another light.
  features.checks_edge_lengths = true;
  features.min_inlier_ratio = 0.06;
  features.max_iterations = 2000;
  views.gray_sigma = 20;
  shape_views.gray_sigma = 200;
}

Expected<void> LocalizerOptions::validate() const {
  ROOMWISE_RETURN_IF_ERROR(features.validate());
  ROOMWISE_RETURN_IF_ERROR(views.validate());
  ROOMWISE_RETURN_IF_ERROR(shape_views.validate());
  if (similar < 1 || places < 1 || together < 1 || similar_shapes < 1) {
    return fail(
        "similar = {}, places = {}, together = {} and similar_shapes = {} must be at least 1",
        similar, places, together, similar_shapes);
  }
  if (min_hypothesis_inliers < 4) {
    return fail("min_hypothesis_inliers = {} must be at least 4", min_hypothesis_inliers);
  }
  if (!(color_only.min_probability >= 0 && color_only.min_probability <= 1)) {
    return fail("color_only.min_probability = {} must be between 0 and 1",
                color_only.min_probability);
  }
  if (sure_inliers < 0) return fail("sure_inliers = {} must not be negative", sure_inliers);
  for (const auto& [name, share] :
       {std::pair("sure_overlap", sure_overlap), std::pair("sure_agreeing", sure_agreeing),
        std::pair("max_rival_share", max_rival_share),
        std::pair("sure_pattern_correlation", sure_pattern_correlation),
        std::pair("min_confirmation", min_confirmation),
        std::pair("confirmed_overlap", confirmed_overlap),
        std::pair("max_confirmed_through", max_confirmed_through)}) {
    if (!(share >= 0 && share <= 1)) return fail("{} = {} must be between 0 and 1", name, share);
  }
  if (!(clearly_more_inliers >= 1)) {
    return fail("clearly_more_inliers = {} must be at least 1", clearly_more_inliers);
  }
  if (!(min_normal_eigenvalue >= 0))
    return fail("min_normal_eigenvalue = {} must not be negative", min_normal_eigenvalue);
  for (const auto& [name, value] :
       {std::pair("place_m", place_m), std::pair("place_rad", place_rad),
        std::pair("shape_sigma_m", shape_sigma_m), std::pair("shape_sigma_rad", shape_sigma_rad),
        std::pair("sure_support", sure_support), std::pair("min_confirmation", min_confirmation),
        std::pair("max_position_sigma_m", max_position_sigma_m),
        std::pair("max_rotation_sigma_rad", max_rotation_sigma_rad), std::pair("same_m", same_m),
        std::pair("same_rad", same_rad)}) {
    if (!(value > 0)) return fail("{} = {} must be positive", name, value);
  }
  return {};
}

std::string_view to_string(LocalizationStatus status) {
  switch (status) {
    case LocalizationStatus::kNothingSimilar:
      return "nothing on the map looks like it";
    case LocalizationStatus::kNoMotion:
      return "too little of it is on the map";
    case LocalizationStatus::kUnconfirmed:
      return "a few features hint at a place, and nothing confirms it";
    case LocalizationStatus::kContradicted:
      return "the depth images contradict the pose";
    case LocalizationStatus::kDegenerate:
      return "a bare wall is the same in many places";
    case LocalizationStatus::kDoubtful:
      return "too little speaks for the pose";
    case LocalizationStatus::kVague:
      return "the pose is not known well enough";
    case LocalizationStatus::kAmbiguous:
      return "it looks like two places";
    case LocalizationStatus::kFound:
      return "found";
  }
  return "unknown";
}

PoseEvidence Localization::evidence() const {
  return {std::log(inliers), std::log(static_cast<double>(inliers) / matches), std::log(coverage),
          std::log((rival_inliers + 1.0) / inliers)};
}

double Localization::position_sigma_m() const {
  return worst_sigma(information, 0);
}

// The quaternion's vector part is half the angle.
double Localization::rotation_sigma_rad() const {
  return 2 * worst_sigma(information, 3);
}

}  // namespace roomwise::mapping
