#pragma once

#include <ceres/ceres.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <set>

#include "roomwise/mapping/graph/pose_graph.h"

// Pose graphs by Ceres Solver, beside which ours is tested and measured.
namespace roomwise::mapping::testing {

// A square root of an edge's information times PoseGraphEdge's error, in Ceres' differentiable
// numbers. A pose is two parameter blocks, quaternion (x, y, z, w) and translation.
struct CeresEdge {
  geometry::RigidTransform from_from_to;
  geometry::Matrix6d square_root_information;

  template <typename T>
  bool operator()(const T* from_rotation, const T* from_translation, const T* to_rotation,
                  const T* to_translation, T* residual) const {
    using Vector3 = Eigen::Matrix<T, 3, 1>;
    using Quaternion = Eigen::Quaternion<T>;
    const Quaternion measured_back = from_from_to.rotation.conjugate().cast<T>();
    const Quaternion from_from_world = Eigen::Map<const Quaternion>(from_rotation).conjugate();
    const Vector3 estimated =
        from_from_world * Vector3(Eigen::Map<const Vector3>(to_translation) -
                                  Eigen::Map<const Vector3>(from_translation));
    const Quaternion turn =
        measured_back * (from_from_world * Eigen::Map<const Quaternion>(to_rotation));
    Eigen::Matrix<T, 6, 1> error;
    error.template head<3>() =
        measured_back * Vector3(estimated - from_from_to.translation.cast<T>());
    error.template tail<3>() = turn.vec() * T(turn.w() < T(0) ? -1 : 1);
    Eigen::Map<Eigen::Matrix<T, 6, 1>>{residual} = square_root_information * error;
    return true;
  }
};

// R with R^T R = information.
inline geometry::Matrix6d square_root(const geometry::Matrix6d& information) {
  const Eigen::SelfAdjointEigenSolver<geometry::Matrix6d> eigen(information);
  return eigen.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal() *
         eigen.eigenvectors().transpose();
}

// Moves the poses of a connected graph to a minimum; the lowest node stays where it is.
inline ceres::Solver::Summary optimize_with_ceres(PoseGraph& graph, double loop_kernel,
                                                  const ceres::Solver::Options& options) {
  ceres::Problem::Options borrowing;
  borrowing.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  borrowing.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::CauchyLoss loop_loss(std::sqrt(loop_kernel));
  ceres::EigenQuaternionManifold manifold;
  ceres::Problem problem(borrowing);
  for (const PoseGraphEdge& edge : graph.edges) {
    geometry::RigidTransform& from = graph.world_from_node.at(edge.from);
    geometry::RigidTransform& to = graph.world_from_node.at(edge.to);
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<CeresEdge, 6, 4, 3, 4, 3>(
                                 new CeresEdge{edge.from_from_to, square_root(edge.information)}),
                             edge.is_robust && loop_kernel > 0 ? &loop_loss : nullptr,
                             from.rotation.coeffs().data(), from.translation.data(),
                             to.rotation.coeffs().data(), to.translation.data());
  }
  for (auto& [id, pose] : graph.world_from_node)
    problem.SetManifold(pose.rotation.coeffs().data(), &manifold);
  geometry::RigidTransform& first = graph.world_from_node.begin()->second;
  problem.SetParameterBlockConstant(first.rotation.coeffs().data());
  problem.SetParameterBlockConstant(first.translation.data());
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  for (auto& [id, pose] : graph.world_from_node) pose.rotation.normalize();
  return summary;
}

}  // namespace roomwise::mapping::testing
