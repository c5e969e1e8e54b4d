#include "roomwise/mapping/graph/pose_graph.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/mapping/graph/g2o_file.h"
#include "roomwise/mapping/testing/random_transform.h"

namespace roomwise::mapping {
namespace {

using geometry::Matrix6d;
using geometry::RigidTransform;
using geometry::Vector6d;

RigidTransform translated(double x_m, double y_m = 0, double z_m = 0) {
  return {Eigen::Quaterniond::Identity(), {x_m, y_m, z_m}};
}

RigidTransform turned_about_z(double angle_rad, double x_m = 0, double y_m = 0) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitZ())),
          {x_m, y_m, 0}};
}

double difference(const RigidTransform& a, const RigidTransform& b) {
  const RigidTransform d = a.inverse() * b;
  return d.angle_rad() + d.distance_m();
}

// The corners of a square of 1 m, walked round once: four nodes, four true edges.
PoseGraph square() {
  const RigidTransform side = turned_about_z(std::numbers::pi / 2, 1, 0);
  PoseGraph graph;
  RigidTransform pose;
  for (NodeId id = 0; id < 4; ++id) {
    graph.world_from_node[id] = pose;
    graph.edges.push_back({.from = id, .to = (id + 1) % 4, .from_from_to = side});
    pose = pose * side;
  }
  graph.edges.back().is_robust = true;
  return graph;
}

void disturb(PoseGraph& graph, double scale) {
  RandomStream random(7);
  for (auto& [id, pose] : graph.world_from_node) {
    if (id != graph.world_from_node.begin()->first)
      pose = pose * testing::random_transform(random, scale, scale);
  }
}

TEST(PoseGraphError, FollowsTheDocumentedFormula) {
  PoseGraph graph;
  graph.world_from_node[3] = turned_about_z(0.5, 1, 2);
  graph.world_from_node[8] = graph.world_from_node[3] * turned_about_z(0.2, 2, 0);
  Matrix6d information = Matrix6d::Zero();
  information.diagonal() << 1, 10, 100, 1000, 10000, 100000;
  information(0, 5) = information(5, 0) = 7;
  graph.edges.push_back({3, 8, translated(1.5), information, false});
  // e = (0.5, 0, 0, 0, 0, sin(0.1)).
  const double s = std::sin(0.1);
  EXPECT_NEAR(pose_graph_chi2(graph), 0.25 + 100000 * s * s + 2 * 7 * 0.5 * s, 1e-9);

  // A quaternion and its negative are one rotation and give one error.
  graph.world_from_node[8].rotation.coeffs() *= -1;
  EXPECT_NEAR(pose_graph_chi2(graph), 0.25 + 100000 * s * s + 2 * 7 * 0.5 * s, 1e-9);
}

TEST(PoseGraphError, MeasuresTheTranslationInTheMeasuredFrame) {
  // d = measured^-1 * estimated: a difference along the world's x is one along -y of a frame that
  // was measured a quarter turn away.
  PoseGraph graph;
  graph.world_from_node[0] = RigidTransform();
  graph.world_from_node[1] = turned_about_z(std::numbers::pi / 2, 1, 0);
  Matrix6d information = Matrix6d::Zero();
  information(1, 1) = 4;
  graph.edges.push_back({0, 1, turned_about_z(std::numbers::pi / 2), information, false});
  EXPECT_NEAR(pose_graph_chi2(graph), 4, 1e-12);
}

TEST(Optimize, RestoresADisturbedSquare) {
  PoseGraph graph = square();
  const PoseGraph truth = graph;
  disturb(graph, 0.3);
  const auto report = optimize(graph);
  ASSERT_OK(report);
  EXPECT_GT(report->error_before, 0.1);
  EXPECT_LT(report->error_after, 1e-12);
  EXPECT_EQ(report->termination, geometry::Termination::kConverged);
  for (const auto& [id, pose] : truth.world_from_node) {
    EXPECT_LT(difference(pose, graph.world_from_node.at(id)), 1e-6) << id;
  }
  EXPECT_EQ(graph.world_from_node.at(0).translation, truth.world_from_node.at(0).translation);
}

