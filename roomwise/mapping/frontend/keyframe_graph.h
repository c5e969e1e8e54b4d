#pragma once

#include <optional>
#include <vector>

#include "roomwise/mapping/frontend/keyframe.h"
#include "roomwise/mapping/graph/pose_graph.h"

namespace roomwise::mapping {

// The edges between key-frames, in the order in which they were measured, and the ways along them.
class KeyframeGraph {
 public:
  void add(const PoseGraphEdge& edge);
  [[nodiscard]] const std::vector<PoseGraphEdge>& edges() const { return edges_; }

  // Where a key-frame is relative to another by the first edge that joins them.
  [[nodiscard]] std::optional<geometry::RigidTransform> between(KeyframeId from,
                                                                KeyframeId to) const;

  // The key-frame to which the first edge of this one leads, which is the one that it was tracked
  // from.
  [[nodiscard]] std::optional<KeyframeId> tracked_from(KeyframeId keyframe) const;

  struct Nearby {
    KeyframeId id = 0;
    geometry::RigidTransform keyframe_from_nearby;
  };
  // The key-frames that one edge joins with this one, then those that two do, each by the first way
  // that leads there.
  [[nodiscard]] std::vector<Nearby> around(KeyframeId keyframe) const;

 private:
  // By the edges of one key-frame, in their order.
  [[nodiscard]] std::vector<Nearby> joined(KeyframeId keyframe) const;

  std::vector<PoseGraphEdge> edges_;
  std::vector<std::vector<std::size_t>> edges_of_;  // by key-frame id, indices of edges_
};

}  // namespace roomwise::mapping
