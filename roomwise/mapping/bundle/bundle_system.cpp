#include "roomwise/mapping/bundle/bundle_system.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "roomwise/mapping/graph/edge_error.h"

namespace roomwise::mapping {
namespace {

using geometry::Matrix6d;
using geometry::Vector6d;

// Directions about which nothing is known are held by a small part of the largest weight.
constexpr double kMinWeight = 1e-9;

auto segment(Eigen::VectorXd& numbers, std::size_t camera) {
  return numbers.segment<6>(6 * static_cast<Eigen::Index>(camera));
}

}  // namespace

ViewCost view_cost(double squares, double kernel_sigmas) {
  const double kernel = kernel_sigmas * kernel_sigmas;
  return {kernel * std::log1p(squares / kernel), 1 / (1 + squares / kernel)};
}

BundleSystem::BundleSystem(const Bundle& bundle, const BundleOptions& options)
    : bundle_(bundle),
      options_(options),
      free_count_(bundle.cameras.size() - bundle.fixed),
      points_(bundle.landmarks.size()) {
  find_pairs();
  find_slots();
  cholesky_.emplace(free_count_, pairs_);
}

void BundleSystem::find_pairs() {
  std::vector<std::vector<std::uint32_t>> higher(free_count_);  // by the lower camera
  const auto add = [&](std::size_t a, std::size_t b) {
    if (!is_free(a) || !is_free(b)) return;
    higher[std::min(a, b) - bundle_.fixed].push_back(
        static_cast<std::uint32_t>(std::max(a, b) - bundle_.fixed));
  };
  for (const PoseGraphEdge& edge : bundle_.edges) add(edge.from, edge.to);
  std::size_t views = 0;
  for (const Landmark& landmark : bundle_.landmarks) {
    first_view_.push_back(views);
    views += landmark.views.size();
    for (std::size_t k = 0; k < landmark.views.size(); ++k)
      for (std::size_t l = 0; l < k; ++l) add(landmark.views[k].camera, landmark.views[l].camera);
  }
  mixed_.resize(views);
  for (std::uint32_t a = 0; a < free_count_; ++a) {
    std::ranges::sort(higher[a]);
    higher[a].erase(std::ranges::unique(higher[a]).begin(), higher[a].end());
    first_pair_.push_back(pairs_.size());
    for (const std::uint32_t b : higher[a]) pairs_.emplace_back(a, b);
  }
  first_pair_.push_back(pairs_.size());
}

std::size_t BundleSystem::slot_of(std::size_t a, std::size_t b) const {
  const auto first = pairs_.begin() + static_cast<std::ptrdiff_t>(first_pair_[a]);
  const auto end = pairs_.begin() + static_cast<std::ptrdiff_t>(first_pair_[a + 1]);
  const BlockPair wanted(static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b));
  return static_cast<std::size_t>(std::lower_bound(first, end, wanted) - pairs_.begin());
}

void BundleSystem::find_slots() {
  for (const Landmark& landmark : bundle_.landmarks) {
    for (std::size_t k = 0; k < landmark.views.size(); ++k) {
      if (!is_free(landmark.views[k].camera)) continue;
      for (std::size_t l = 0; l < k; ++l) {
        if (!is_free(landmark.views[l].camera)) continue;
        const auto [a, b] = std::minmax({landmark.views[k].camera, landmark.views[l].camera});
        slots_.push_back(static_cast<std::uint32_t>(slot_of(a - bundle_.fixed, b - bundle_.fixed)));
      }
    }
  }
}

void BundleSystem::add_edge(const PoseGraphEdge& edge) {
  const auto& from = bundle_.cameras[edge.from].world_from_camera;
  const auto& to = bundle_.cameras[edge.to].world_from_camera;
  const Vector6d error = edge_error(edge.from_from_to, from, to);
  const EdgeJacobians by = edge_jacobians(edge.from_from_to, from, to);
  const Matrix6d from_weight = by.by_from.transpose() * edge.information;
  const Matrix6d to_weight = by.by_to.transpose() * edge.information;
  const std::size_t a = edge.from - bundle_.fixed;
  const std::size_t b = edge.to - bundle_.fixed;
  if (is_free(edge.from)) {
    diagonal_[a] += from_weight * by.by_from;
    segment(gradient_, a) -= from_weight * error;
  }
  if (is_free(edge.to)) {
    diagonal_[b] += to_weight * by.by_to;
    segment(gradient_, b) -= to_weight * error;
  }
  if (!is_free(edge.from) || !is_free(edge.to)) return;
  if (a < b) {
    off_diagonal_[slot_of(a, b)] += from_weight * by.by_to;
  } else {
    off_diagonal_[slot_of(b, a)] += to_weight * by.by_from;
  }
}

void BundleSystem::add_landmark(std::size_t index) {
  const Landmark& landmark = bundle_.landmarks[index];
  PointEquations& point = points_[index];
  point.hessian.setZero();
  point.gradient.setZero();
  point.by_readout.setZero();
  for (std::size_t k = 0; k < landmark.views.size(); ++k) {
    const LandmarkView& view = landmark.views[k];
    const MovingCamera& camera = bundle_.cameras[view.camera];
    const Eigen::Vector3d error =
        reprojection_residual(view, landmark.point_world, camera, bundle_.model);
    const double weight = view_cost(error.squaredNorm(), options_.kernel_sigmas).derivative;
    const ReprojectionJacobians by =
        reprojection_jacobians(view, landmark.point_world, camera, bundle_.model);
    const Eigen::Matrix3d point_weight = weight * by.by_point.transpose();
    point.hessian += point_weight * by.by_point;
    point.gradient -= point_weight * error;
    point.by_readout += point_weight * by.by_readout;
    readout_hessian_ += weight * by.by_readout.squaredNorm();
    readout_gradient_ -= weight * by.by_readout.dot(error);
    const Matrix63d pose_weight = weight * by.by_pose.transpose();
    mixed_[first_view_[index] + k] = pose_weight * by.by_point;
    if (!is_free(view.camera)) continue;
    const std::size_t a = view.camera - bundle_.fixed;
    diagonal_[a] += pose_weight * by.by_pose;
    segment(gradient_, a) -= pose_weight * error;
    segment(by_readout_, a) += pose_weight * by.by_readout;
  }
}

