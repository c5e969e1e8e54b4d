#include "roomwise/mapping/frontend/keyframe_graph.h"

#include <algorithm>
#include <set>

namespace roomwise::mapping {

using geometry::RigidTransform;

void KeyframeGraph::add(const PoseGraphEdge& edge) {
  edges_of_.resize(std::max<std::size_t>(edges_of_.size(), std::max(edge.from, edge.to) + 1));
  edges_of_[edge.from].push_back(edges_.size());
  edges_of_[edge.to].push_back(edges_.size());
  edges_.push_back(edge);
}

std::vector<KeyframeGraph::Nearby> KeyframeGraph::joined(KeyframeId keyframe) const {
  std::vector<Nearby> joined;
  if (keyframe >= edges_of_.size()) return joined;
  for (const std::size_t i : edges_of_[keyframe]) {
    const PoseGraphEdge& edge = edges_[i];
    if (edge.from == keyframe) {
      joined.push_back({edge.to, edge.from_from_to});
    } else {
      joined.push_back({edge.from, edge.from_from_to.inverse()});
    }
  }
  return joined;
}

std::optional<RigidTransform> KeyframeGraph::between(KeyframeId from, KeyframeId to) const {
  if (from >= edges_of_.size()) return std::nullopt;
  for (const std::size_t i : edges_of_[from]) {
    const PoseGraphEdge& edge = edges_[i];
    if (edge.from == from && edge.to == to) return edge.from_from_to;
    if (edge.to == from && edge.from == to) return edge.from_from_to.inverse();
  }
  return std::nullopt;
}

std::optional<KeyframeId> KeyframeGraph::tracked_from(KeyframeId keyframe) const {
  if (keyframe >= edges_of_.size() || edges_of_[keyframe].empty()) return std::nullopt;
  const PoseGraphEdge& first = edges_[edges_of_[keyframe].front()];
  return first.from == keyframe ? first.to : first.from;
}

std::vector<KeyframeGraph::Nearby> KeyframeGraph::around(KeyframeId keyframe) const {
  std::vector<Nearby> around;
  std::set<KeyframeId> known{keyframe};
  for (const Nearby& first : joined(keyframe)) {
    if (known.insert(first.id).second) around.push_back(first);
  }
  const std::size_t first_ring = around.size();
  for (std::size_t i = 0; i < first_ring; ++i) {
    const Nearby first = around[i];
    for (const Nearby& second : joined(first.id)) {
      if (!known.insert(second.id).second) continue;
      around.push_back({second.id, first.keyframe_from_nearby * second.keyframe_from_nearby});
    }
  }
  return around;
}

}  // namespace roomwise::mapping
