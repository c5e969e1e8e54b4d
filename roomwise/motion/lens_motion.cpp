#include "roomwise/motion/lens_motion.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "roomwise/geometry/levenberg_marquardt.h"
#include "roomwise/geometry/robust_loss.h"
#include "roomwise/motion/damped_step.h"
#include "roomwise/motion/pnp_ransac.h"

namespace roomwise::motion {
namespace {

using geometry::Matrix6d;
using geometry::PinholeCamera;
using geometry::RigidTransform;
using Matrix8d = Eigen::Matrix<double, 8, 8>;
using Vector8d = Eigen::Matrix<double, 8, 1>;

constexpr double kLensHuberSigmas = 2.0;

// A pose and a lens.
struct PosedLens {
  RigidTransform reference_from_current;
  Eigen::Vector2d lens;  // IntrinsicsEstimate::mean
};

// What levenberg_marquardt.h minimises: the distances of the pixels from where pose and lens put
// the points, and of the lens from what was known of it. Variables: a twist (omega, v) of the
// current frame, the logarithm of the focal length, k1.
class PosedLensProblem {
 public:
  PosedLensProblem(std::span<const PointObservation> observations, int width, int height,
                   const IntrinsicsEstimate& prior, const PosedLens& start, double pixel_sigma_px)
      : observations_(observations),
        width_(width),
        height_(height),
        prior_(prior),
        pixel_sigma_px_(pixel_sigma_px),
        at_(start) {}

  [[nodiscard]] double cost() const {
    const Eigen::Vector2d off = at_.lens - prior_.mean;
    double cost = off.dot(prior_.information * off);
    for_each_residual([&](const Eigen::Vector3d&, const Eigen::Vector2d& error) {
      cost += geometry::huber_loss(error.squaredNorm(), kLensHuberSigmas).value;
    });
    return cost;
  }
  void linearize() {
    hessian_.setZero();
    hessian_.bottomRightCorner<2, 2>() = prior_.information;
    rhs_.setZero();
    rhs_.tail<2>() = prior_.information * (prior_.mean - at_.lens);
    for_each_residual([&](const Eigen::Vector3d& point, const Eigen::Vector2d& error) {
      if (!error.allFinite()) return;
      const Eigen::Matrix<double, 2, 8> by_all = jacobian(point);
      const double weight = geometry::huber_loss(error.squaredNorm(), kLensHuberSigmas).derivative;
      hessian_ += weight * by_all.transpose() * by_all;
      rhs_ -= weight * by_all.transpose() * error;
    });
  }
  [[nodiscard]] std::optional<geometry::DampedStep> solve(double damping) {
    return solve_damped(hessian_, rhs_, damping, step_);
  }
  void take_step() {
    before_ = at_;
    at_.reference_from_current = at_.reference_from_current * RigidTransform::exp(step_.head<6>());
    at_.lens += step_.tail<2>();
  }
  void undo_step() { at_ = before_; }

  [[nodiscard]] const PosedLens& at() const { return at_; }
  [[nodiscard]] const Matrix8d& hessian() const { return hessian_; }

 private:
  [[nodiscard]] PinholeCamera camera() const {
    return IntrinsicsEstimate{at_.lens, prior_.information}.camera(width_, height_);
  }
  // Of the pixel of a point in the current frame, by all variables, in sigmas.
  [[nodiscard]] Eigen::Matrix<double, 2, 8> jacobian(const Eigen::Vector3d& point) const {
    const PinholeCamera camera = this->camera();
    const double k1 = at_.lens[1];
    const Eigen::Vector2d p = point.head<2>() / point.z();
    const double r2 = p.squaredNorm();
    Eigen::Matrix<double, 2, 3> by_point;
    by_point << 1, 0, -p.x(), 0, 1, -p.y();
    by_point /= point.z();
    Eigen::Matrix<double, 3, 6> by_twist;  // the point changes by point x omega - v
    by_twist << geometry::skew_symmetric(point), -Eigen::Matrix3d::Identity();
    Eigen::Matrix<double, 2, 8> by_all;
    by_all.leftCols<6>() =
        ((1 + k1 * r2) * Eigen::Matrix2d::Identity() + 2 * k1 * p * p.transpose()) * by_point *
        by_twist;
    by_all.col(6) = (1 + k1 * r2) * p;
    by_all.col(7) = r2 * p;
    return camera.fx / pixel_sigma_px_ * by_all;
  }
  template <typename Visit>
  void for_each_residual(const Visit& visit) const {
    const PinholeCamera camera = this->camera();
    const RigidTransform current_from_reference = at_.reference_from_current.inverse();
    for (const PointObservation& observation : observations_) {
      const Eigen::Vector3d point = current_from_reference * observation.point_reference;
      if (point.z() > 0) {
        visit(point, (camera.project(point) - observation.pixel_current) / pixel_sigma_px_);
      } else {
        visit(point, Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity()));
      }
    }
  }

