#include "roomwise/mapping/mapper.h"

#include <algorithm>
#include <utility>

namespace roomwise::mapping {
namespace {

using geometry::RigidTransform;

// How far a hand-held camera's motion is from one of constant velocity.
constexpr double kTranslationSigma_m = 0.02;
constexpr double kTranslationSigma_m_s = 0.4;
constexpr double kRotationSigma_rad = 0.05;
constexpr double kRotationSigma_rad_s = 0.5;
constexpr double kMostExtrapolation = 3;
// How far a few steps between key-frames may have drifted.
constexpr double kStepsSigma_m = 0.03;
constexpr double kStepsSigma_rad = 0.03;
// Key-frames younger than these are neighbours on the walk, not similar places.
constexpr KeyframeId kNeighbors = 5;

// The motion of `ratio` times as long.
RigidTransform scaled(const RigidTransform& motion, double ratio) {
  const Eigen::AngleAxisd turn(motion.rotation);
  return {Eigen::Quaterniond(Eigen::AngleAxisd(ratio * turn.angle(), turn.axis())),
          ratio * motion.translation};
}

}  // namespace

MapperOptions MapperOptions::of(MappingMethod method) {
  MapperOptions options;
  options.method = method;
  if (method == MappingMethod::kPaper) {
    options.loops.random = 5;
    options.loops.similar = 0;
  }
  return options;
}

Expected<void> MapperOptions::validate() const {
  ROOMWISE_CHECK_OK(locator.validate());
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

Expected<MappingMethod> parse_mapping_method(std::string_view name) {
  for (const MappingMethod method : {MappingMethod::kPaper, MappingMethod::kCombined}) {
    if (name == to_string(method)) return method;
  }
  return fail("'{}' is not a mapping method; there are combined and paper", name);
}

std::string_view to_string(MappingMethod method) {
  return method == MappingMethod::kPaper ? "paper" : "combined";
}

Mapper::Mapper(const geometry::PinholeCamera& camera, const MapperOptions& options)
    : camera_(camera), options_(options), index_(options.seed) {}

void Mapper::restore(std::vector<Keyframe> keyframes, std::vector<PoseGraphEdge> edges,
                     std::vector<MappedFrame> frames) {
  keyframes_ = std::move(keyframes);
  edges_ = std::move(edges);
  frames_ = std::move(frames);
  previous_.reset();
  frames_lost_ = 0;
  index_ = AppearanceIndex(options_.seed);
  if (options_.loops.similar > 0) {
    for (const Keyframe& keyframe : keyframes_)
      index_.add(keyframe.id, keyframe.measurements.features().features);
  }
}

MapStep Mapper::add_frame(std::uint64_t frame_index, TimestampNs timestamp_ns,
                          motion::FrameMeasurements measurements) {
  MapStep step;
  const std::size_t position = frames_.size();
  frames_.push_back({frame_index, timestamp_ns, std::nullopt, {}});
  if (keyframes_.empty()) {
    if (!can_begin(measurements)) {
      frames_[position].why_unplaced = to_string(motion::MotionStatus::kTooFewFeatures);
      return step;
    }
    begin_piece(position, std::move(measurements), step);
    return step;
  }

  motion::MotionOutcome outcome = track(position, measurements);
  if (!outcome.found() && previous_) {
    // The frame before still matched: as a key-frame it bridges the gap.
    PreviousFrame bridge = std::move(*previous_);
    previous_.reset();
    add_keyframe(bridge.position, std::move(bridge.measurements), bridge.edge, step);
    outcome = track(position, measurements);
  }
  KeyframeId reference = keyframes_.back().id;
  if (!outcome.found()) recognize(frame_index, measurements, reference, outcome);
  if (!outcome.found()) {
    previous_.reset();
    frames_[position].why_unplaced = outcome.describe();
    if (++frames_lost_ >= options_.frames_until_new_piece && can_begin(measurements)) {
      begin_piece(position, std::move(measurements), step);
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
    add_keyframe(position, std::move(measurements), edge, step);
  } else {
    previous_ = PreviousFrame{position, std::move(measurements), edge};
  }
  return step;
}

bool Mapper::can_begin(const motion::FrameMeasurements& measurements) const {
  return static_cast<int>(measurements.features().size()) >=
         options_.locator.features.least_features;
}

std::optional<RigidTransform> Mapper::from_last_keyframe(const MappedFrame& frame) const {
  if (!frame.place) return std::nullopt;
  const KeyframeId last = keyframes_.back().id;
  if (frame.place->keyframe == last) return frame.place->keyframe_from_camera;
  for (auto edge = edges_.rbegin(); edge != edges_.rend() && edge->to == last; ++edge) {
    if (edge->from == frame.place->keyframe)
      return edge->from_from_to.inverse() * frame.place->keyframe_from_camera;
  }
  return std::nullopt;
}

std::optional<motion::PosePrior> Mapper::foresee(std::size_t position) const {
  // The last placed frame: the one before or, at most, the one before that.
  std::size_t last = position;
  if (last > 1 && !frames_[last - 1].place) --last;
  if (!frames_[last - 1].place) return std::nullopt;
  const MappedFrame& newer = frames_[last - 1];
  const auto pose = from_last_keyframe(newer);
  if (!pose) return std::nullopt;
  const auto seconds = [](TimestampNs from, TimestampNs to) {
    return static_cast<double>(to - from) * kSecondsPerNs;
  };
  const double ahead_s = seconds(newer.timestamp_ns, frames_[position].timestamp_ns);
  // How far a person's movement can differ from what is foreseen.
  double translation_m = kTranslationSigma_m + kTranslationSigma_m_s * ahead_s;
  double rotation_rad = kRotationSigma_rad + kRotationSigma_rad_s * ahead_s;
  if (last >= 2) {
    const MappedFrame& older = frames_[last - 2];
    const double behind_s = seconds(older.timestamp_ns, newer.timestamp_ns);
    const auto before = from_last_keyframe(older);
    if (before && behind_s > 0) {
      const RigidTransform step = before->inverse() * *pose;
      const double ratio = std::min(ahead_s / behind_s, kMostExtrapolation);
      motion::PosePrior prior =
          motion::PosePrior::around(*pose * scaled(step, ratio), translation_m, rotation_rad);
      prior.other_start = *pose;
      return prior;
    }
  }
  return motion::PosePrior::around(*pose, 2 * translation_m, 2 * rotation_rad);
}

motion::MotionOutcome Mapper::track(std::size_t position,
                                    const motion::FrameMeasurements& current) const {
  const Keyframe& reference = keyframes_.back();
  const RandomStream random(options_.seed, {frames_[position].frame_index, reference.id});
  if (options_.method == MappingMethod::kPaper) {
    return motion::estimate_motion(reference.measurements.features(), current.features(), camera_,
                                   options_.locator.features, random);
  }
  return motion::locate_frame(reference.measurements, current, foresee(position), camera_,
                              options_.locator, random);
}

std::optional<RigidTransform> Mapper::along_steps(KeyframeId from) const {
  RigidTransform from_last;
  KeyframeId at = keyframes_.back().id;
  for (auto edge = edges_.rbegin(); edge != edges_.rend() && at != from; ++edge) {
    if (edge->to < at) return std::nullopt;  // a piece begins there
    if (edge->is_loop || edge->to != at) continue;
    if (edge->from + 1 != at) return std::nullopt;
    from_last = edge->from_from_to * from_last;
    at = edge->from;
  }
  if (at != from) return std::nullopt;
  return from_last;
}

std::vector<KeyframeId> Mapper::similar_keyframes(const motion::FrameMeasurements& measurements,
                                                  KeyframeId before) const {
  std::vector<KeyframeId> similar;
  if (options_.loops.similar == 0) return similar;
  for (const AppearanceIndex::Hit& hit :
       index_.find(measurements.features().features, before,
                   static_cast<std::size_t>(options_.loops.similar))) {
    similar.push_back(hit.id);
  }
  return similar;
}

motion::MotionOutcome Mapper::compare(const Keyframe& reference,
                                      const motion::FrameMeasurements& current,
                                      std::uint64_t frame_index) const {
  // A loop must be surer than a step of the odometry.
  motion::LocatorOptions strict = options_.locator;
  strict.rests_on_prior = false;
  motion::MotionOptions& features = strict.features;
  features.least_inliers = std::max(features.least_inliers, options_.loops.least_inliers);
  features.least_matches = std::max(features.least_matches, options_.loops.least_inliers);
  features.least_inlier_ratio =
      std::max(features.least_inlier_ratio, options_.loops.least_inlier_ratio);
  const RandomStream random(options_.seed, {frame_index, reference.id});
  if (options_.method == MappingMethod::kPaper) {
    return motion::estimate_motion(reference.measurements.features(), current.features(), camera_,
                                   features, random);
  }
  // Where the steps between two neighbours are known, so is nearly where they are.
  std::optional<motion::PosePrior> prior;
  if (frame_index == keyframes_.back().frame_index &&
      reference.id + kNeighbors > keyframes_.back().id) {
    if (const auto steps = along_steps(reference.id)) {
      prior = motion::PosePrior::around(*steps, kStepsSigma_m, kStepsSigma_rad);
      const double overlap =
          motion::compare_views(reference.measurements.view(), current.view(), *steps).overlap;
      if (overlap < strict.views.least_overlap) {
        motion::MotionOutcome nothing;
        nothing.status = motion::MotionStatus::kNothingInCommon;
        return nothing;
      }
    }
  }
  return motion::locate_frame(reference.measurements, current, prior, camera_, strict, random);
}

void Mapper::recognize(std::uint64_t frame_index, const motion::FrameMeasurements& current,
                       KeyframeId& reference, motion::MotionOutcome& outcome) const {
  // Being lost, any key-frame may be the one: the candidates of a loop closure, as if this frame
  // were a key-frame.
  const LoopCandidates candidates = draw_loop_candidates(
      keyframes_.size() + 1, options_.loops, RandomStream(options_.seed, {frame_index, ~1ULL}));
  std::vector<KeyframeId> ids = candidates.neighbors;
  const std::vector<KeyframeId> similar = similar_keyframes(current, keyframes_.size());
  ids.insert(ids.end(), similar.begin(), similar.end());
  ids.insert(ids.end(), candidates.random.begin(), candidates.random.end());
  for (const KeyframeId id : ids) {
    const motion::MotionOutcome attempt = compare(keyframes_[id], current, frame_index);
    if (!attempt.found()) continue;
    if (outcome.found() && attempt.inliers <= outcome.inliers) continue;
    reference = id;
    outcome = attempt;
  }
}

void Mapper::begin_piece(std::size_t frame_position, motion::FrameMeasurements measurements,
                         MapStep& step) {
  frames_lost_ = 0;
  add_keyframe(frame_position, std::move(measurements), std::nullopt, step);
}

void Mapper::add_keyframe(std::size_t frame_position, motion::FrameMeasurements measurements,
                          const std::optional<PoseGraphEdge>& link, MapStep& step) {
  MappedFrame& frame = frames_[frame_position];
  const KeyframeId id = keyframes_.size();
  keyframes_.push_back({id, frame.frame_index, frame.timestamp_ns, std::move(measurements)});
  frame.place = FramePlace{id, geometry::RigidTransform::identity()};
  frame.why_unplaced.clear();
  if (link) edges_.push_back(*link);
  // Found now at the latest: a key-frame does not hold on to its images.
  const features::Features& features = keyframes_.back().measurements.features().features;
  const auto compare_frames =
      [this](const Keyframe& reference, const motion::FrameMeasurements& current,
             std::uint64_t frame_index) { return compare(reference, current, frame_index); };
  const std::vector<KeyframeId> similar =
      similar_keyframes(keyframes_.back().measurements, id - std::min(id, kNeighbors));
  for (const PoseGraphEdge& loop :
       close_loops(keyframes_, options_.loops, similar, compare_frames, options_.seed)) {
    if (!link || loop.from != link->from) edges_.push_back(loop);
  }
  if (options_.loops.similar > 0) index_.add(id, features);
  step.new_keyframes.push_back(id);
}

}  // namespace roomwise::mapping
