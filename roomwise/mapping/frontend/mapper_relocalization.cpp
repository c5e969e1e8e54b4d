// The part of Mapper that compares frames with any key-frames, for loops and where it is lost.

#include <algorithm>
#include <limits>

#include "roomwise/mapping/frontend/mapper.h"

namespace roomwise::mapping {

std::vector<KeyframeId> Mapper::similar_keyframes(const motion::FrameMeasurements& measurements,
                                                  KeyframeId before) const {
  std::vector<KeyframeId> similar;
  if (options_.loops.similar == 0) return similar;
  const auto find = [&](KeyframeId first, KeyframeId end) {
    for (const AppearanceIndex::Hit& hit :
         index_.find(measurements.features().features, first, end,
                     static_cast<std::size_t>(options_.loops.similar))) {
      similar.push_back(hit.id);
    }
  };
  find(first_keyframe_, before);
  if (first_keyframe_ > 0) find(0, first_keyframe_);
  return similar;
}

Mapper::Outcome Mapper::compare(KeyframeId reference, const motion::FrameMeasurements& current,
                                std::uint64_t frame_index,
                                const std::optional<motion::PosePrior>& prior) {
  // A loop must be surer than a step of the odometry.
  motion::LocatorOptions strict = options_.locator;
  strict.rests_on_prior = false;
  // A prior, where there is one, is too narrow here for the views to fit a period off it; and who
  // finds a known place takes an answer without matches for one by views alone.
  strict.cross_check_min_translation_m = strict.cross_check_min_rotation_rad =
      std::numeric_limits<double>::infinity();
  motion::MotionOptions& features = strict.features;
  features.min_inliers = std::max(features.min_inliers, options_.loops.min_inliers);
  features.min_matches = std::max(features.min_matches, options_.loops.min_inliers);
  features.min_inlier_ratio = std::max(features.min_inlier_ratio, options_.loops.min_inlier_ratio);
  ROOMWISE_TRY(const SharedMeasurements measured, store_.get(reference));
  const RandomStream random(options_.seed, {frame_index, reference});
  if (options_.method == MappingMethod::kPaper) {
    return motion::estimate_motion(measured->features(), current.features(), camera_, features,
                                   random);
  }
  if (prior) {
    const double overlap =
        motion::compare_views(measured->view(), current.view(), prior->reference_from_current)
            .overlap;
    if (overlap < strict.views.min_overlap) {
      motion::MotionOutcome nothing;
      nothing.status = motion::MotionStatus::kTooLittleOverlap;
      return nothing;
    }
  }
  return motion::locate_frame(*measured, current, prior, camera_, strict, random);
}

Expected<void> Mapper::relocalize(const motion::FrameMeasurements& current, KeyframeId& reference,
                                  motion::MotionOutcome& outcome) {
  // Being lost, any key-frame may be the one: the candidates of a loop closure, as if this frame
  // were a key-frame.
  const std::uint64_t frame_index = frames_.back().index;
  std::vector<KeyframeId> ids = recent_references(1);
  const std::vector<KeyframeId> similar = similar_keyframes(current, keyframes_.size());
  ids.insert(ids.end(), similar.begin(), similar.end());
  const std::vector<KeyframeId> drawn = sample_loop_candidates(
      keyframes_.size() + 1, options_.loops, RandomStream(options_.seed, {frame_index, ~1ULL}));
  ids.insert(ids.end(), drawn.begin(), drawn.end());
  // The reference has answered. A step that was refused for what the device or the walk says is not
  // to come back, asked without either, as one of the odometry.
  std::erase(ids, reference);
  for (const KeyframeId id : ids) {
    ROOMWISE_TRY(const motion::MotionOutcome attempt,
                 compare(id, current, frame_index, std::nullopt));
    if (!attempt.found()) continue;
    if (outcome.found() && attempt.inliers <= outcome.inliers) continue;
    reference = id;
    outcome = attempt;
  }
  return {};
}

}  // namespace roomwise::mapping
