#pragma once

#include <optional>
#include <vector>

#include "roomwise/mapping/bundle/bundle_adjustment.h"
#include "roomwise/mapping/graph/block_cholesky.h"

namespace roomwise::mapping {

// Cauchy's kernel, k^2 log(1 + s / k^2), of s = |residual|^2, and its derivative by s.
struct ViewCost {
  double value = 0;
  double derivative = 1;
};
[[nodiscard]] ViewCost view_cost(double squares, double kernel_sigmas);

// Where a step leads, and by how much it should lower half the cost's gradient.
struct BundleStep {
  Eigen::VectorXd cameras;              // six numbers a camera that may move: see retract()
  std::vector<Eigen::Vector3d> points;  // by landmark
  double readout_s = 0;
  double predicted_reduction = 0;  // gradient times step
};

// The normal equations of a bundle: cameras, landmarks, and the readout time, which touches all.
class BundleSystem {
 public:
  // Plans the elimination for a bundle whose views and edges stay the same. Both must outlive it.
  BundleSystem(const Bundle& bundle, const BundleOptions& options);

  // Of the bundle as it is now.
  void linearize();
  // Gauss and Newton's step with the diagonal raised by this part of it; nothing where the
  // equations have no solution in double precision.
  [[nodiscard]] std::optional<BundleStep> solve(double damping);

 private:
  using Matrix63d = Eigen::Matrix<double, 6, 3>;
  struct PointEquations {
    Eigen::Matrix3d hessian;
    Eigen::Vector3d gradient;    // half of it, downhill
    Eigen::Vector3d by_readout;  // the hessian's column of the readout time
    Eigen::Matrix3d inverse;     // of the damped hessian
  };

  void find_pairs();
  void find_slots();
  [[nodiscard]] std::size_t slot_of(std::size_t a, std::size_t b) const;  // a < b, moving cameras
  [[nodiscard]] bool is_free(std::size_t camera) const { return camera >= bundle_.fixed; }
  void add_edge(const PoseGraphEdge& edge);
  void add_landmark(std::size_t landmark);
  [[nodiscard]] bool eliminate_points(double damping);
  void step_points(BundleStep& step) const;

  const Bundle& bundle_;
  const BundleOptions& options_;
  std::size_t free_count_;
  // Off-diagonal blocks, by the lower camera of each, then by the higher.
  std::vector<BlockPair> pairs_;
  std::vector<std::size_t> first_pair_;  // by the lower camera
  std::vector<std::size_t> first_view_;  // by landmark
  // By landmark, its pairs of views that move (second before first): their off-diagonal block.
  std::vector<std::uint32_t> slots_;
  std::optional<BlockCholesky> cholesky_;

  std::vector<geometry::Matrix6d> diagonal_, off_diagonal_;
  Eigen::VectorXd gradient_, by_readout_;
  double readout_hessian_ = 0, readout_gradient_ = 0;
  std::vector<PointEquations> points_;
  std::vector<Matrix63d> mixed_;  // by view: the hessian's block of its camera and its point

  // What is left when the landmarks are eliminated.
  std::vector<geometry::Matrix6d> reduced_, reduced_off_;
  Eigen::VectorXd reduced_gradient_, reduced_by_readout_;
  double reduced_readout_hessian_ = 0, reduced_readout_gradient_ = 0;
};

}  // namespace roomwise::mapping