TEST(Optimize, SpreadsAContradictionByItsWeights) {
  // On a line: odometry says 1 m + 1 m, a loop of three times its weight says 2.5 m. With steps
  // 1 + a: F = 2 a^2 + 3 (2 a - 0.5)^2 is least at a = 3 / 14.
  PoseGraph graph;
  for (NodeId id = 0; id < 3; ++id) graph.world_from_node[id] = translated(double(id));
  graph.edges.push_back({.from = 0, .to = 1, .from_from_to = translated(1)});
  graph.edges.push_back({.from = 1, .to = 2, .from_from_to = translated(1)});
  graph.edges.push_back({0, 2, translated(2.5), 3 * Matrix6d::Identity(), true});
  const auto report = optimize(graph);
  ASSERT_OK(report);
  EXPECT_NEAR(report->error_before, 3 * 0.25, 1e-12);
  const double a = 3.0 / 14;
  EXPECT_NEAR(report->error_after, 2 * a * a + 3 * (2 * a - 0.5) * (2 * a - 0.5), 1e-9);
  EXPECT_NEAR(graph.world_from_node.at(1).translation.x(), 1 + a, 1e-6);
  EXPECT_NEAR(graph.world_from_node.at(2).translation.x(), 2 + 2 * a, 1e-6);
}

TEST(Optimize, AKernelKeepsAWrongLoopFromBendingTheMap) {
  const auto farthest_from_truth = [](double loop_kernel) {
    PoseGraph graph = square();
    const PoseGraph truth = graph;
    graph.edges.push_back({0, 2, translated(-3, 4, 2), Matrix6d::Identity(), true});
    for (PoseGraphEdge& edge : graph.edges) edge.information *= 100;
    EXPECT_OK(optimize(graph, {.loop_kernel = loop_kernel}));
    double farthest = 0;
    for (const auto& [id, pose] : truth.world_from_node) {
      farthest = std::max(farthest, difference(pose, graph.world_from_node.at(id)));
    }
    return farthest;
  };
  EXPECT_GT(farthest_from_truth(0), 1);
  EXPECT_LT(farthest_from_truth(0.1), 0.01);
}

TEST(Optimize, HoldsTheLowestNodeOfEachPartStill) {
  PoseGraph graph;
  for (const NodeId id : {2, 4, 5, 7, 9}) {
    graph.world_from_node[id] = translated(double(id), double(id * id) / 10);
  }
  graph.edges.push_back({.from = 9, .to = 4, .from_from_to = translated(1)});
  graph.edges.push_back({.from = 7, .to = 2, .from_from_to = translated(0, 2)});
  const PoseGraph before = graph;  // node 5 has no edge
  ASSERT_OK(optimize(graph));
  for (const NodeId id : {2, 4, 5}) {
    EXPECT_EQ(difference(graph.world_from_node.at(id), before.world_from_node.at(id)), 0) << id;
  }
  const auto from_from_to = [&](NodeId from, NodeId to) {
    return graph.world_from_node.at(from).inverse() * graph.world_from_node.at(to);
  };
  EXPECT_LT(difference(from_from_to(9, 4), translated(1)), 1e-6);
  EXPECT_LT(difference(from_from_to(7, 2), translated(0, 2)), 1e-6);
}

TEST(Optimize, DoesNotDependOnTheWorldsOrigin) {
  // F does not know where the world's origin lies: the same graph seen from another frame ends at
  // the same F and the same relative poses.
  PoseGraph graph = square();
  graph.edges[1].from_from_to.translation.x() += 0.2;
  disturb(graph, 0.1);
  RandomStream random(3);
  const RigidTransform other_from_world = testing::random_transform(random, 1, 1);
  PoseGraph other = graph;
  for (auto& [id, pose] : other.world_from_node) pose = other_from_world * pose;
  const auto report = optimize(graph);
  const auto other_report = optimize(other);
  ASSERT_OK(report);
  ASSERT_OK(other_report);
  EXPECT_NEAR(report->error_after, other_report->error_after, 1e-9);
  for (const auto& [id, pose] : graph.world_from_node) {
    EXPECT_LT(difference(other_from_world * pose, other.world_from_node.at(id)), 1e-4) << id;
  }
}

