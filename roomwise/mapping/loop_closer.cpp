#include "roomwise/mapping/loop_closer.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

namespace roomwise::mapping {
namespace {

// What no residual at the key-points shows: colour and depth a little out of step, calibration,
// rolling shutter. Added to each edge's covariance so that hundreds of inliers do not claim
// micrometres.
constexpr double kSystematicTranslation_m = 0.004;
constexpr double kSystematicHalfAngle = 0.5 * 0.003;

}  // namespace

Expected<void> LoopOptions::validate() const {
  if (neighbors < 0 || random < 0 || explored < 0) {
    return fail("neighbors = {}, random = {} and explored = {} must not be negative", neighbors,
                random, explored);
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
                                       const geometry::PinholeCamera& camera,
                                       const motion::MotionOptions& motion_options,
                                       const LoopOptions& options, std::uint64_t seed) {
  if (keyframes.empty()) return {};
  const Keyframe& newest = keyframes.back();
  motion::MotionOptions strict = motion_options;
  strict.least_inliers = std::max(strict.least_inliers, options.least_inliers);
  strict.least_matches = std::max(strict.least_matches, options.least_inliers);
  strict.least_inlier_ratio = std::max(strict.least_inlier_ratio, options.least_inlier_ratio);

  // Each key-frame is compared once, however many ways lead to it.
  std::map<KeyframeId, motion::MotionOutcome> compared;
  const auto compare = [&](KeyframeId id) -> const motion::MotionOutcome& {
    auto found = compared.find(id);
    if (found == compared.end()) {
      found = compared
                  .emplace(id, motion::estimate_motion(
                                   keyframes[id].features, newest.features, camera, strict,
                                   RandomStream(seed, {newest.frame_index, id})))
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
  geometry::Vector6d systematic;
  systematic.head<3>().setConstant(kSystematicTranslation_m * kSystematicTranslation_m);
  systematic.tail<3>().setConstant(kSystematicHalfAngle * kSystematicHalfAngle);
  // (I^-1 + S)^-1 = (I S + 1)^-1 I, which needs no inverse of a curvature that may be singular.
  const geometry::Matrix6d mixed =
      pose.information * systematic.asDiagonal() + geometry::Matrix6d::Identity();
  geometry::Matrix6d information = mixed.partialPivLu().solve(pose.information);
  information = (0.5 * (information + information.transpose())).eval();
  return {from, to, pose.reference_from_current, information, is_loop};
}

}  // namespace roomwise::mapping
