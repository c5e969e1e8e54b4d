#include "roomwise/mapping/backend/map_solver.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::mapping {
namespace {

using geometry::Matrix6d;
using geometry::RigidTransform;
using geometry::Vector6d;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

// A walk of `count` key-frames along an arc.
std::vector<RigidTransform> walk(std::size_t count) {
  std::vector<RigidTransform> poses(1);
  Vector6d step;
  step << 0.02, 0.12, -0.01, 0.1, 0.02, 0.2;
  while (poses.size() < count) poses.push_back(poses.back() * RigidTransform::exp(step));
  return poses;
}

PoseGraphEdge edge(const std::vector<RigidTransform>& poses, NodeId from, NodeId to, bool is_robust,
                   const RigidTransform& error = {}) {
  return {from, to, poses[from].inverse() * poses[to] * error, 1e4 * Matrix6d::Identity(),
          is_robust};
}
// Each key-frame is linked with the one before it and the `neighbors` before that.
std::vector<PoseGraphEdge> edges_of(const std::vector<RigidTransform>& poses, NodeId neighbors) {
  std::vector<PoseGraphEdge> edges;
  for (NodeId to = 1; to < poses.size(); ++to) {
    edges.push_back(edge(poses, to - 1, to, false));
    for (NodeId back = 2; back <= neighbors + 1 && back <= to; ++back)
      edges.push_back(edge(poses, to - back, to, true));
  }
  return edges;
}
RigidTransform mistake() {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY())), {0.4, -0.1, 0.3}};
}

double worst_error_m(const std::vector<RigidTransform>& found,
                     const std::vector<RigidTransform>& truth) {
  double worst = 0;
  for (std::size_t i = 0; i < truth.size(); ++i)
    worst = std::max(worst, (found.at(i).translation - truth[i].translation).norm());
  return worst;
}

TEST(SolveMap, LeavesARightChainAsItIs) {
  const auto truth = walk(30);
  const auto solution = solve_map(truth.size(), edges_of(truth, 0));
  ASSERT_OK(solution);
  EXPECT_LT(worst_error_m(solution->world_from_keyframe, truth), 1e-9);
  EXPECT_EQ(solution->rejected_edges, 0U);
  EXPECT_EQ(solution->components, 1U);
  EXPECT_NEAR(solution->report.error_after, 0, 1e-9);
}

TEST(SolveMap, AWrongStepThatOtherEdgesContradictDoesNotBendTheMap) {
  const auto truth = walk(24);
  for (const NodeId wrong : {1, 10, 23}) {
    std::vector<PoseGraphEdge> edges = edges_of(truth, 3);
    for (PoseGraphEdge& each : edges) {
      if (each.to == wrong && !each.is_robust)
        each = edge(truth, wrong - 1, wrong, false, mistake());
    }
    const auto solution = solve_map(truth.size(), edges);
    ASSERT_OK(solution);
    EXPECT_LT(worst_error_m(solution->world_from_keyframe, truth), 1e-4) << wrong;
    EXPECT_EQ(solution->rejected_edges, 1U);
    EXPECT_EQ(solution->components, 1U);
  }
}

// Whoever asks afterwards which edges the map is made of must get the same answer.
TEST(IsContradicted, TellsTheStepsThatTheSolverLeftOut) {
  const auto truth = walk(24);
  std::vector<PoseGraphEdge> edges = edges_of(truth, 3);
  edges[0] = edge(truth, 0, 1, false, mistake());
  const auto solution = solve_map(truth.size(), edges);
  ASSERT_OK(solution);
  ASSERT_EQ(solution->rejected_edges, 1U);
  PoseGraph graph;
  for (NodeId id = 0; id < truth.size(); ++id)
    graph.world_from_node[id] = solution->world_from_keyframe[id];
  graph.edges = demote_inconsistent_odometry(truth.size(), edges);
  EXPECT_EQ(std::erase_if(graph.edges,
                          [&](const PoseGraphEdge& each) { return is_contradicted(graph, each); }),
            1U);
  EXPECT_LT(pose_graph_chi2(graph), 1e-3);
}

TEST(SolveMap, SeveralWrongEdgesDoNotBendTheMapEither) {
  const auto truth = walk(40);
  std::vector<PoseGraphEdge> edges = edges_of(truth, 3);
  edges.push_back(edge(truth, 2, 37, true));
  std::size_t wrong = 0;
  for (PoseGraphEdge& each : edges) {
    const bool is_wrong_step = !each.is_robust && (each.to == 8 || each.to == 25);
    const bool is_wrong_loop = each.is_robust && each.from == 15 && each.to == 17;
    if (!is_wrong_step && !is_wrong_loop) continue;
    each = edge(truth, each.from, each.to, each.is_robust, mistake());
    ++wrong;
  }
  edges.push_back(edge(truth, 0, 39, true, {Eigen::Quaterniond::Identity(), {2, 0, 1}}));
  const auto solution = solve_map(truth.size(), edges);
  ASSERT_OK(solution);
  EXPECT_LT(worst_error_m(solution->world_from_keyframe, truth), 1e-4);
  EXPECT_EQ(solution->rejected_edges, wrong + 1);
}

