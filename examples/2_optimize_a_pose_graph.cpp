// A walk around a square whose steps say that it ends where it began, while a surer loop closure
// says 10 cm lower: the optimisation spreads the difference over the steps.

#include <fmt/format.h>

#include <numbers>

#include "roomwise/mapping/graph/pose_graph.h"

using namespace roomwise;

int main() {
  // Each step: 1 m ahead and 5 cm to the side, then a quarter turn.
  const Eigen::Quaterniond quarter_turn(
      Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitY()));
  const geometry::RigidTransform step{quarter_turn, {0.05, 0, 1}};

  mapping::PoseGraph graph;
  graph.world_from_node[0] = geometry::RigidTransform::identity();
  for (mapping::NodeId node = 0; node < 4; ++node) {
    graph.world_from_node[node + 1] = graph.world_from_node[node] * step;
    graph.edges.push_back({node, node + 1, step, 100 * geometry::Matrix6d::Identity(), false});
  }
  // Node 4 is where node 0 is, 10 cm lower than the steps say.
  const geometry::RigidTransform loop{graph.world_from_node[4].rotation, {0, 0.1, 0}};
  graph.edges.push_back({0, 4, loop, 1000 * geometry::Matrix6d::Identity(), true});

  const auto report = mapping::optimize(graph);
  if (!report) {
    fmt::print(stderr, "{}\n", report.error().message);
    return 1;
  }
  fmt::print("F {:.3f} -> {:.3f} in {} iterations\n", report->error_before, report->error_after,
             report->iterations);
  for (const auto& [node, world_from_node] : graph.world_from_node) {
    const Eigen::Vector3d& place = world_from_node.translation;
    fmt::print("node {}: {:6.3f} {:6.3f} {:6.3f} m\n", node, place.x(), place.y(), place.z());
  }
  return 0;
}
