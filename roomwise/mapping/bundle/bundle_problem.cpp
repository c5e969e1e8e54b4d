#include "roomwise/mapping/bundle/bundle_problem.h"

#include <Eigen/LU>
#include <algorithm>

#include "roomwise/mapping/graph/edge_error.h"

namespace roomwise::mapping {
namespace {

using geometry::Matrix6d;

template <typename Numbers>
auto camera_segment(Numbers& numbers, std::size_t variable_camera) {
  return numbers.template segment<6>(6 * static_cast<Eigen::Index>(variable_camera));
}

}  // namespace

template <typename Visit>
void BundleProblem::for_each_variable_pair(const Landmark& landmark, const Visit& visit) const {
  for (std::size_t k = 0; k < landmark.views.size(); ++k) {
    if (!is_variable(landmark.views[k].camera)) continue;
    for (std::size_t l = 0; l < k; ++l)
      if (is_variable(landmark.views[l].camera)) visit(k, l);
  }
}

BundleProblem::BundleProblem(Bundle& bundle, const BundleOptions& options)
    : bundle_(bundle),
      options_(options),
      variable_cameras_(bundle.cameras.size() - bundle.fixed_cameras),
      points_(bundle.landmarks.size()),
      point_step_(bundle.landmarks.size()) {
  for (const PoseGraphEdge& edge : bundle.edges) {
    if (is_variable(edge.from) && is_variable(edge.to))
      pairs_.push_back(pair_of(edge.from, edge.to));
  }
  std::size_t views = 0;
  std::vector<BlockPair> view_pairs;
  for (const Landmark& landmark : bundle.landmarks) {
    first_view_.push_back(views);
    views += landmark.views.size();
    for_each_variable_pair(landmark, [&](std::size_t k, std::size_t l) {
      view_pairs.push_back(pair_of(landmark.views[k].camera, landmark.views[l].camera));
    });
  }
  camera_point_hessian_.resize(views);
  pairs_.insert(pairs_.end(), view_pairs.begin(), view_pairs.end());
  std::ranges::sort(pairs_);
  pairs_.erase(std::ranges::unique(pairs_).begin(), pairs_.end());
  for (const BlockPair& pair : view_pairs)
    pair_block_.push_back(static_cast<std::uint32_t>(block_of(pair)));
  cholesky_.emplace(variable_cameras_, pairs_);
}

BlockPair BundleProblem::pair_of(std::size_t a, std::size_t b) const {
  const auto [lower, higher] = std::minmax(a, b);
  return {static_cast<std::uint32_t>(lower - bundle_.fixed_cameras),
          static_cast<std::uint32_t>(higher - bundle_.fixed_cameras)};
}

std::size_t BundleProblem::block_of(const BlockPair& pair) const {
  return static_cast<std::size_t>(std::ranges::lower_bound(pairs_, pair) - pairs_.begin());
}

void BundleProblem::add_edge(const PoseGraphEdge& edge) {
  const EdgeEquations equations =
      mapping::linearize(edge, bundle_.cameras[edge.from].world_from_camera,
                         bundle_.cameras[edge.to].world_from_camera);
  if (is_variable(edge.from)) {
    camera_hessian_[edge.from - bundle_.fixed_cameras] += equations.from_hessian;
    camera_segment(camera_rhs_, edge.from - bundle_.fixed_cameras) += equations.from_rhs;
  }
  if (is_variable(edge.to)) {
    camera_hessian_[edge.to - bundle_.fixed_cameras] += equations.to_hessian;
    camera_segment(camera_rhs_, edge.to - bundle_.fixed_cameras) += equations.to_rhs;
  }
  if (!is_variable(edge.from) || !is_variable(edge.to)) return;
  Matrix6d& block = off_diagonal_hessian_[block_of(pair_of(edge.from, edge.to))];
  if (edge.from < edge.to) {
    block += equations.from_to_hessian;
  } else {
    block += equations.from_to_hessian.transpose();
  }
}

void BundleProblem::add_landmark(std::size_t index) {
  const Landmark& landmark = bundle_.landmarks[index];
  PointEquations& point = points_[index];
  point.hessian.setZero();
  point.rhs.setZero();
  point.readout_hessian.setZero();
  for (std::size_t k = 0; k < landmark.views.size(); ++k) {
    const LandmarkView& view = landmark.views[k];
    const RollingShutterCamera& camera = bundle_.cameras[view.camera];
    const ViewModel& model = bundle_.model_of(camera);
    const Eigen::Vector3d error = reprojection_residual(view, landmark.point_world, camera, model);
    const double weight = view_loss(error, options_).derivative;
    auto [d_pose, d_point, d_readout] =
        reprojection_jacobians(view, landmark.point_world, camera, model);
    if (camera.model + 1 != bundle_.models.size()) d_readout.setZero();
    const Eigen::Matrix3d weighted_point_jacobian_t = weight * d_point.transpose();
    point.hessian += weighted_point_jacobian_t * d_point;
    point.rhs -= weighted_point_jacobian_t * error;
    point.readout_hessian += weighted_point_jacobian_t * d_readout;
    readout_hessian_ += weight * d_readout.squaredNorm();
    readout_rhs_ -= weight * d_readout.dot(error);
    const Matrix63d weighted_pose_jacobian_t = weight * d_pose.transpose();
    camera_point_hessian_[first_view_[index] + k] = weighted_pose_jacobian_t * d_point;
    if (!is_variable(view.camera)) continue;
    const std::size_t a = view.camera - bundle_.fixed_cameras;
    camera_hessian_[a] += weighted_pose_jacobian_t * d_pose;
    camera_segment(camera_rhs_, a) -= weighted_pose_jacobian_t * error;
    camera_segment(camera_readout_hessian_, a) += weighted_pose_jacobian_t * d_readout;
  }
}

void BundleProblem::linearize() {
  camera_hessian_.assign(variable_cameras_, Matrix6d::Zero());
  off_diagonal_hessian_.assign(pairs_.size(), Matrix6d::Zero());
  camera_rhs_.setZero(6 * static_cast<Eigen::Index>(variable_cameras_));
  camera_readout_hessian_.setZero(camera_rhs_.size());
  readout_hessian_ = readout_rhs_ = 0;
  for (const PoseGraphEdge& edge : bundle_.edges) add_edge(edge);
  for (std::size_t i = 0; i < bundle_.landmarks.size(); ++i) add_landmark(i);
  if (options_.readout_sigma_s > 0) {
    const double weight = 1 / (options_.readout_sigma_s * options_.readout_sigma_s);
    readout_hessian_ += weight;
    readout_rhs_ -= weight * bundle_.models.back().readout_s;
  }
}

bool BundleProblem::eliminate_points(double damping) {
  reduced_hessian_ = camera_hessian_;
  camera_damping_ = add_damping(reduced_hessian_, damping);
  reduced_off_diagonal_ = off_diagonal_hessian_;
  reduced_rhs_ = camera_rhs_;
  reduced_camera_readout_ = camera_readout_hessian_;
  reduced_readout_hessian_ = (1 + damping) * readout_hessian_;
  reduced_readout_rhs_ = readout_rhs_;
  std::vector<Matrix63d> weighted;  // by view: camera_point_hessian_ times the point's inverse
  auto block = pair_block_.begin();
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const auto& views = bundle_.landmarks[i].views;
    PointEquations& point = points_[i];
    point.damping = damping * geometry::damping_weights(point.hessian.diagonal());
    Eigen::Matrix3d damped = point.hessian;
    damped.diagonal() += point.damping;
    point.inverse = damped.inverse();
    if (!point.inverse.allFinite()) return false;
    const Eigen::Vector3d readout = point.inverse * point.readout_hessian;
    reduced_readout_hessian_ -= point.readout_hessian.dot(readout);
    reduced_readout_rhs_ -= readout.dot(point.rhs);
    weighted.resize(views.size());
    const Matrix63d* camera_point = camera_point_hessian_.data() + first_view_[i];
    for (std::size_t k = 0; k < views.size(); ++k) {
      if (!is_variable(views[k].camera)) continue;
      const std::size_t a = views[k].camera - bundle_.fixed_cameras;
      weighted[k].noalias() = camera_point[k] * point.inverse;
      camera_segment(reduced_rhs_, a) -= weighted[k] * point.rhs;
      camera_segment(reduced_camera_readout_, a) -= camera_point[k] * readout;
      reduced_hessian_[a].noalias() -= weighted[k] * camera_point[k].transpose();
    }
    for_each_variable_pair(bundle_.landmarks[i], [&](std::size_t k, std::size_t l) {
      if (views[k].camera > views[l].camera) std::swap(k, l);
      reduced_off_diagonal_[*block++].noalias() -= weighted[k] * camera_point[l].transpose();
    });
  }
  return true;
}

