#include "roomwise/mapping/graph/pose_graph.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "roomwise/base/disjoint_sets.h"
#include "roomwise/mapping/graph/edge_error.h"
#include "roomwise/mapping/graph/pose_graph_solver.h"

namespace roomwise::mapping {
namespace {

using geometry::Matrix6d;
using geometry::RigidTransform;

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

constexpr double kRounding = 1e-9;  // of an information's largest entry

// Finite and symmetric, give or take rounding.
Expected<void> check_information(const PoseGraphEdge& edge) {
  const Matrix6d& information = edge.information;
  if (!information.allFinite()) {
    return fail("the information of {} holds a number that is not finite", name_of(edge));
  }
  const double largest = information.cwiseAbs().maxCoeff();
  if ((information - information.transpose()).cwiseAbs().maxCoeff() > kRounding * largest) {
    return fail("the information of {} is not symmetric", name_of(edge));
  }
  return {};
}

bool is_semidefinite(const Matrix6d& information) {
  const double largest = information.cwiseAbs().maxCoeff();
  if (largest == 0) return true;
  const Matrix6d lifted = information + kRounding * largest * Matrix6d::Identity();
  return lifted.llt().info() == Eigen::Success;
}

// The nearest that is: what is negative becomes nothing (Higham, "Computing a nearest symmetric
// positive semidefinite matrix", 1988).
Matrix6d nearest_semidefinite(const Matrix6d& information) {
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(information);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).asDiagonal() *
         eigen.eigenvectors().transpose();
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
    ROOMWISE_RETURN_IF_ERROR(check_information(edge));
  }
  return {};
}

// The graph with numbers for ids: first the lowest node of each part, which stays where it is.
IndexedGraph numbered(const PoseGraph& graph, const PoseGraphOptions& options,
                      std::map<NodeId, std::uint32_t>& numbers) {
  std::map<NodeId, std::size_t> rank;
  for (const auto& [id, pose] : graph.world_from_node) rank.emplace(id, rank.size());
  DisjointSets parts(rank.size());
  for (const PoseGraphEdge& edge : graph.edges) parts.join(rank.at(edge.from), rank.at(edge.to));
  IndexedGraph result;
  for (const bool fixed : {true, false}) {
    for (const auto& [id, pose] : graph.world_from_node) {
      const std::size_t own = rank.at(id);
      if ((parts.find(own) == own) != fixed) continue;
      numbers[id] = static_cast<std::uint32_t>(result.world_from_node.size());
      result.world_from_node.push_back(pose);
    }
    if (fixed) result.fixed_pose_count = result.world_from_node.size();
  }
  for (const PoseGraphEdge& edge : graph.edges) {
    result.edges.push_back({numbers.at(edge.from), numbers.at(edge.to), &edge,
                            edge.is_robust ? options.loop_kernel : 0});
  }
  return result;
}

// The same for edges whose information is positive semi-definite.
Expected<PoseGraphReport> optimize_semidefinite(PoseGraph& graph, const PoseGraphOptions& options,
                                                const Interruption& interruption) {
  const double error_before = pose_graph_chi2(graph);
  if (!std::isfinite(error_before)) {
    return fail("the pose graph holds lengths or weights too large to square; expected metres");
  }
  std::map<NodeId, std::uint32_t> numbers;
  IndexedGraph solved = numbered(graph, options, numbers);
  const geometry::MinimizerSummary summary = minimize(solved, options, interruption);
  if (summary.termination == geometry::Termination::kInterrupted)
    return fail_with(ErrorCode::kInterrupted, "interrupted while optimising the pose graph");
  for (auto& [id, pose] : graph.world_from_node) pose = solved.world_from_node[numbers.at(id)];
  return PoseGraphReport{error_before, pose_graph_chi2(graph), summary.iterations,
                         summary.termination, 0};
}

}  // namespace

Expected<void> PoseGraphOptions::validate() const {
  if (max_iterations < 1) {
    return fail("max_iterations is {}; expected 1 or more", max_iterations);
  }
  if (!(relative_tolerance > 0 && relative_tolerance < 1)) {
    return fail("relative_tolerance is {}; expected a number between 0 and 1", relative_tolerance);
  }
  if (!(loop_kernel >= 0 && std::isfinite(loop_kernel))) {
    return fail("loop_kernel is {}; expected 0 (none) or a positive number", loop_kernel);
  }
  return {};
}

double pose_graph_chi2(const PoseGraph& graph) {
  double sum = 0;
  for (const PoseGraphEdge& edge : graph.edges)
    sum += edge_cost(edge, graph.world_from_node.at(edge.from), graph.world_from_node.at(edge.to));
  return sum;
}

Expected<PoseGraphReport> optimize(PoseGraph& graph, const PoseGraphOptions& options,
                                   const Interruption& interruption) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  ROOMWISE_RETURN_IF_ERROR(check(graph));
  // Edges are solved by what of them makes sense, and stay as they are.
  std::map<std::size_t, Matrix6d> indefinite;  // by edge: as it was given
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    Matrix6d& information = graph.edges[i].information;
    if (is_semidefinite(information)) continue;
    indefinite.emplace(i, std::exchange(information, nearest_semidefinite(information)));
  }
  auto report = optimize_semidefinite(graph, options, interruption);
  for (const auto& [i, information] : indefinite) graph.edges[i].information = information;
  if (report) report->indefinite_edges = indefinite.size();
  return report;
}

}  // namespace roomwise::mapping
