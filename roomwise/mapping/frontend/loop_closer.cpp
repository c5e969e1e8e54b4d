#include "roomwise/mapping/frontend/loop_closer.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

namespace roomwise::mapping {
namespace {

// What no residual at the key-points shows: colour and depth a little out of step, calibration,
// rolling shutter.
constexpr double kSystematicTranslation_m = 0.004;
constexpr double kSystematicHalfAngle_rad = 0.5 * 0.003;

}  // namespace

Expected<void> LoopOptions::validate() const {
  if (neighbors < 0 || random < 0 || similar < 0 || hit_neighbors < 0) {
    return fail(
        "neighbors = {}, random = {}, similar = {} and hit_neighbors = {} must not be negative",
        neighbors, random, similar, hit_neighbors);
  }
  if (!(age_preference >= 1)) {
    return fail("age_preference = {} must be at least 1", age_preference);
  }
  if (min_inliers < 4) return fail("min_inliers = {} must be at least 4", min_inliers);
  if (!(min_inlier_ratio >= 0 && min_inlier_ratio <= 1)) {
    return fail("min_inlier_ratio = {} must be between 0 and 1", min_inlier_ratio);
  }
  return {};
}

std::vector<KeyframeId> sample_loop_candidates(std::size_t keyframe_count,
                                               const LoopOptions& options, RandomStream random) {
  std::vector<KeyframeId> drawn;
  const std::size_t not_drawn = 2 + static_cast<std::size_t>(options.neighbors);
  if (keyframe_count <= not_drawn) return drawn;

  // The chance falls linearly with time. Drawn without repetition: in a home of few key-frames, all
  // are tried.
  std::vector<KeyframeId> pool(keyframe_count - not_drawn);
  for (std::size_t id = 0; id < pool.size(); ++id) pool[id] = id;
  const auto weight = [&](KeyframeId id) {
    const double age = 1 - static_cast<double>(id) / static_cast<double>(keyframe_count);
    return 1 + (options.age_preference - 1) * age;
  };
  for (int draw = 0; draw < options.random && !pool.empty(); ++draw) {
    double total = 0;
    for (const KeyframeId id : pool) total += weight(id);
    double rest = random.uniform() * total;
    std::size_t chosen = 0;
    while (chosen + 1 < pool.size() && rest >= weight(pool[chosen])) rest -= weight(pool[chosen++]);
    drawn.push_back(pool[chosen]);
    pool.erase(pool.begin() + static_cast<std::ptrdiff_t>(chosen));
  }
  return drawn;
}

Expected<std::vector<PoseGraphEdge>> close_loops(const KeyframeStamp& newest,
                                                 const LoopOptions& options,
                                                 std::span<const KeyframeId> neighbors,
                                                 std::span<const KeyframeId> similar,
                                                 const CompareKeyframes& compare_frames,
                                                 std::uint64_t seed) {
  // Each key-frame is compared once, however many ways lead to it.
  std::map<KeyframeId, motion::MotionOutcome> compared;
  const auto compare = [&](KeyframeId id) -> Expected<const motion::MotionOutcome*> {
    auto known = compared.find(id);
    if (known == compared.end()) {
      ROOMWISE_TRY(motion::MotionOutcome outcome, compare_frames(id));
      known = compared.emplace(id, std::move(outcome)).first;
    }
    return &known->second;
  };
  // The transformation distance by which the paper prefers one hit to another: a metre counts as a
  // radian.
  const auto distance = [](const motion::MotionOutcome& outcome) {
    const geometry::RigidTransform& motion = outcome.pose.reference_from_current;
    return motion.distance_m() + motion.angle_rad();
  };
  std::map<KeyframeId, PoseGraphEdge> edges;
  const auto add_edge = [&](KeyframeId id, const motion::MotionOutcome& outcome) {
    edges.emplace(id, edge_from_motion(id, newest.id, outcome.pose, true));
  };

  for (const auto& ids : {neighbors, similar}) {
    for (const KeyframeId id : ids) {
      ROOMWISE_TRY(const motion::MotionOutcome* outcome, compare(id));
      if (outcome->found()) add_edge(id, *outcome);
    }
  }
  for (const KeyframeId hit : sample_loop_candidates(
           newest.id + 1, options, RandomStream(seed, {newest.frame_index, ~0ULL}))) {
    ROOMWISE_TRY(const motion::MotionOutcome* best, compare(hit));
    if (!best->found()) continue;
    KeyframeId best_id = hit;
    const auto reach = static_cast<KeyframeId>(options.hit_neighbors);
    // The newest and the last before it are no loop.
    const KeyframeId end = std::min<KeyframeId>(hit + reach + 1, newest.id - 1);
    for (KeyframeId id = hit - std::min(hit, reach); id < end; ++id) {
      ROOMWISE_TRY(const motion::MotionOutcome* outcome, compare(id));
      if (!outcome->found() || distance(*outcome) >= distance(*best)) continue;
      best = outcome;
      best_id = id;
    }
    add_edge(best_id, *best);
  }
  std::vector<PoseGraphEdge> result;
  for (auto& [id, edge] : edges) result.push_back(edge);
  return result;
}

bool spans_long_loop(const PoseGraphEdge& edge) {
  constexpr NodeId kNeighborhood = 10;
  return edge.is_robust && !edge.is_device_motion &&
         std::max(edge.from, edge.to) - std::min(edge.from, edge.to) > kNeighborhood;
}

PoseGraphEdge edge_from_motion(KeyframeId from, KeyframeId to, const motion::RefinedPose& pose,
                               bool is_robust) {
  return {from,
          to,
          pose.reference_from_current,
          motion::with_systematic_error(pose.information, kSystematicTranslation_m,
                                        kSystematicHalfAngle_rad),
          is_robust,
          false};
}

PoseGraphEdge edge_through_frame(KeyframeId from, const motion::RefinedPose& in_from, KeyframeId to,
                                 const motion::RefinedPose& in_to) {
  // With errors a and b of the frame's poses A and B, A a (B b)^-1 = A B^-1 (B a b^-1 B^-1): the
  // covariances add, and the adjoint takes them from the frame to `to` (to first order, where the
  // rotation's part is half an angle).
  const geometry::RigidTransform& to_from_frame = in_to.reference_from_current;
  const Eigen::Matrix3d rotation = to_from_frame.rotation.toRotationMatrix();
  geometry::Matrix6d adjoint = geometry::Matrix6d::Zero();
  adjoint.topLeftCorner<3, 3>() = rotation;
  adjoint.bottomRightCorner<3, 3>() = rotation;
  for (Eigen::Index i = 0; i < 3; ++i) {
    adjoint.topRightCorner<3, 3>().col(i) = 2 * to_from_frame.translation.cross(rotation.col(i));
  }
  // What neither pose determines stays nearly undetermined.
  constexpr double kMinInformation = 1e-6;
  const geometry::Matrix6d regularization = kMinInformation * geometry::Matrix6d::Identity();
  const geometry::Matrix6d covariance = (in_from.information + regularization).inverse() +
                                        (in_to.information + regularization).inverse();
  const geometry::Matrix6d inverse = (adjoint * covariance * adjoint.transpose()).inverse();
  motion::RefinedPose between;
  between.reference_from_current = in_from.reference_from_current * to_from_frame.inverse();
  between.information = 0.5 * (inverse + inverse.transpose());
  return edge_from_motion(from, to, between, true);
}

}  // namespace roomwise::mapping
