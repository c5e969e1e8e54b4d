#pragma once

#include <optional>
#include <vector>

#include "roomwise/geometry/robust_loss.h"
#include "roomwise/mapping/bundle/bundle_adjustment.h"
#include "roomwise/mapping/graph/block_cholesky.h"

namespace roomwise::mapping {

// What a view's residual (sigmas) costs.
[[nodiscard]] inline geometry::RobustLoss view_loss(const Eigen::Vector3d& error,
                                                    const BundleOptions& options) {
  return geometry::cauchy_loss(error.squaredNorm(), options.kernel_sigmas * options.kernel_sigmas);
}

// A bundle as levenberg_marquardt.h minimises it. The variables are cameras, landmarks, and the
// last readout time, which touches all of its model.
class BundleProblem {
 public:
  // Plans the elimination for a bundle whose views and edges stay the same. Both must outlive it.
  BundleProblem(Bundle& bundle, const BundleOptions& options);

  [[nodiscard]] double cost() const { return bundle_cost(bundle_, options_); }
  void linearize();
  // The length is that of the longest step of a camera.
  [[nodiscard]] std::optional<geometry::DampedStep> solve(double damping);
  void take_step();
  void undo_step();

 private:
  using Matrix63d = Eigen::Matrix<double, 6, 3>;
  struct PointEquations {
    Eigen::Matrix3d hessian;
    Eigen::Vector3d rhs;
    Eigen::Vector3d readout_hessian;  // the column of the readout time
    Eigen::Vector3d damping;
    Eigen::Matrix3d inverse;  // of the damped hessian
  };
  struct Variables {
    std::vector<geometry::RigidTransform> world_from_camera;  // of the cameras that may move
    std::vector<Eigen::Vector3d> points_world;
    double readout_s = 0;
  };

  [[nodiscard]] bool is_variable(std::size_t camera) const {
    return camera >= bundle_.fixed_cameras;
  }
  // The off-diagonal block of two cameras: rows of the lower.
  [[nodiscard]] BlockPair pair_of(std::size_t a, std::size_t b) const;
  [[nodiscard]] std::size_t block_of(const BlockPair& pair) const;
  // Calls visit(k, l), l < k, for the pairs of views whose cameras may move.
  template <typename Visit>
  void for_each_variable_pair(const Landmark& landmark, const Visit& visit) const;
  void add_edge(const PoseGraphEdge& edge);
  void add_landmark(std::size_t landmark);
  [[nodiscard]] bool eliminate_points(double damping);
  [[nodiscard]] Eigen::Vector3d step_of_point(std::size_t landmark) const;

  Bundle& bundle_;
  const BundleOptions& options_;
  std::size_t variable_cameras_;
  std::vector<BlockPair> pairs_;           // of off-diagonal blocks, sorted
  std::vector<std::size_t> first_view_;    // by landmark
  std::vector<std::uint32_t> pair_block_;  // in the order of for_each_variable_pair()
  std::optional<BlockCholesky> cholesky_;

  // Each rhs is half the cost's gradient, downhill.
  std::vector<geometry::Matrix6d> camera_hessian_, off_diagonal_hessian_;
  Eigen::VectorXd camera_rhs_, camera_readout_hessian_;
  double readout_hessian_ = 0, readout_rhs_ = 0;
  std::vector<PointEquations> points_;
  std::vector<Matrix63d> camera_point_hessian_;  // by view

  // Schur's complement: what is left when the landmarks are eliminated.
  std::vector<geometry::Matrix6d> reduced_hessian_, reduced_off_diagonal_;
  Eigen::VectorXd reduced_rhs_, reduced_camera_readout_, camera_damping_;
  double reduced_readout_hessian_ = 0, reduced_readout_rhs_ = 0;

  Eigen::VectorXd camera_step_;
  std::vector<Eigen::Vector3d> point_step_;
  double readout_step_s_ = 0;
  Variables before_;  // the last step
};

}  // namespace roomwise::mapping
