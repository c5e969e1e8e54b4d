#include "roomwise/mapping/pose_graph.h"

#include <ceres/ceres.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <string>

namespace roomwise::mapping {
namespace {

using geometry::Matrix6d;
using geometry::RigidTransform;

template <typename T>
using Vector3 = Eigen::Matrix<T, 3, 1>;
template <typename T>
using Vector6 = Eigen::Matrix<T, 6, 1>;

// The error e of PoseGraphEdge, for numbers and for Ceres' differentiable numbers.
template <typename T>
Vector6<T> edge_error(const RigidTransform& from_from_to, const Eigen::Quaternion<T>& from_rotation,
                      const Vector3<T>& from_translation, const Eigen::Quaternion<T>& to_rotation,
                      const Vector3<T>& to_translation) {
  const Eigen::Quaternion<T> measured_back = from_from_to.rotation.conjugate().cast<T>();
  const Eigen::Quaternion<T> from_from_world = from_rotation.conjugate();
  const Vector3<T> estimated = from_from_world * (to_translation - from_translation);
  const Vector3<T> measured = from_from_to.translation.cast<T>();
  const Eigen::Quaternion<T> turn = measured_back * (from_from_world * to_rotation);
  Vector6<T> error;
  error.template head<3>() = measured_back * Vector3<T>(estimated - measured);
  error.template tail<3>() = turn.vec() * T(turn.w() < T(0) ? -1 : 1);
  return error;
}

// The residual of an edge: a square root of its information times its error, so that the sum of
// squares is e^T Omega e. A pose is two parameter blocks, quaternion (x, y, z, w) and translation.
struct EdgeResidual {
  RigidTransform from_from_to;
  Matrix6d square_root_information;

  template <typename T>
  bool operator()(const T* from_rotation, const T* from_translation, const T* to_rotation,
                  const T* to_translation, T* residual) const {
    Eigen::Map<Vector6<T>> weighted_error(residual);
    weighted_error =
        square_root_information *
        edge_error<T>(from_from_to, Eigen::Map<const Eigen::Quaternion<T>>(from_rotation),
                      Eigen::Map<const Vector3<T>>(from_translation),
                      Eigen::Map<const Eigen::Quaternion<T>>(to_rotation),
                      Eigen::Map<const Vector3<T>>(to_translation));
    return true;
  }
};
using EdgeCost = ceres::AutoDiffCostFunction<EdgeResidual, 6, 4, 3, 4, 3>;

std::string name_of(const PoseGraphEdge& edge) {
  return fmt::format("the edge from node {} to node {}", edge.from, edge.to);
}

Expected<void> check_pose(const RigidTransform& pose) {
  if (!pose.is_finite()) return fail("holds a number that is not finite");
  constexpr double kUnitTolerance = 1e-6;
  if (std::abs(pose.rotation.norm() - 1) > kUnitTolerance) {
    return fail("has a quaternion of length {}; expected 1", pose.rotation.norm());
  }
  return {};
}

Expected<void> check(const PoseGraph& graph) {
  for (const auto& [id, pose] : graph.world_from_node) {
    if (auto checked = check_pose(pose); !checked) {
      return fail("the pose of node {} {}", id, checked.error().message);
    }
  }
  for (const PoseGraphEdge& edge : graph.edges) {
    for (const NodeId id : {edge.from, edge.to}) {
      if (!graph.world_from_node.contains(id)) {
        return fail("{} needs node {}, which the graph does not hold", name_of(edge), id);
      }
    }
    if (edge.from == edge.to) return fail("{} joins a node to itself", name_of(edge));
    if (auto checked = check_pose(edge.from_from_to); !checked) {
      return fail("the transform of {} {}", name_of(edge), checked.error().message);
    }
  }
  return {};
}

// R with R^T R = information, also where the information says nothing about some directions.
Expected<Matrix6d> square_root(const PoseGraphEdge& edge) {
  const Matrix6d& information = edge.information;
  if (!information.allFinite()) {
    return fail("the information of {} holds a number that is not finite", name_of(edge));
  }
  constexpr double kRounding = 1e-9;
  const double largest = information.cwiseAbs().maxCoeff();
  if ((information - information.transpose()).cwiseAbs().maxCoeff() > kRounding * largest) {
    return fail("the information of {} is not symmetric", name_of(edge));
  }
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(0.5 *
                                                      (information + information.transpose()));
  const double smallest = eigen.eigenvalues().minCoeff();
  if (eigen.info() != Eigen::Success || smallest < -kRounding * largest) {
    return fail("the information of {} is not positive semi-definite (smallest eigenvalue {:.3g})",
                name_of(edge), smallest);
  }
  return Matrix6d(eigen.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal() *
                  eigen.eigenvectors().transpose());
}

// The lowest node of each connected part: union-find in which the lower node is always the root.
class LowestOfPart {
 public:
  explicit LowestOfPart(const PoseGraph& graph) {
    for (const auto& [id, pose] : graph.world_from_node) parent_[id] = id;
    for (const PoseGraphEdge& edge : graph.edges) {
      const NodeId a = find(edge.from);
      const NodeId b = find(edge.to);
      parent_[std::max(a, b)] = std::min(a, b);
    }
  }
  NodeId find(NodeId id) {
    while (parent_.at(id) != id) id = parent_.at(id) = parent_.at(parent_.at(id));
    return id;
  }

