#include "roomwise/mapping/graph/chordal_start.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "roomwise/base/testing/testing.h"
#include "roomwise/mapping/testing/random_transform.h"
#include "roomwise/mapping/testing/torus_graph.h"

namespace roomwise::mapping {
namespace {

using geometry::RigidTransform;

// As torus_graph(), numbered, with the first pose fixed.
IndexedGraph numbered_chain(const PoseGraph& graph) {
  IndexedGraph result;
  for (const auto& [id, pose] : graph.world_from_node) result.world_from_node.push_back(pose);
  result.fixed_pose_count = 1;
  for (const PoseGraphEdge& edge : graph.edges) {
    result.edges.push_back(
        {static_cast<std::uint32_t>(edge.from), static_cast<std::uint32_t>(edge.to), &edge, 0});
  }
  return result;
}

TEST(ChordalStart, FindsThePosesOfExactEdgesWhateverTheGuess) {
  const PoseGraph graph = testing::torus_graph(
      {.windings = 6, .poses_a_winding = 8, .loops = 30, .sigma_m = 1e-9, .sigma_rad = 1e-9});
  IndexedGraph guess = numbered_chain(graph);
  RandomStream random(3);
  for (std::size_t i = 1; i < guess.world_from_node.size(); ++i)
    guess.world_from_node[i] = testing::random_transform(random, 10, 2);
  const auto start = chordal_start(guess);
  ASSERT_TRUE(start);
  for (std::size_t i = 0; i < start->size(); ++i) {
    const RigidTransform apart = (*start)[i].inverse() * graph.world_from_node.at(i);
    EXPECT_LT(apart.distance_m() + apart.angle_rad(), 1e-5) << i;
  }
}

TEST(ChordalStart, SaysNothingWhereEdgesTellNoTurns) {
  PoseGraph graph = testing::torus_graph({.windings = 4, .poses_a_winding = 6, .loops = 8});
  for (PoseGraphEdge& edge : graph.edges) edge.information.bottomRightCorner<3, 3>().setZero();
  EXPECT_FALSE(chordal_start(numbered_chain(graph)));
}

TEST(Optimize, ConvergesOnATorusWhoseNoisyStepsLeadFarAway) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const testing::TorusOptions options{
        .windings = 30, .poses_a_winding = 20, .loops = 480, .seed = seed};
    PoseGraph graph = testing::torus_graph(options);
    const auto report = optimize(graph);
    ASSERT_OK(report);
    EXPECT_EQ(report->termination, geometry::Termination::kConverged);
    EXPECT_LE(report->iterations, 15);
    // Six numbers an edge, less those of the poses: what is left over is noise.
    const double expected = 6.0 * static_cast<double>(graph.edges.size() - 599);
    EXPECT_NEAR(report->error_after, expected, 0.2 * expected) << seed;
  }
}

TEST(Optimize, KeepsPosesGivenThatAreBetterThanARelaxation) {
  // Where one edge joins each pose, the steps fit exactly.
  PoseGraph graph = testing::torus_graph({.windings = 2, .poses_a_winding = 10, .loops = 0});
  const PoseGraph given = graph;
  ASSERT_OK(optimize(graph));
  for (const auto& [id, pose] : graph.world_from_node)
    EXPECT_LT((pose.translation - given.world_from_node.at(id).translation).norm(), 1e-9);
}

}  // namespace
}  // namespace roomwise::mapping
