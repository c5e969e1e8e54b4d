#include "roomwise/mapping/loop_closer.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

namespace roomwise::mapping {
namespace {

// What no residual at the key-points shows: colour and depth a little out of step, calibration,
// rolling shutter.
constexpr double kSystematicTranslation_m = 0.004;
constexpr double kSystematicHalfAngle = 0.5 * 0.003;

}  // namespace

Expected<void> LoopOptions::validate() const {
  if (neighbors < 0 || random < 0 || similar < 0 || explored < 0) {
    return fail("neighbors = {}, random = {}, similar = {} and explored = {} must not be negative",
                neighbors, random, similar, explored);
  }
  if (!(earliest_preference >= 1)) {
    return fail("earliest_preference = {} must be at least 1", earliest_preference);
  }
  if (least_inliers < 4) return fail("least_inliers = {} must be at least 4", least_inliers);
  if (!(least_inlier_ratio >= 0 && least_inlier_ratio <= 1)) {
    return fail("least_inlier_ratio = {} must be between 0 and 1", least_inlier_ratio);
  }
  return {};
}

LoopCandidates draw_loop_candidates(std::size_t keyframe_count, const LoopOptions& options,
                                    RandomStream random) {
  LoopCandidates candidates;
  if (keyframe_count < 3) return candidates;
  // Ids below `older` are neither the newest, nor the last before it, nor its neighbours.
  std::size_t older = keyframe_count - 2;
  for (int i = 0; i < options.neighbors && older > 0; ++i) candidates.neighbors.push_back(--older);

  // The chance falls linearly with time. Drawn without repetition: in a home of few key-frames, all
  // are tried.
  std::vector<KeyframeId> pool(older);
  for (std::size_t id = 0; id < older; ++id) pool[id] = id;
  const auto weight = [&](KeyframeId id) {
    const double age = 1 - static_cast<double>(id) / static_cast<double>(keyframe_count);
    return 1 + (options.earliest_preference - 1) * age;
  };
  for (int draw = 0; draw < options.random && !pool.empty(); ++draw) {
    double total = 0;
    for (const KeyframeId id : pool) total += weight(id);
    double rest = random.uniform() * total;
    std::size_t chosen = 0;
    while (chosen + 1 < pool.size() && rest >= weight(pool[chosen])) rest -= weight(pool[chosen++]);
    candidates.random.push_back(pool[chosen]);
    pool.erase(pool.begin() + static_cast<std::ptrdiff_t>(chosen));
  }
  return candidates;
}

std::vector<PoseGraphEdge> close_loops(std::span<const Keyframe> keyframes,
                                       const LoopOptions& options,
                                       std::span<const KeyframeId> similar,
                                       const CompareKeyframes& compare_frames, std::uint64_t seed) {
  if (keyframes.empty()) return {};
  const Keyframe& newest = keyframes.back();

  // Each key-frame is compared once, however many ways lead to it.
  std::map<KeyframeId, motion::MotionOutcome> compared;
  const auto compare = [&](KeyframeId id) -> const motion::MotionOutcome& {
    auto found = compared.find(id);
    if (found == compared.end()) {
      found =
          compared
              .emplace(id, compare_frames(keyframes[id], newest.measurements, newest.frame_index))
              .first;
    }
    return found->second;
  };
  // The transformation distance by which the paper prefers one hit to another: a metre counts as a
  // radian.
  const auto distance = [](const motion::MotionOutcome& outcome) {
    const geometry::RigidTransform& motion = outcome.pose.reference_from_current;
    return motion.distance_m() + motion.angle_rad();
  };

  const LoopCandidates candidates = draw_loop_candidates(
      keyframes.size(), options, RandomStream(seed, {newest.frame_index, ~0ULL}));
  std::map<KeyframeId, PoseGraphEdge> edges;
  const auto add_edge = [&](KeyframeId id) {
    edges.emplace(id, edge_from_motion(id, newest.id, compare(id).pose, true));
  };
  for (const KeyframeId id : candidates.neighbors) {
    if (compare(id).found()) add_edge(id);
  }
  for (const KeyframeId id : similar) {
    if (compare(id).found()) add_edge(id);
  }
  for (const KeyframeId hit : candidates.random) {
    if (!compare(hit).found()) continue;
    KeyframeId best = hit;
    const KeyframeId first =
        hit - std::min<KeyframeId>(hit, static_cast<KeyframeId>(options.explored));
    // The newest and the last before it are no loop.
    const KeyframeId end = std::min<KeyframeId>(hit + static_cast<KeyframeId>(options.explored) + 1,
                                                keyframes.size() - 2);
    for (KeyframeId id = first; id < end; ++id) {
      if (compare(id).found() && distance(compare(id)) < distance(compare(best))) best = id;
    }
    add_edge(best);
  }
  std::vector<PoseGraphEdge> result;
  for (auto& [id, edge] : edges) result.push_back(edge);
  return result;
}

bool is_return(const PoseGraphEdge& edge) {
  constexpr NodeId kNeighborhood = 10;
  return edge.is_loop &&
         std::max(edge.from, edge.to) - std::min(edge.from, edge.to) > kNeighborhood;
}

PoseGraphEdge edge_from_motion(KeyframeId from, KeyframeId to, const motion::RefinedPose& pose,
                               bool is_loop) {
  return {from, to, pose.reference_from_current,
          motion::with_systematic_error(pose.information, kSystematicTranslation_m,
                                        kSystematicHalfAngle),
          is_loop};
}

}  // namespace roomwise::mapping