  std::span<const PointObservation> observations_;
  const int width_, height_;
  const IntrinsicsEstimate& prior_;
  const double pixel_sigma_px_;
  PosedLens at_, before_;
  Matrix8d hessian_;
  Vector8d rhs_, step_;
};

std::vector<PointObservation> lens_inliers(std::span<const PointObservation> observations,
                                           const PosedLens& posed, const PinholeCamera& camera,
                                           double inlier_px) {
  const RigidTransform current_from_reference = posed.reference_from_current.inverse();
  std::vector<PointObservation> inliers;
  for (const PointObservation& observation : observations) {
    const Eigen::Vector3d point = current_from_reference * observation.point_reference;
    if (point.z() > 0 && (camera.project(point) - observation.pixel_current).norm() < inlier_px) {
      inliers.push_back(observation);
    }
  }
  return inliers;
}

// What is left of a curvature by two groups of variables when the second is left free.
template <typename A, typename B, typename C>
auto marginal(const A& own, const B& cross, const C& other) {
  return (own - cross * other.ldlt().solve(cross.transpose())).eval();
}

// Pose and lens, refined together on the inliers.
LensMotion refine(std::span<const PointObservation> inliers, int width, int height,
                  const IntrinsicsEstimate& prior, const PosedLens& start,
                  const MotionOptions& options) {
  constexpr geometry::MinimizerOptions kOptions{.max_iterations = 20, .min_step_length = 1e-9};
  PosedLensProblem problem(inliers, width, height, prior, start, options.residuals.pixel_sigma_px);
  geometry::minimize(problem, kOptions);
  problem.linearize();
  const Matrix6d pose = problem.hessian().topLeftCorner<6, 6>();
  const Eigen::Matrix<double, 6, 2> cross = problem.hessian().topRightCorner<6, 2>();
  const Eigen::Matrix2d lens = problem.hessian().bottomRightCorner<2, 2>();
  LensMotion refined;
  refined.motion.pose.reference_from_current = problem.at().reference_from_current;
  refined.motion.pose.information = edge_information(marginal(pose, cross, lens));
  refined.motion.pose.rms = std::sqrt(problem.cost() / static_cast<double>(inliers.size()));
  refined.lens = {problem.at().lens, marginal(lens, cross.transpose(), pose)};
  return refined;
}

}  // namespace

LensMotion estimate_motion_and_lens(std::span<const PointObservation> observations, int width,
                                    int height, const IntrinsicsEstimate& lens,
                                    const MotionOptions& options, RandomStream random) {
  LensMotion result;
  result.lens = lens;
  MotionOutcome& outcome = result.motion;
  const auto stop = [&](MotionStatus status) {
    outcome.status = status;
    return result;
  };
  const int matches = outcome.matches = static_cast<int>(observations.size());
  if (matches < options.min_matches) return stop(MotionStatus::kTooFewMatches);
  const PnpHypothesis hypothesis = solve_pnp_ransac(
      observations, [&](RandomStream& draws) { return lens.sample_camera(width, height, draws); },
      lens.near_draw_probability(), options, random);
  const auto enough = [&](int inliers) {
    return inliers >= options.min_inliers && inliers >= options.min_inlier_ratio * matches;
  };
  outcome.inliers = hypothesis.inliers;
  if (!enough(outcome.inliers)) return stop(MotionStatus::kTooFewInliers);

  // Refining moves pose and lens, which changes who is an inlier: a few rounds settle it.
  constexpr int kRounds = 6;
  PosedLens posed{hypothesis.current_from_reference.inverse(), lens.mean};
  posed.lens[0] = std::log(hypothesis.camera.fx / std::max(width, height));
  for (int round = 0; round < kRounds; ++round) {
    const PinholeCamera camera =
        IntrinsicsEstimate{posed.lens, lens.information}.camera(width, height);
    const auto inliers = lens_inliers(observations, posed, camera, options.inlier_px);
    outcome.inliers = static_cast<int>(inliers.size());
    if (!enough(outcome.inliers)) return stop(MotionStatus::kTooFewInliers);
    result = refine(inliers, width, height, lens, posed, options);
    outcome.matches = matches;
    outcome.inliers = static_cast<int>(inliers.size());
    posed = {outcome.pose.reference_from_current, result.lens.mean};
  }
  const RigidTransform& motion = outcome.pose.reference_from_current;
  if (!motion.is_finite() || !result.lens.mean.allFinite())
    return stop(MotionStatus::kTooFewInliers);
  if (motion.distance_m() > options.max_translation_m ||
      motion.angle_rad() > options.max_rotation_rad) {
    return stop(MotionStatus::kMotionTooLarge);
  }
  return stop(MotionStatus::kFound);
}

}  // namespace roomwise::motion
