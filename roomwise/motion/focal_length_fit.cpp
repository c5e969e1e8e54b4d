#include "roomwise/motion/focal_length_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "roomwise/geometry/robust_loss.h"

namespace roomwise::motion {
namespace {

using geometry::PinholeCamera;
using geometry::RigidTransform;
using geometry::Vector6d;

constexpr std::size_t kParts = 10;
constexpr std::size_t kMinViewsInPart = 3;
// Student's t of nine degrees of freedom, one-sided 99 %.
constexpr double kSure = 2.821;
// A focal length beyond twice or half the one given is none that this could find.
constexpr double kMaxLog = 0.7;
constexpr double kHuberSigmas = 2.0;
// What is told beyond depth cameras' other errors.
constexpr double kTolerated = 1.05;

// The camera with its focal length times a ratio, and the point as it would have measured it.
PinholeCamera with_ratio(PinholeCamera camera, double ratio) {
  camera.fx *= ratio;
  camera.fy *= ratio;
  return camera;
}
PointObservation with_ratio(PointObservation observation, double ratio) {
  observation.point_reference.head<2>() /= ratio;
  return observation;
}

// What two frames tell of the logarithm of the focal length once their pose is at its best: the
// gradient of the cost by it, and its curvature.
struct Told {
  double gradient = 0, curvature = 0;
};

using Matrix7d = Eigen::Matrix<double, 7, 7>;
using Vector7d = Eigen::Matrix<double, 7, 1>;

// The cost's curvature and gradient by the pose's twist and the focal length's logarithm.
std::pair<Matrix7d, Vector7d> linearize(const MatchedViews& views, const PinholeCamera& camera,
                                        const MotionOptions& options) {
  const ResidualModel& model = options.residuals;
  const RigidTransform current_from_reference = views.reference_from_current.inverse();
  Matrix7d hessian = Matrix7d::Zero();
  Vector7d gradient = Vector7d::Zero();
  for (const PointObservation& one : views.observations) {
    const Eigen::Vector3d error = residual(one, current_from_reference, camera, model);
    const double pixel_error = error.head<2>().norm() * model.pixel_sigma_px;
    const double disparity_error = std::abs(error.z()) * model.disparity_sigma_px;
    const bool is_inlier = pixel_error < options.inlier_px && disparity_error < options.inlier_px;
    if (!is_inlier) continue;
    const Eigen::Vector3d point = current_from_reference * one.point_reference;
    Eigen::Matrix<double, 3, 7> jacobian;
    jacobian.leftCols<6>() = residual_jacobian(one, current_from_reference, camera, model);
    // A longer focal length narrows what was measured, and widens what is seen.
    const Eigen::Vector3d narrowed(-one.point_reference.x(), -one.point_reference.y(), 0);
    jacobian.col(6) = point_residual_jacobian(point, one.depth_current_m > 0, camera, model) *
                      (current_from_reference.rotation * narrowed);
    jacobian(0, 6) += camera.fx * point.x() / point.z() / model.pixel_sigma_px;
    jacobian(1, 6) += camera.fy * point.y() / point.z() / model.pixel_sigma_px;
    const double weight = geometry::huber_loss(error.squaredNorm(), kHuberSigmas).derivative;
    hessian += weight * jacobian.transpose() * jacobian;
    gradient += weight * jacobian.transpose() * error;
  }
  return {hessian, gradient};
}

// Brings the pose to its best at the camera's focal length. Nothing where too little is seen.
Told refine(MatchedViews& views, const PinholeCamera& camera, const MotionOptions& options) {
  constexpr int kSteps = 6;
  for (int step = 0;; ++step) {
    const auto [hessian, gradient] = linearize(views, camera, options);
    const Eigen::LDLT<geometry::Matrix6d> of_pose(hessian.topLeftCorner<6, 6>());
    const Vector6d twist = -of_pose.solve(gradient.head<6>());
    const Vector6d coupled = of_pose.solve(hessian.topRightCorner<6, 1>());
    if (!twist.allFinite() || !coupled.allFinite()) return {};
    if (step == kSteps) {
      return {gradient(6) - coupled.dot(gradient.head<6>()),
              std::max(0.0, hessian(6, 6) - coupled.dot(hessian.topRightCorner<6, 1>()))};
    }
    views.reference_from_current = views.reference_from_current * RigidTransform::exp(twist);
  }
}

}  // namespace

double FocalLengthFit::low() const {
  return ratio * std::exp(-kSure * log_sigma);
}

double FocalLengthFit::high() const {
  return ratio * std::exp(kSure * log_sigma);
}

bool FocalLengthFit::contradicts() const {
  return low() > kTolerated || high() < 1 / kTolerated;
}

std::optional<FocalLengthFit> fit_focal_length(std::vector<MatchedViews> views,
                                               const PinholeCamera& camera,
                                               const MotionOptions& options) {
  if (views.size() < kParts * kMinViewsInPart) return std::nullopt;
  constexpr int kRounds = 8;
  double log_ratio = 0;
  std::array<Told, kParts> parts;
  Told all;
  for (int round = 0; round <= kRounds; ++round) {
    if (round > 0) log_ratio -= all.gradient / all.curvature;
    if (!(std::abs(log_ratio) < kMaxLog)) return std::nullopt;
    const double ratio = std::exp(log_ratio);
    parts = {};
    all = {};
    for (std::size_t i = 0; i < views.size(); ++i) {
      MatchedViews seen{{}, views[i].reference_from_current};
      for (const PointObservation& one : views[i].observations) {
        seen.observations.push_back(with_ratio(one, ratio));
      }
      const Told told = refine(seen, with_ratio(camera, ratio), options);
      views[i].reference_from_current = seen.reference_from_current;
      Told& part = parts[i * kParts / views.size()];
      part.gradient += told.gradient;
      part.curvature += told.curvature;
      all.gradient += told.gradient;
      all.curvature += told.curvature;
    }
  }
  double squares = 0;
  for (const Told& part : parts) squares += part.gradient * part.gradient;
  const double sigma = std::sqrt(squares * kParts / (kParts - 1)) / all.curvature;
  if (!(sigma < std::log(kTolerated))) return std::nullopt;
  return FocalLengthFit{std::exp(log_ratio), sigma};
}

}  // namespace roomwise::motion