TEST(SolveMap, ALoopLosesAgainstTheTwoStepsThatItContradicts) {
  const auto truth = walk(6);
  std::vector<PoseGraphEdge> edges = edges_of(truth, 0);
  edges.push_back(edge(truth, 2, 4, true, mistake()));
  const auto solution = solve_map(truth.size(), edges);
  ASSERT_OK(solution);
  EXPECT_EQ(solution->rejected_edges, 1U);
  EXPECT_LT(worst_error_m(solution->world_from_keyframe, truth), 1e-4);
}

TEST(SolveMap, KeepsAStepThatNoTriangleJudges) {
  // A loop over four steps contradicts them: the loop is what may be wrong.
  const auto truth = walk(10);
  std::vector<PoseGraphEdge> edges = edges_of(truth, 0);
  edges.push_back(edge(truth, 1, 6, true, {Eigen::Quaterniond::Identity(), {3, 0, 0}}));
  const auto solution = solve_map(truth.size(), edges);
  ASSERT_OK(solution);
  EXPECT_EQ(solution->rejected_edges, 1U);
  EXPECT_LT(worst_error_m(solution->world_from_keyframe, truth), 1e-4);
}

TEST(SolveMap, LeavesOutAWrongLoop) {
  // Ten steps of a metre; one loop claims that the last is where the first is.
  std::vector<PoseGraphEdge> edges;
  const Matrix6d information = 1e4 * Matrix6d::Identity();
  for (NodeId i = 0; i < 10; ++i) {
    edges.push_back({i, i + 1, {Eigen::Quaterniond::Identity(), {1, 0, 0}}, information, false});
    if (i > 0)
      edges.push_back(
          {i - 1, i + 1, {Eigen::Quaterniond::Identity(), {2, 0, 0}}, information, true});
  }
  edges.push_back({0, 10, RigidTransform::identity(), information, true});
  const auto solution = solve_map(11, edges);
  ASSERT_OK(solution);
  EXPECT_EQ(solution->rejected_edges, 1U);
  EXPECT_NEAR(solution->world_from_keyframe[10].translation.x(), 10, 1e-6);
}

TEST(SolveMap, ARightLoopTakesTheDriftAway) {
  const auto truth = walk(40);
  RandomStream random(1);
  std::vector<PoseGraphEdge> edges = edges_of(truth, 0);
  for (PoseGraphEdge& each : edges) {
    Vector6d twist;
    for (int i = 0; i < 6; ++i) twist[i] = 0.004 * random.normal();
    each.from_from_to = each.from_from_to * RigidTransform::exp(twist);
  }
  const auto end_error_m = [&](const MapSolution& solution) {
    return (solution.world_from_keyframe[39].translation - truth[39].translation).norm();
  };
  const double drift = end_error_m(solve_map(40, edges).value());
  for (const NodeId from : {0, 5, 10}) edges.push_back(edge(truth, from, 39 - from, true));
  const auto solution = solve_map(40, edges);
  ASSERT_OK(solution);
  EXPECT_EQ(solution->rejected_edges, 0U);
  EXPECT_LT(end_error_m(*solution), 0.3 * drift);
}

TEST(SolveMap, NumbersTheComponentsBySizeEachInItsOwnWorld) {
  const auto truth = walk(9);
  // 0-1, 2-3-4-5, 6 alone, 7-8: the largest first, of equals the earlier.
  const std::vector<PoseGraphEdge> edges{edge(truth, 0, 1, false), edge(truth, 2, 3, false),
                                         edge(truth, 3, 4, false), edge(truth, 4, 5, false),
                                         edge(truth, 7, 8, false)};
  const auto solution = solve_map(truth.size(), edges);
  ASSERT_OK(solution);
  EXPECT_EQ(solution->components, 4U);
  EXPECT_THAT(solution->component, ElementsAre(1, 1, 0, 0, 0, 0, 3, 2, 2));
  for (const std::size_t first : {0U, 2U, 6U, 7U}) {
    EXPECT_LT(solution->world_from_keyframe[first].distance_m(), 1e-12) << first;
  }
  const RigidTransform expected = truth[2].inverse() * truth[5];
  EXPECT_LT((solution->world_from_keyframe[5].translation - expected.translation).norm(), 1e-9);
}

TEST(SolveMap, RefusesAnEdgeToNowhere) {
  EXPECT_ERROR(solve_map(2, std::vector<PoseGraphEdge>{{0, 2, {}, Matrix6d::Identity(), false}}),
               "map of 2 key-frames");
  EXPECT_ERROR(solve_map(2, std::vector<PoseGraphEdge>{{7, 1, {}, Matrix6d::Identity(), true}}),
               "from key-frame 7 to 1");
  EXPECT_THAT(solve_map(0, {})->world_from_keyframe, IsEmpty());
}

TEST(MapSolverOptions, SaysWhichFieldIsWrong) {
  MapSolverOptions options;
  EXPECT_OK(options.validate());
  options.max_loop_error = 0;
  EXPECT_ERROR(options.validate(), "max_loop_error");
  EXPECT_ERROR(solve_map(1, {}, options), "max_loop_error");
}

}  // namespace
}  // namespace roomwise::mapping