TEST(Optimize, TakesInformationThatSaysNothingAboutSomeDirections) {
  PoseGraph graph;
  graph.world_from_node[0] = RigidTransform();
  graph.world_from_node[1] = translated(1, 5);
  Matrix6d only_x = Matrix6d::Zero();
  only_x(0, 0) = 10;
  graph.edges.push_back({0, 1, translated(2), only_x, false});
  const auto report = optimize(graph);
  ASSERT_OK(report);
  EXPECT_LT(report->error_after, 1e-9);
  EXPECT_NEAR(graph.world_from_node.at(1).translation.x(), 2, 1e-5);
  EXPECT_NEAR(graph.world_from_node.at(1).translation.y(), 5, 1e-5);
}

TEST(Optimize, LeavesAGraphWithoutEdgesOrNodesAlone) {
  PoseGraph empty;
  const auto nothing = optimize(empty);
  ASSERT_OK(nothing);
  EXPECT_EQ(nothing->error_after, 0);
  PoseGraph lonely;
  lonely.world_from_node[4] = translated(1);
  ASSERT_OK(optimize(lonely));
  EXPECT_EQ(lonely.world_from_node.at(4).translation.x(), 1);
}

TEST(Optimize, TheSameGraphGivesTheSameBits) {
  PoseGraph first = square();
  disturb(first, 0.4);
  PoseGraph second = first;
  ASSERT_OK(optimize(first));
  ASSERT_OK(optimize(second));
  for (const auto& [id, pose] : first.world_from_node) {
    const RigidTransform& other = second.world_from_node.at(id);
    EXPECT_EQ(pose.translation, other.translation);
    EXPECT_EQ(pose.rotation.coeffs(), other.rotation.coeffs());
  }
}

TEST(Optimize, OfInformationThatIsNegativeInADirectionTakesTheRest) {
  PoseGraph graph = square();
  PoseGraph without = graph;
  graph.edges[1].information(2, 2) = -1;
  without.edges[1].information(2, 2) = 0;
  disturb(graph, 0.1);
  disturb(without, 0.1);
  const auto report = optimize(graph);
  ASSERT_OK(report);
  EXPECT_EQ(report->indefinite_edges, 1U);
  EXPECT_EQ(graph.edges[1].information(2, 2), -1) << "the edge stays as it was given";
  const auto same = optimize(without);
  ASSERT_OK(same);
  EXPECT_EQ(same->indefinite_edges, 0U);
  EXPECT_NEAR(report->error_after, same->error_after, 1e-9);
  for (const auto& [id, pose] : graph.world_from_node)
    EXPECT_LT((pose.translation - without.world_from_node[id].translation).norm(), 1e-6);
}

TEST(Optimize, NamesWhatIsWrongAndLeavesTheGraph) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const auto broken = [](auto&& breaking) {
    PoseGraph graph = square();
    breaking(graph);
    return optimize(graph);
  };
  EXPECT_ERROR(broken([](PoseGraph& g) { g.edges[2].to = 17; }),
               "edge from node 2 to node 17 needs node 17");
  EXPECT_ERROR(broken([](PoseGraph& g) { g.edges[2].to = 2; }), "joins a node to itself");
  EXPECT_ERROR(broken([](PoseGraph& g) { g.world_from_node[3].translation.y() = kNan; }),
               "pose of node 3");
  EXPECT_ERROR(broken([](PoseGraph& g) { g.world_from_node[3].rotation.coeffs() *= 2; }),
               "quaternion of length 2");
  EXPECT_ERROR(broken([](PoseGraph& g) { g.edges[1].from_from_to.translation.x() = kNan; }),
               "transform of the edge from node 1 to node 2");
  EXPECT_ERROR(broken([](PoseGraph& g) { g.edges[1].information(2, 2) = kNan; }),
               "information of the edge from node 1 to node 2");
  EXPECT_ERROR(broken([](PoseGraph& g) { g.edges[1].information(2, 3) = 0.5; }), "not symmetric");

  PoseGraph far = square();
  far.world_from_node[2].translation.x() = 1e300;
  const PoseGraph before = far;
  EXPECT_ERROR(optimize(far), "too large to square");
  EXPECT_EQ(far.world_from_node[2].translation, before.world_from_node.at(2).translation);
}

