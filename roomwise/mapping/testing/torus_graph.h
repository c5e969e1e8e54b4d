#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "roomwise/base/random.h"
#include "roomwise/mapping/graph/pose_graph.h"
#include "roomwise/mapping/testing/random_transform.h"

namespace roomwise::mapping::testing {

struct TorusOptions {
  std::uint64_t windings = 100;
  std::uint64_t poses_a_winding = 50;
  std::uint64_t loops = 4049;  // between neighbouring windings, drawn without repetition
  double sigma_m = 0.1;        // of each measurement, along each axis
  double sigma_rad = 0.1;      // about each axis
  std::uint64_t seed = 1;
};

// A camera that winds round a tube which is bent to a ring, with steps of about a metre, and sees
// its neighbours on the winding before: the literature's hard graph (Carlone, Tron, Daniilidis and
// Dellaert, "Initialization techniques for 3D SLAM", 2015), whose published form has 5,000 poses
// and 9,048 edges. The poses are those that the noisy steps lead to.
inline PoseGraph torus_graph(const TorusOptions& options = {}) {
  const std::uint64_t count = options.windings * options.poses_a_winding;
  const double turn = 2 * std::numbers::pi;
  const double tube_m = static_cast<double>(options.poses_a_winding) / turn;
  const double ring_m = std::max(2 * tube_m, static_cast<double>(options.windings) / turn + tube_m);
  const auto truth_of = [&](std::uint64_t i) {
    const double round_tube =
        turn * static_cast<double>(i) / static_cast<double>(options.poses_a_winding);
    const double round_ring = turn * static_cast<double>(i) / static_cast<double>(count);
    const Eigen::Vector3d outward(std::cos(round_ring), std::sin(round_ring), 0);
    const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d normal = std::cos(round_tube) * outward + std::sin(round_tube) * up;
    const Eigen::Vector3d ahead = std::cos(round_tube) * up - std::sin(round_tube) * outward;
    Eigen::Matrix3d axes;
    axes << ahead, normal.cross(ahead), normal;
    return geometry::RigidTransform{Eigen::Quaterniond(axes), ring_m * outward + tube_m * normal};
  };
  RandomStream random(options.seed);
  PoseGraph graph;
  geometry::Matrix6d information = geometry::Matrix6d::Zero();
  information.diagonal().head<3>().setConstant(1 / (options.sigma_m * options.sigma_m));
  information.diagonal().tail<3>().setConstant(4 / (options.sigma_rad * options.sigma_rad));
  const auto measure = [&](NodeId from, NodeId to, bool is_loop) {
    graph.edges.push_back({from, to,
                           truth_of(from).inverse() * truth_of(to) *
                               random_transform(random, options.sigma_m, options.sigma_rad),
                           information, is_loop});
  };
  graph.world_from_node[0] = truth_of(0);
  for (NodeId id = 1; id < count; ++id) {
    measure(id - 1, id, false);
    graph.world_from_node[id] = graph.world_from_node[id - 1] * graph.edges.back().from_from_to;
  }
  std::vector<NodeId> later;
  for (NodeId id = options.poses_a_winding; id < count; ++id) later.push_back(id);
  std::shuffle(later.begin(), later.end(), random);
  later.resize(std::min<std::size_t>(later.size(), options.loops));
  std::ranges::sort(later);
  for (const NodeId id : later) measure(id - options.poses_a_winding, id, true);
  return graph;
}

}  // namespace roomwise::mapping::testing
