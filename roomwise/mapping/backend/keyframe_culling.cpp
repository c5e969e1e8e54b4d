#include "roomwise/mapping/backend/keyframe_culling.h"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

#include "roomwise/mapping/graph/edge_composition.h"

namespace roomwise::mapping {
namespace {

class GraphReducer {
 public:
  explicit GraphReducer(const MapToCull& map) : map_(map), edges_of_(map.component.size()) {
    for (const PoseGraphEdge& edge : map.edges) add(edge);
  }

  void cull(KeyframeId id) {
    // By neighbour the surest edge, from there to the key-frame.
    std::map<KeyframeId, PoseGraphEdge> from;
    for (const std::size_t at : edges_of_[id]) {
      const PoseGraphEdge& edge = edges_[at];
      const PoseGraphEdge oriented = edge.to == id ? edge : reversed(edge);
      const auto [known, is_new] = from.try_emplace(oriented.from, oriented);
      if (!is_new && variance_of(oriented) < variance_of(known->second)) known->second = oriented;
    }
    remove(id);
    const auto hub = std::ranges::min_element(from, {}, [&](const auto& one) {
      return std::tuple(map_.component[one.first] != map_.component[id],
                        map_.walk[one.first] != map_.walk[id], variance_of(one.second));
    });
    if (hub == from.end() || map_.component[hub->first] != map_.component[id]) return;
    for (const auto& [neighbor, edge] : from) {
      if (neighbor == hub->first || are_near(hub->first, neighbor)) continue;
      PoseGraphEdge across = composed(at_solution(hub->second), at_solution(reversed(edge)));
      add(across);
    }
  }

  // Those that were added and are there still.
  [[nodiscard]] std::vector<PoseGraphEdge> added() const {
    std::set<std::size_t> left;
    for (const auto& edges : edges_of_) {
      for (const std::size_t at : edges) {
        if (at >= map_.edges.size()) left.insert(at);
      }
    }
    std::vector<PoseGraphEdge> result;
    for (const std::size_t at : left) result.push_back(edges_[at]);
    return result;
  }

 private:
  void add(const PoseGraphEdge& edge) {
    edges_of_[edge.from].push_back(edges_.size());
    edges_of_[edge.to].push_back(edges_.size());
    edges_.push_back(edge);
  }

  void remove(KeyframeId id) {
    for (const std::size_t at : edges_of_[id]) {
      const KeyframeId other = other_end(at, id);
      if (other != id) std::erase(edges_of_[other], at);
    }
    edges_of_[id].clear();
  }

  [[nodiscard]] KeyframeId other_end(std::size_t at, KeyframeId id) const {
    return edges_[at].from == id ? edges_[at].to : edges_[at].from;
  }

  // Between key-frames of one world the measurement is what the solution says.
  [[nodiscard]] PoseGraphEdge at_solution(PoseGraphEdge edge) const {
    if (map_.component[edge.from] == map_.component[edge.to]) {
      edge.from_from_to =
          map_.world_from_keyframe[edge.from].inverse() * map_.world_from_keyframe[edge.to];
    }
    return edge;
  }

  // Whether one or two edges lead from one to the other; of two of one walk within the walk.
  [[nodiscard]] bool are_near(KeyframeId a, KeyframeId b) const {
    const bool is_one_walk = map_.walk[a] == map_.walk[b];
    const auto neighbors = [&](KeyframeId id) {
      std::set<KeyframeId> found;
      for (const std::size_t at : edges_of_[id]) {
        const KeyframeId other = other_end(at, id);
        if (map_.component[other] != map_.component[id]) continue;
        if (!is_one_walk || map_.walk[other] == map_.walk[a]) found.insert(other);
      }
      return found;
    };
    const std::set<KeyframeId> of_a = neighbors(a), of_b = neighbors(b);
    return of_a.contains(b) ||
           std::ranges::any_of(of_a, [&](KeyframeId id) { return of_b.contains(id); });
  }

  const MapToCull& map_;
  std::vector<PoseGraphEdge> edges_;
  std::vector<std::vector<std::size_t>> edges_of_;  // by key-frame
};

}  // namespace

std::vector<PoseGraphEdge> edges_without(const MapToCull& map, std::span<const KeyframeId> culled) {
  GraphReducer reducer(map);
  for (const KeyframeId id : culled) reducer.cull(id);
  return reducer.added();
}

}  // namespace roomwise::mapping
