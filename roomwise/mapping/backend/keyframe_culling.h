#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "roomwise/mapping/graph/pose_graph.h"
#include "roomwise/scene/keyframe.h"

namespace roomwise::mapping {

using scene::KeyframeId;

// A solved map of which some key-frames are to go; all by key-frame id.
struct MapToCull {
  std::span<const geometry::RigidTransform> world_from_keyframe;
  std::span<const std::size_t> component;
  std::span<const std::size_t> walk;  // that made it
  // Without those that contradict the map.
  std::span<const PoseGraphEdge> edges;
};

// The edges to be added so that those that stay hang together as before, of each component and of
// each walk for itself, when these key-frames (ascending) go with their edges. One after the other,
// the neighbours of each are joined with the one that is known best from it, preferably of its own
// walk, where no two edges lead from one to the other already. So it is the marginal of the pose
// graph, but for a tree in the place of a clique (Kretzschmar and Stachniss, "Information-theoretic
// compression of pose graphs for laser-based SLAM", IJRR 2012): the edges say where the solution
// put the key-frames, and are as unsure as the two that they stand for together.
[[nodiscard]] std::vector<PoseGraphEdge> edges_without(const MapToCull& map,
                                                       std::span<const KeyframeId> culled);

}  // namespace roomwise::mapping
