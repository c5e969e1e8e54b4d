#include "roomwise/mapping/mapper.h"

#include <utility>

namespace roomwise::mapping {

Expected<void> MapperOptions::validate() const {
  ROOMWISE_CHECK_OK(motion.validate());
  ROOMWISE_CHECK_OK(loops.validate());
  if (!(keyframe_translation_m > 0) || !(keyframe_rotation_rad > 0)) {
    return fail("keyframe_translation_m = {} and keyframe_rotation_rad = {} must be positive",
                keyframe_translation_m, keyframe_rotation_rad);
  }
  if (frames_until_new_piece < 1) {
    return fail("frames_until_new_piece = {} must be at least 1", frames_until_new_piece);
  }
  return {};
}

Mapper::Mapper(const geometry::PinholeCamera& camera, const MapperOptions& options)
    : camera_(camera), options_(options) {}

void Mapper::restore(std::vector<Keyframe> keyframes, std::vector<PoseGraphEdge> edges,
                     std::vector<MappedFrame> frames) {
  keyframes_ = std::move(keyframes);
  edges_ = std::move(edges);
  frames_ = std::move(frames);
  previous_.reset();
  frames_lost_ = 0;
}

MapStep Mapper::add_frame(std::uint64_t frame_index, TimestampNs timestamp_ns,
                          motion::MeasuredFeatures features) {
  MapStep step;
  const std::size_t position = frames_.size();
  frames_.push_back({frame_index, timestamp_ns, std::nullopt, {}});
  if (keyframes_.empty()) {
    if (static_cast<int>(features.size()) < options_.motion.least_features) {
      frames_[position].why_unplaced = to_string(motion::MotionStatus::kTooFewFeatures);
      return step;
    }
    begin_piece(position, std::move(features), step);
    return step;
  }

  motion::MotionOutcome outcome = locate(keyframes_.back(), frame_index, features);
  if (!outcome.found() && previous_) {
    // The frame before still matched: as a key-frame it bridges the gap.
    PreviousFrame bridge = std::move(*previous_);
    previous_.reset();
    add_keyframe(bridge.position, std::move(bridge.features), bridge.edge, step);
    outcome = locate(keyframes_.back(), frame_index, features);
  }
  KeyframeId reference = keyframes_.back().id;
  if (!outcome.found()) recognize(frame_index, features, reference, outcome);
  if (!outcome.found()) {
    previous_.reset();
    frames_[position].why_unplaced = outcome.describe();
    const bool could_begin = static_cast<int>(features.size()) >= options_.motion.least_features;
    if (++frames_lost_ >= options_.frames_until_new_piece && could_begin) {
      begin_piece(position, std::move(features), step);
    }
    return step;
  }

  frames_lost_ = 0;
  // Recognised from an older key-frame: that may be wrong, as any loop may.
  const bool is_recognized = reference != keyframes_.back().id;
  const geometry::RigidTransform& motion = outcome.pose.reference_from_current;
  const PoseGraphEdge edge =
      edge_from_motion(reference, keyframes_.size(), outcome.pose, is_recognized);
  frames_[position].place = FramePlace{reference, motion};
  const bool is_substantial = motion.distance_m() >= options_.keyframe_translation_m ||
                              motion.angle_rad() >= options_.keyframe_rotation_rad;
  // A recognised frame becomes a key-frame itself: the next frame is located against it.
  if (is_substantial || is_recognized) {
    previous_.reset();
    add_keyframe(position, std::move(features), edge, step);
  } else {
    previous_ = PreviousFrame{position, std::move(features), edge};
  }
  return step;
}

motion::MotionOutcome Mapper::locate(const Keyframe& reference, std::uint64_t frame_index,
                                     const motion::MeasuredFeatures& features) const {
  return motion::estimate_motion(reference.features, features, camera_, options_.motion,
                                 RandomStream(options_.seed, {frame_index, reference.id}));
}

void Mapper::recognize(std::uint64_t frame_index, const motion::MeasuredFeatures& features,
                       KeyframeId& reference, motion::MotionOutcome& outcome) const {
  // Being lost, any key-frame may be the one: the candidates of a loop closure, as if this frame
  // were a key-frame.
  const LoopCandidates candidates = draw_loop_candidates(
      keyframes_.size() + 1, options_.loops, RandomStream(options_.seed, {frame_index, ~1ULL}));
  std::vector<KeyframeId> ids = candidates.neighbors;
  ids.insert(ids.end(), candidates.random.begin(), candidates.random.end());
  for (const KeyframeId id : ids) {
    const motion::MotionOutcome attempt = locate(keyframes_[id], frame_index, features);
    if (!attempt.found() || attempt.inliers < options_.loops.least_inliers ||
        attempt.inliers < options_.loops.least_inlier_ratio * attempt.matches) {
      continue;
    }
    if (outcome.found() && attempt.inliers <= outcome.inliers) continue;
    reference = id;
    outcome = attempt;
  }
}

void Mapper::begin_piece(std::size_t frame_position, motion::MeasuredFeatures features,
                         MapStep& step) {
  frames_lost_ = 0;
  add_keyframe(frame_position, std::move(features), std::nullopt, step);
}

void Mapper::add_keyframe(std::size_t frame_position, motion::MeasuredFeatures features,
                          const std::optional<PoseGraphEdge>& link, MapStep& step) {
  MappedFrame& frame = frames_[frame_position];
  const KeyframeId id = keyframes_.size();
  keyframes_.push_back({id, frame.frame_index, frame.timestamp_ns, std::move(features)});
  frame.place = FramePlace{id, geometry::RigidTransform::identity()};
  frame.why_unplaced.clear();
  if (link) edges_.push_back(*link);
  for (const PoseGraphEdge& loop :
       close_loops(keyframes_, camera_, options_.motion, options_.loops, options_.seed)) {
    if (!link || loop.from != link->from) edges_.push_back(loop);
  }
  step.new_keyframes.push_back(id);
}

}  // namespace roomwise::mapping