 private:
  std::map<NodeId, NodeId> parent_;
};

// Ceres' problem, whose parameters are the graph's poses themselves.
class Problem {
 public:
  explicit Problem(PoseGraph& graph) : graph_(graph), problem_(borrowing()) {}

  Expected<void> add(const PoseGraphEdge& edge, ceres::LossFunction* loss) {
    ROOMWISE_TRY(const Matrix6d root, square_root(edge));
    RigidTransform& from = graph_.world_from_node.at(edge.from);
    RigidTransform& to = graph_.world_from_node.at(edge.to);
    problem_.AddResidualBlock(new EdgeCost(new EdgeResidual{edge.from_from_to, root}), loss,
                              from.rotation.coeffs().data(), from.translation.data(),
                              to.rotation.coeffs().data(), to.translation.data());
    return {};
  }

  void complete() {
    LowestOfPart lowest(graph_);
    for (auto& [id, pose] : graph_.world_from_node) {
      double* const rotation = pose.rotation.coeffs().data();
      double* const translation = pose.translation.data();
      if (!problem_.HasParameterBlock(rotation)) continue;  // no edge: nothing moves it
      problem_.SetManifold(rotation, &manifold_);
      if (lowest.find(id) != id) continue;
      problem_.SetParameterBlockConstant(rotation);
      problem_.SetParameterBlockConstant(translation);
    }
  }

  ceres::Solver::Summary solve(const ceres::Solver::Options& options) {
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    return summary;
  }

 private:
  static ceres::Problem::Options borrowing() {
    ceres::Problem::Options options;
    options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    return options;
  }

  PoseGraph& graph_;
  ceres::EigenQuaternionManifold manifold_;
  ceres::Problem problem_;
};

ceres::Solver::Options solver_options(const PoseGraphOptions& options) {
  ceres::Solver::Options solver;
  solver.max_num_iterations = options.most_iterations;
  solver.function_tolerance = options.relative_tolerance;
  // So small that the relative tolerance is what stops the iterations.
  solver.gradient_tolerance = 1e-12;
  solver.parameter_tolerance = 1e-12;
  solver.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  solver.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  // Ceres sums costs by thread: with another number of threads the last bits differ.
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  return solver;
}

}  // namespace

Expected<void> PoseGraphOptions::validate() const {
  if (most_iterations < 1) {
    return fail("most_iterations is {}; expected 1 or more", most_iterations);
  }
  if (!(relative_tolerance > 0 && relative_tolerance < 1)) {
    return fail("relative_tolerance is {}; expected a number between 0 and 1", relative_tolerance);
  }
  if (!(loop_kernel >= 0 && std::isfinite(loop_kernel))) {
    return fail("loop_kernel is {}; expected 0 (none) or a positive number", loop_kernel);
  }
  return {};
}

double pose_graph_error(const PoseGraph& graph) {
  double sum = 0;
  for (const PoseGraphEdge& edge : graph.edges) {
    const RigidTransform& from = graph.world_from_node.at(edge.from);
    const RigidTransform& to = graph.world_from_node.at(edge.to);
    const geometry::Vector6d error = edge_error<double>(
        edge.from_from_to, from.rotation, from.translation, to.rotation, to.translation);
    sum += error.dot(edge.information * error);
  }
  return sum;
}

Expected<PoseGraphReport> optimize(PoseGraph& graph, const PoseGraphOptions& options) {
  ROOMWISE_CHECK_OK(options.validate());
  ROOMWISE_CHECK_OK(check(graph));

  PoseGraph optimized = graph;
  ceres::CauchyLoss loop_loss(std::sqrt(options.loop_kernel));
  Problem problem(optimized);
  for (const PoseGraphEdge& edge : optimized.edges) {
    const bool robust = edge.is_loop && options.loop_kernel > 0;
    ROOMWISE_CHECK_OK(problem.add(edge, robust ? &loop_loss : nullptr));
  }
  const double error_before = pose_graph_error(graph);
  if (!std::isfinite(error_before)) {
    return fail("the pose graph holds lengths or weights too large to square; expected metres");
  }

  problem.complete();
  const ceres::Solver::Summary summary = problem.solve(solver_options(options));
  if (!summary.IsSolutionUsable()) {
    return fail("the pose graph could not be optimised: {}", summary.message);
  }
  for (auto& [id, pose] : optimized.world_from_node) pose.rotation.normalize();

  const PoseGraphReport report{error_before, pose_graph_error(optimized),
                               static_cast<int>(summary.iterations.size()) - 1,
                               summary.termination_type == ceres::CONVERGENCE};
  graph = std::move(optimized);
  return report;
}

}  // namespace roomwise::mapping