Eigen::Vector3d BundleProblem::step_of_point(std::size_t index) const {
  const PointEquations& point = points_[index];
  const auto& views = bundle_.landmarks[index].views;
  Eigen::Vector3d rest = point.rhs - readout_step_s_ * point.readout_hessian;
  for (std::size_t k = 0; k < views.size(); ++k) {
    if (!is_variable(views[k].camera)) continue;
    rest -= camera_point_hessian_[first_view_[index] + k].transpose() *
            camera_segment(camera_step_, views[k].camera - bundle_.fixed_cameras);
  }
  return point.inverse * rest;
}

std::optional<geometry::DampedStep> BundleProblem::solve(double damping) {
  if (!eliminate_points(damping) || !cholesky_->factorize(reduced_hessian_, reduced_off_diagonal_))
    return std::nullopt;
  camera_step_ = reduced_rhs_;
  cholesky_->solve(camera_step_);
  readout_step_s_ = 0;
  if (options_.readout_sigma_s > 0) {
    // The readout time's row and column stand at the border of the cameras' equations.
    Eigen::VectorXd border = reduced_camera_readout_;
    cholesky_->solve(border);
    const double pivot = reduced_readout_hessian_ - reduced_camera_readout_.dot(border);
    if (!(pivot > 0)) return std::nullopt;
    readout_step_s_ = (reduced_readout_rhs_ - reduced_camera_readout_.dot(camera_step_)) / pivot;
    camera_step_ -= readout_step_s_ * border;
  }
  const auto reduction = [](const auto& step, const auto& rhs, const auto& weights) {
    return step.dot(rhs + weights.cwiseProduct(step));
  };
  geometry::DampedStep step{
      reduction(camera_step_, camera_rhs_, camera_damping_) +
          readout_step_s_ * (readout_rhs_ + damping * readout_hessian_ * readout_step_s_),
      camera_step_.lpNorm<Eigen::Infinity>()};
  for (std::size_t i = 0; i < points_.size(); ++i) {
    point_step_[i] = step_of_point(i);
    step.predicted_reduction += reduction(point_step_[i], points_[i].rhs, points_[i].damping);
  }
  return step;
}

void BundleProblem::take_step() {
  before_.world_from_camera.resize(variable_cameras_);
  for (std::size_t i = 0; i < variable_cameras_; ++i) {
    auto& pose = bundle_.cameras[bundle_.fixed_cameras + i].world_from_camera;
    before_.world_from_camera[i] = pose;
    pose = retract(pose, camera_segment(camera_step_, i));
  }
  before_.points_world.resize(points_.size());
  for (std::size_t i = 0; i < points_.size(); ++i) {
    before_.points_world[i] = bundle_.landmarks[i].point_world;
    bundle_.landmarks[i].point_world += point_step_[i];
  }
  double& readout_s = bundle_.models.back().readout_s;
  before_.readout_s = readout_s;
  readout_s += readout_step_s_;
}

void BundleProblem::undo_step() {
  for (std::size_t i = 0; i < variable_cameras_; ++i)
    bundle_.cameras[bundle_.fixed_cameras + i].world_from_camera = before_.world_from_camera[i];
  for (std::size_t i = 0; i < points_.size(); ++i)
    bundle_.landmarks[i].point_world = before_.points_world[i];
  bundle_.models.back().readout_s = before_.readout_s;
}

}  // namespace roomwise::mapping
