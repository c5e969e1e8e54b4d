// The optimisation of pose graphs beside Ceres, which solves the same problems with automatic
// derivatives.

#include "roomwise/mapping/graph/pose_graph_solver.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/mapping/graph/edge_error.h"
#include "roomwise/mapping/testing/ceres_pose_graph.h"
#include "roomwise/mapping/testing/random_transform.h"

namespace roomwise::mapping {
namespace {

using geometry::Matrix6d;
using geometry::RigidTransform;
using geometry::Vector6d;

Matrix6d random_information(RandomStream& random) {
  Matrix6d any;
  for (double& number : any.reshaped()) number = random.normal();
  return 100 * (any * any.transpose() + Matrix6d::Identity());
}

// A random walk with noisy steps and loops, of which every `wrong_every`-th (0: none) is wrong; the
// guess follows the steps.
PoseGraph random_graph(std::uint64_t seed, std::size_t wrong_every) {
  RandomStream random(seed);
  const std::uint64_t nodes = 20 + random.index(60);
  std::vector<RigidTransform> truth{testing::random_transform(random, 1, 1)};
  while (truth.size() < nodes)
    truth.push_back(truth.back() * testing::random_transform(random, 0.4, 0.4));
  PoseGraph graph;
  const auto measure = [&](NodeId from, NodeId to, bool is_robust, double noise) {
    graph.edges.push_back(
        {from, to,
         truth[from].inverse() * truth[to] * testing::random_transform(random, noise, noise),
         random_information(random), is_robust});
  };
  RigidTransform pose = truth[0];
  graph.world_from_node[0] = pose;
  for (NodeId id = 1; id < nodes; ++id) {
    measure(id - 1, id, false, 0.02);
    pose = pose * graph.edges.back().from_from_to;
    graph.world_from_node[id] = pose;
  }
  for (std::size_t loop = 1; loop < nodes; ++loop) {
    const NodeId from = random.index(nodes);
    const NodeId to = random.index(nodes);
    const bool wrong = wrong_every > 0 && loop % wrong_every == 0;
    if (from != to) measure(from, to, true, wrong ? 0.7 : 0.02);
  }
  return graph;
}

// F with Cauchy's kernel on loops.
double cost_of(const PoseGraph& graph, double loop_kernel) {
  double sum = 0;
  for (const PoseGraphEdge& edge : graph.edges) {
    const Vector6d error = edge_error(edge.from_from_to, graph.world_from_node.at(edge.from),
                                      graph.world_from_node.at(edge.to));
    const double squares = error.dot(edge.information * error);
    sum += edge.is_robust && loop_kernel > 0 ? loop_kernel * std::log1p(squares / loop_kernel)
                                             : squares;
  }
  return sum;
}

ceres::Solver::Options thorough_ceres() {
  ceres::Solver::Options options;
  options.function_tolerance = 1e-15;
  options.gradient_tolerance = 1e-14;
  options.parameter_tolerance = 1e-14;
  options.max_num_iterations = 1000;
  options.logging_type = ceres::SILENT;
  return options;
}

double farthest_apart(const PoseGraph& a, const PoseGraph& b) {
  double farthest = 0;
  for (const auto& [id, pose] : a.world_from_node) {
    const RigidTransform d = pose.inverse() * b.world_from_node.at(id);
    farthest = std::max(farthest, d.distance_m() + d.angle_rad());
  }
  return farthest;
}

class OptimizeBesideCeres : public ::testing::TestWithParam<double> {};

TEST_P(OptimizeBesideCeres, FindsTheSameOptimum) {
  const double kernel = GetParam();
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    PoseGraph ours = random_graph(seed, kernel > 0 ? 5 : 0);
    PoseGraph theirs = ours;
    const auto report = optimize(ours, {.loop_kernel = kernel});
    ASSERT_OK(report);
    EXPECT_EQ(report->termination, geometry::Termination::kConverged) << seed;
    testing::optimize_with_ceres(theirs, kernel, thorough_ceres());
    const double cost = cost_of(theirs, kernel);
    EXPECT_NEAR(cost_of(ours, kernel), cost, 1e-8 * cost) << seed;
    EXPECT_LT(farthest_apart(ours, theirs), 1e-4) << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(Kernels, OptimizeBesideCeres, ::testing::Values(0.0, 50.0));

TEST(Optimize, LeavesNoGradient) {
  PoseGraph graph = random_graph(3, 5);
  const double kernel = 50;
  ASSERT_OK(optimize(graph, {.relative_tolerance = 1e-15, .loop_kernel = kernel}));
  const double least = cost_of(graph, kernel);
  for (auto& [id, pose] : graph.world_from_node) {
    if (id == 0) continue;
    for (Eigen::Index i = 0; i < 6; ++i) {
      const RigidTransform at = pose;
      const auto moved_cost = [&](double step) {
        pose = retract(at, step * Vector6d::Unit(i));
        return cost_of(graph, kernel);
      };
      constexpr double kStep = 1e-4;
      const double up = moved_cost(kStep), down = moved_cost(-kStep);
      pose = at;
      // Of the cost's change over the step nearly all is curvature.
      const double curved = up + down - 2 * least;
      EXPECT_GT(curved, 0) << id;
      EXPECT_LT(std::abs(up - down), 0.02 * curved) << id;
    }
  }
}

TEST(Optimize, DoesNotDependOnTheOriginWithOutliersEither) {
  PoseGraph graph = random_graph(4, 5);
  PoseGraph elsewhere = graph;
  RandomStream random(1);
  const RigidTransform other_from_world = testing::random_transform(random, 3, 3);
  for (auto& [id, pose] : elsewhere.world_from_node) pose = other_from_world * pose;
  const PoseGraphOptions options{.loop_kernel = 50};
  ASSERT_OK(optimize(graph, options));
  ASSERT_OK(optimize(elsewhere, options));
  for (auto& [id, pose] : graph.world_from_node) pose = other_from_world * pose;
  EXPECT_LT(farthest_apart(graph, elsewhere), 1e-5);
}

TEST(Optimize, DoesNotDependOnHowNodesAreNumbered) {
  PoseGraph graph = random_graph(5, 0);
  PoseGraph shuffled;
  const std::uint64_t count = graph.world_from_node.size();
  // The first stays the first, since it is the one that is held still.
  const auto other = [&](NodeId id) { return id == 0 ? 0 : 1 + (7 * id) % 1009; };
  for (const auto& [id, pose] : graph.world_from_node) shuffled.world_from_node[other(id)] = pose;
  for (PoseGraphEdge edge : graph.edges) {
    edge.from = other(edge.from);
    edge.to = other(edge.to);
    shuffled.edges.insert(shuffled.edges.begin(), edge);
  }
  ASSERT_EQ(shuffled.world_from_node.size(), count);
  const auto report = optimize(graph);
  const auto other_report = optimize(shuffled);
  ASSERT_OK(report);
  ASSERT_OK(other_report);
  EXPECT_NEAR(report->error_after, other_report->error_after, 1e-8 * report->error_after);
  for (const auto& [id, pose] : graph.world_from_node) {
    const RigidTransform d = pose.inverse() * shuffled.world_from_node.at(other(id));
    EXPECT_LT(d.distance_m() + d.angle_rad(), 1e-5) << id;
  }
}

TEST(Optimize, GivesTheSameBitsWhateverElseRuns) {
  const PoseGraph graph = random_graph(6, 5);
  const auto solved = [&](PoseGraph& copy) {
    copy = graph;
    EXPECT_OK(optimize(copy, {.loop_kernel = 50}));
  };
  PoseGraph alone;
  solved(alone);
  std::vector<PoseGraph> together(3);
  {
    std::vector<std::jthread> threads;
    for (PoseGraph& copy : together) threads.emplace_back([&] { solved(copy); });
  }
  for (const PoseGraph& copy : together) {
    for (const auto& [id, pose] : alone.world_from_node) {
      EXPECT_EQ(pose.translation, copy.world_from_node.at(id).translation);
      EXPECT_EQ(pose.rotation.coeffs(), copy.world_from_node.at(id).rotation.coeffs());
    }
  }
}

}  // namespace
}  // namespace roomwise::mapping