TEST(Optimize, NamesTheOptionThatIsWrong) {
  PoseGraph graph = square();
  EXPECT_ERROR(optimize(graph, {.max_iterations = 0}), "max_iterations");
  EXPECT_ERROR(optimize(graph, {.relative_tolerance = 0}), "relative_tolerance");
  EXPECT_ERROR(optimize(graph, {.loop_kernel = -1}), "loop_kernel");
}

TEST(Optimize, SaysWhenItStopsBeforeTheMinimum) {
  PoseGraph graph = square();
  disturb(graph, 0.3);
  const auto report = optimize(graph, {.max_iterations = 1, .relaxes_start = false});
  ASSERT_OK(report);
  EXPECT_EQ(report->termination, geometry::Termination::kMaxIterations);
  EXPECT_EQ(report->iterations, 1);
  EXPECT_LT(report->error_after, report->error_before);
}

// Public benchmarks and the optimum that g2o reaches from the guess in the file.
struct Benchmark {
  const char* name;
  const char* file;
  double optimum;
};
class OptimizeBenchmark : public ::testing::TestWithParam<Benchmark> {};

TEST_P(OptimizeBenchmark, ReachesTheKnownOptimum) {
  const auto path = roomwise::testing::find_data(std::string("pose_graphs/") + GetParam().file);
  ROOMWISE_REQUIRE_FILE(path);
  auto graph = read_g2o(*path);
  ASSERT_OK(graph);
  const auto report = optimize(*graph);
  ASSERT_OK(report);
  EXPECT_EQ(report->termination, geometry::Termination::kConverged);
  EXPECT_NEAR(report->error_after, GetParam().optimum, 1e-4 * GetParam().optimum);
}

INSTANTIATE_TEST_SUITE_P(PublicGraphs, OptimizeBenchmark,
                         ::testing::Values(Benchmark{"Sphere", "sphere2500.g2o", 727.149},
                                           Benchmark{"ParkingGarage", "parking-garage.g2o",
                                                     1.23868},
                                           Benchmark{"SmallGrid", "smallGrid3D.g2o", 458.154}),
                         [](const auto& benchmark) { return std::string(benchmark.param.name); });

// Stops the work when it is asked for the so-manyth time.
class StopAt final : public Interruption {
 public:
  explicit StopAt(int ask) : ask_(ask) {}
  [[nodiscard]] bool interrupted() const override { return ++asked_ >= ask_; }

 private:
  int ask_;
  mutable int asked_ = 0;
};

TEST(Optimize, InterruptedLeavesTheGraphAsItWas) {
  PoseGraph graph = square();
  disturb(graph, 0.1);
  const PoseGraph before = graph;
  for (const bool relaxes_start : {false, true}) {
    PoseGraphOptions options;
    options.relaxes_start = relaxes_start;
    // A relaxation asks before both of its steps and after them, and leaves one iteration to do.
    for (int ask = 1; ask <= (relaxes_start ? 4 : 2); ++ask) {
      const auto stopped = optimize(graph, options, StopAt(ask));
      ASSERT_FALSE(stopped.has_value()) << relaxes_start << ask;
      EXPECT_EQ(stopped.error().code, ErrorCode::kInterrupted);
      for (const auto& [id, pose] : before.world_from_node)
        EXPECT_EQ(difference(graph.world_from_node.at(id), pose), 0) << id;
    }
  }
  EXPECT_TRUE(optimize(graph, {}, StopAt(1000)));
}

}  // namespace
}  // namespace roomwise::mapping