void BundleSystem::linearize() {
  diagonal_.assign(free_count_, Matrix6d::Zero());
  off_diagonal_.assign(pairs_.size(), Matrix6d::Zero());
  gradient_.setZero(6 * static_cast<Eigen::Index>(free_count_));
  by_readout_.setZero(gradient_.size());
  readout_hessian_ = readout_gradient_ = 0;
  for (const PoseGraphEdge& edge : bundle_.edges) add_edge(edge);
  for (std::size_t i = 0; i < bundle_.landmarks.size(); ++i) add_landmark(i);
  if (options_.readout_sigma_s > 0) {
    const double weight = 1 / (options_.readout_sigma_s * options_.readout_sigma_s);
    readout_hessian_ += weight;
    readout_gradient_ -= weight * bundle_.model.readout_s;
  }
}

bool BundleSystem::eliminate_points(double damping) {
  double largest = 0;
  for (const Matrix6d& block : diagonal_) largest = std::max(largest, block.diagonal().maxCoeff());
  reduced_ = diagonal_;
  for (Matrix6d& block : reduced_)
    block.diagonal() += damping * block.diagonal().cwiseMax(kMinWeight * largest);
  reduced_off_ = off_diagonal_;
  reduced_gradient_ = gradient_;
  reduced_by_readout_ = by_readout_;
  reduced_readout_hessian_ = (1 + damping) * readout_hessian_;
  reduced_readout_gradient_ = readout_gradient_;
  std::vector<Matrix63d> carried;
  auto slot = slots_.begin();
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const auto& views = bundle_.landmarks[i].views;
    PointEquations& point = points_[i];
    Eigen::Matrix3d damped = point.hessian;
    damped.diagonal() +=
        damping * damped.diagonal().cwiseMax(kMinWeight * damped.diagonal().maxCoeff());
    point.inverse = damped.inverse();
    if (!point.inverse.allFinite()) return false;
    const Eigen::Vector3d by_readout = point.inverse * point.by_readout;
    reduced_readout_hessian_ -= point.by_readout.dot(by_readout);
    reduced_readout_gradient_ -= by_readout.dot(point.gradient);
    carried.resize(views.size());
    for (std::size_t k = 0; k < views.size(); ++k) {
      if (!is_free(views[k].camera)) continue;
      const std::size_t a = views[k].camera - bundle_.fixed;
      const Matrix63d& mixed = mixed_[first_view_[i] + k];
      carried[k].noalias() = mixed * point.inverse;
      segment(reduced_gradient_, a) -= carried[k] * point.gradient;
      segment(reduced_by_readout_, a) -= mixed * by_readout;
      reduced_[a].noalias() -= carried[k] * mixed.transpose();
      for (std::size_t l = 0; l < k; ++l) {
        if (!is_free(views[l].camera)) continue;
        const Matrix63d& other = mixed_[first_view_[i] + l];
        Matrix6d& block = reduced_off_[*slot++];
        if (views[k].camera < views[l].camera) {
          block.noalias() -= carried[k] * other.transpose();
        } else {
          block.noalias() -= carried[l] * mixed.transpose();
        }
      }
    }
  }
  return true;
}

void BundleSystem::step_points(BundleStep& step) const {
  step.points.resize(points_.size());
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const auto& views = bundle_.landmarks[i].views;
    Eigen::Vector3d rest = points_[i].gradient - step.readout_s * points_[i].by_readout;
    for (std::size_t k = 0; k < views.size(); ++k) {
      if (!is_free(views[k].camera)) continue;
      rest -= mixed_[first_view_[i] + k].transpose() *
              segment(step.cameras, views[k].camera - bundle_.fixed);
    }
    step.points[i] = points_[i].inverse * rest;
    step.predicted_reduction += points_[i].gradient.dot(step.points[i]);
  }
}

std::optional<BundleStep> BundleSystem::solve(double damping) {
  if (!eliminate_points(damping) || !cholesky_->factorize(reduced_, reduced_off_))
    return std::nullopt;
  BundleStep step;
  step.cameras = reduced_gradient_;
  cholesky_->solve(step.cameras);
  if (options_.readout_sigma_s > 0) {
    // The readout time's row and column stand at the border of the cameras' equations.
    Eigen::VectorXd border = reduced_by_readout_;
    cholesky_->solve(border);
    const double pivot = reduced_readout_hessian_ - reduced_by_readout_.dot(border);
    if (!(pivot > 0)) return std::nullopt;
    step.readout_s = (reduced_readout_gradient_ - reduced_by_readout_.dot(step.cameras)) / pivot;
    step.cameras -= step.readout_s * border;
  }
  step.predicted_reduction = gradient_.dot(step.cameras) + readout_gradient_ * step.readout_s;
  step_points(step);
  return step;
}

}  // namespace roomwise::mapping
