#include "roomwise/mapping/frontend/mapper.h"

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

namespace roomwise::mapping {
namespace {

using geometry::RigidTransform;

// How far a few steps between key-frames may have drifted.
constexpr double kStepsSigma_m = 0.03;
constexpr double kStepsSigma_rad = 0.03;
// Key-frames younger than these are neighbours on the walk, not similar places.
constexpr KeyframeId kNeighbors = 5;
// By how much of a key-frame's motion the way along edges to a known place may be wrong, and how
// many places are tried.
constexpr double kGraphPathSlackRatio = 0.2;
constexpr int kMaxKnownTried = 2;
// A component of the map makes new key-frames also on known ground until it has so many: only new
// ones find the loops that join it with the others.
constexpr std::size_t kMinComponentForReuse = 100;
// Nothing is gone on from before the map has so many key-frames, in ReuseOptions::min_age: while
// it is small, each new one costs little and makes it more exact, on known ground too.
constexpr std::size_t kLargeMap_min_ages = 15;
// So often a run can be taken up again, also where nothing happens.
constexpr int kMaxFramesToCheckpoint = 300;
// Motion is predicted from frames as far back as this.
constexpr std::size_t kMinFramesKept = 4;

// Whether edges lead from the key-frame to so many, itself included.
bool component_has_at_least(const KeyframeGraph& graph, KeyframeId keyframe, std::size_t count) {
  std::vector<KeyframeId> open{keyframe};
  std::set<KeyframeId> reached{keyframe};
  while (!open.empty() && reached.size() < count) {
    const KeyframeId from = open.back();
    open.pop_back();
    for (const KeyframeGraph::Nearby& nearby : graph.around(from)) {
      if (reached.insert(nearby.id).second) open.push_back(nearby.id);
    }
  }
  return reached.size() >= count;
}

}  // namespace

Mapper::Mapper(const geometry::PinholeCamera& camera, const MapperOptions& options,
               WorkingSet working_set)
    : camera_(camera), options_(options), store_(std::move(working_set)), index_(kIndexSeed) {}

Expected<void> Mapper::restore_keyframe(Keyframe keyframe) {
  if (options_.loops.similar > 0)
    index_.add(keyframe.id, keyframe.measurements.features().features);
  keyframes_.push_back(keyframe);
  return store_.add(std::move(keyframe.measurements));
}

void Mapper::restore_stored(std::vector<KeyframeStamp> keyframes, AppearanceIndex index,
                            MeasureStored measure) {
  store_.add_stored(keyframes.size(), std::move(measure));
  keyframes_ = std::move(keyframes);
  if (options_.loops.similar > 0) index_ = std::move(index);
}

void Mapper::restore(std::span<const PoseGraphEdge> edges, std::span<const Frame> frames,
                     KeyframeId first_keyframe) {
  first_keyframe_ = first_keyframe;
  for (const PoseGraphEdge& edge : edges) graph_.add(edge);
  for (const Frame& frame : frames) {
    if (frame.place) set_reference(frame.place->keyframe);
    frames_lost_ = frame.place ? 0 : frames_lost_ + 1;
    frames_.push_back(frame);
    if (!gyroscope_) mark_ = device_.mark(frame);
    if (mark_ && is_keyframe(frame))
      marked_keyframe_ = MarkedKeyframe{frame.place->keyframe, *mark_};
    take_device_motion(frame);
  }
}

void Mapper::release_frames(std::size_t keep) {
  while (frames_.size() > std::max(keep, kMinFramesKept)) {
    frames_.pop_front();
    ++released_;
  }
}

Expected<MapUpdate> Mapper::add_frame(std::uint64_t frame_index, TimestampNs timestamp_ns,
                                      motion::FrameMeasurements measurements,
                                      const std::optional<geometry::DeviceMotion>& device) {
  Frame& frame = frames_.emplace_back(Frame{frame_index, timestamp_ns, std::nullopt, {}});
  if (gyroscope_) {
    frame.motion = felt_motion(timestamp_ns);
  } else {
    if (device && options_.takes_device_motion()) frame.motion = scene::FrameMotion{*device};
    mark_ = device_.mark(frame);
    if (device_.jumps_to(frame)) drop_device_motion();
  }
  ROOMWISE_TRY(MapUpdate step, place_newest(std::move(measurements)));
  take_device_motion(frames_.back());
  return step;
}

Expected<MapUpdate> Mapper::place_newest(motion::FrameMeasurements measurements) {
  MapUpdate step;
  const std::size_t position = frames_.size() - 1;
  if (keyframes_.size() == first_keyframe_) {
    if (!can_start_component(measurements)) {
      frames_[position].no_pose_reason = to_string(motion::MotionStatus::kTooFewFeatures);
      return step;
    }
    ROOMWISE_RETURN_IF_ERROR(add_keyframe(position, std::move(measurements), std::nullopt, step));
    return step;
  }
  const bool is_checkpoint_due = ++frames_since_checkpoint_ >= kMaxFramesToCheckpoint;

  ROOMWISE_TRY(motion::MotionOutcome outcome, track(measurements));
  if (!outcome.found() && previous_) {
    // The frame before still matched: as a key-frame it bridges the gap.
    PreviousFrame bridge = *std::exchange(previous_, std::nullopt);
    ROOMWISE_RETURN_IF_ERROR(
        add_keyframe(position - 1, std::move(bridge.measurements), bridge.edge, step));
    ROOMWISE_TRY(outcome, track(measurements));
  }
  KeyframeId reference = reference_history_.back();
  if (!outcome.found()) ROOMWISE_RETURN_IF_ERROR(relocalize(measurements, reference, outcome));
  if (const auto by_device = outcome.found() ? std::nullopt : dead_reckoned_pose()) {
    ROOMWISE_RETURN_IF_ERROR(place_by_dead_reckoning(*by_device, std::move(measurements), step));
    if (is_checkpoint_due && !step.is_checkpoint) reach_checkpoint(step);
    return step;
  }
  if (!outcome.found()) {
    previous_.reset();
    frames_[position].no_pose_reason = outcome.describe();
    if (++frames_lost_ >= options_.frames_until_new_component &&
        can_start_component(measurements)) {
      ROOMWISE_RETURN_IF_ERROR(add_keyframe(position, std::move(measurements), std::nullopt, step));
    } else if (is_checkpoint_due) {
      reach_checkpoint(step);
    }
    return step;
  }

  frames_lost_ = 0;
  // Recognised from an older key-frame: that may be wrong, as any loop may.
  const bool is_relocalized = reference != reference_history_.back();
  const RigidTransform& motion = outcome.pose.reference_from_current;
  const PoseGraphEdge edge =
      edge_from_motion(reference, keyframes_.size(), outcome.pose, is_relocalized);
  frames_[position].place = FramePlace{reference, motion};
  // A recognised frame becomes a key-frame itself: the next frame is located against it.
  if (!is_relocalized && !needs_keyframe(motion)) {
    previous_ = PreviousFrame{std::move(measurements), edge};
    if (is_checkpoint_due) reach_checkpoint(step);
    return step;
  }
  previous_.reset();
  if (!is_relocalized) {
    ROOMWISE_TRY(const std::optional<RevisitedKeyframe> known,
                 find_revisited(measurements, motion));
    if (known) {
      reuse_keyframe(*known, outcome.pose);
      reach_checkpoint(step);
      return step;
    }
  }
  ROOMWISE_RETURN_IF_ERROR(add_keyframe(position, std::move(measurements), edge, step));
  return step;
}

bool Mapper::can_start_component(const motion::FrameMeasurements& measurements) const {
  return static_cast<int>(measurements.features().size()) >= options_.locator.features.min_features;
}

double Mapper::motion_ratio(const RigidTransform& motion) const {
  return std::max(motion.distance_m() / options_.keyframe_translation_m,
                  motion.angle_rad() / options_.keyframe_rotation_rad);
}

bool Mapper::needs_keyframe(const RigidTransform& motion) const {
  return motion.distance_m() >= options_.keyframe_translation_m ||
         motion.angle_rad() >= options_.keyframe_rotation_rad;
}

void Mapper::set_reference(KeyframeId id) {
  if (!reference_history_.empty() && reference_history_.back() == id) return;
  reference_history_.push_back(id);
  const std::size_t needed =
      2 + std::max<std::size_t>(static_cast<std::size_t>(options_.loops.neighbors), kNeighbors);
  if (reference_history_.size() > needed) reference_history_.pop_front();
}

void Mapper::reach_checkpoint(MapUpdate& step) {
  previous_.reset();
  frames_since_checkpoint_ = 0;
  step.is_checkpoint = true;
}

std::optional<StampedMotion> Mapper::pose_in_reference(const Frame& frame) const {
  if (!frame.place) return std::nullopt;
  const auto pose = pose_in_reference(*frame.place);
  if (!pose) return std::nullopt;
  return StampedMotion{*pose, frame.timestamp_ns};
}

std::optional<RigidTransform> Mapper::pose_in_reference(const FramePlace& place) const {
  if (place.keyframe == reference_history_.back()) return place.keyframe_from_camera;
  const auto way = graph_.between(reference_history_.back(), place.keyframe);
  if (!way) return std::nullopt;
  return *way * place.keyframe_from_camera;
}

std::optional<motion::PosePrior> Mapper::predict_pose() const {
  // The last placed frame: the one before or, at most, the one before that.
  const std::size_t position = frames_.size() - 1;
  std::size_t last = position;
  if (last > 1 && !frames_[last - 1].place) --last;
  const auto newer = pose_in_reference(frames_[last - 1]);
  if (!newer) return std::nullopt;
  const auto older = last >= 2 ? pose_in_reference(frames_[last - 2]) : std::nullopt;
  return predict_motion(older, *newer, frames_[position].timestamp_ns);
}

Mapper::Outcome Mapper::track(const motion::FrameMeasurements& current) {
  const KeyframeId reference = reference_history_.back();
  ROOMWISE_TRY(const SharedMeasurements measured, store_.get(reference));
  const RandomStream random(options_.seed, {frames_.back().index, reference});
  if (options_.method == MappingMethod::kPaper) {
    return motion::estimate_motion(measured->features(), current.features(), camera_,
                                   options_.locator.features, random);
  }
  if (const auto turned = predict_turned_pose())
    return track_by_turn(*measured, current, *turned, random);
  const auto by_device = device_pose_in_reference();
  // What pictures said while the device was silent is newer than what it knows.
  const bool is_outdated =
      by_device && frames_[frames_.size() - 2].place && !frames_[frames_.size() - 2].motion;
  if (by_device && !is_outdated) return track_by_device(*measured, current, *by_device, random);
  return track_by_walk(*measured, current, random);
}

std::vector<KeyframeId> Mapper::recent_references(std::size_t skip_newest) const {
  // The same key-frame may have been the reference several times.
  std::vector<KeyframeId> distinct;
  const std::size_t most = skip_newest + static_cast<std::size_t>(options_.loops.neighbors);
  for (auto id = reference_history_.rbegin();
       id != reference_history_.rend() && distinct.size() < most; ++id) {
    if (std::ranges::find(distinct, *id) == distinct.end()) distinct.push_back(*id);
  }
  distinct.erase(distinct.begin(), distinct.begin() + static_cast<std::ptrdiff_t>(
                                                          std::min(skip_newest, distinct.size())));
  return distinct;
}

std::optional<RigidTransform> Mapper::chain_odometry(KeyframeId from) const {
  RigidTransform from_newest;
  for (std::size_t back = 1; back < std::min<std::size_t>(reference_history_.size(), kNeighbors);
       ++back) {
    const KeyframeId at = reference_history_[reference_history_.size() - 1 - back];
    const auto step = graph_.between(at, reference_history_[reference_history_.size() - back]);
    if (!step) return std::nullopt;  // a component begins there
    from_newest = *step * from_newest;
    if (at == from) return from_newest;
  }
  return std::nullopt;
}

Expected<std::optional<Mapper::RevisitedKeyframe>> Mapper::find_revisited(
    const motion::FrameMeasurements& current, const RigidTransform& motion) {
  if (options_.reuse.max_motion_ratio == 0) return std::nullopt;
  const auto min_age = static_cast<std::size_t>(options_.reuse.min_age);
  const std::size_t of_walk = keyframes_.size() - first_keyframe_;
  if (of_walk < kLargeMap_min_ages * min_age) return std::nullopt;
  if (!component_has_at_least(graph_, reference_history_.back(),
                              std::min(of_walk, kMinComponentForReuse)))
    return std::nullopt;
  struct Candidate {
    KeyframeId id = 0;
    RigidTransform keyframe_from_camera;
    double motion_ratio = 0;
  };
  std::vector<Candidate> candidates;
  for (const KeyframeGraph::Nearby& nearby : graph_.around(reference_history_.back())) {
    if (nearby.id < first_keyframe_) continue;
    const RigidTransform pose = nearby.keyframe_from_nearby.inverse() * motion;
    const double far = motion_ratio(pose);
    if (far < options_.reuse.max_motion_ratio + kGraphPathSlackRatio)
      candidates.push_back({nearby.id, pose, far});
  }
  std::ranges::stable_sort(candidates, {}, &Candidate::motion_ratio);
  if (candidates.size() > kMaxKnownTried) candidates.resize(kMaxKnownTried);
  for (const Candidate& candidate : candidates) {
    const auto prior =
        motion::PosePrior::around(candidate.keyframe_from_camera, kStepsSigma_m, kStepsSigma_rad);
    ROOMWISE_TRY(const motion::MotionOutcome outcome,
                 compare(candidate.id, current, frames_.back().index, prior));
    // Without features there were no matches to look at.
    const bool used_whole_views = outcome.matches == 0;
    const bool is_old = candidate.id + min_age < keyframes_.size();
    if (!outcome.found() || !(used_whole_views || is_old)) continue;
    if (motion_ratio(outcome.pose.reference_from_current) >= options_.reuse.max_motion_ratio)
      continue;
    return RevisitedKeyframe{candidate.id, outcome.pose};
  }
  return std::nullopt;
}

void Mapper::reuse_keyframe(const RevisitedKeyframe& known,
                            const motion::RefinedPose& in_reference) {
  const KeyframeId reference = reference_history_.back();
  if (!graph_.between(reference, known.keyframe)) {
    const bool goes_back = known.keyframe < reference;
    graph_.add(goes_back ? edge_through_frame(known.keyframe, known.pose, reference, in_reference)
                         : edge_through_frame(reference, in_reference, known.keyframe, known.pose));
  }
  set_reference(known.keyframe);
  frames_.back().place = FramePlace{known.keyframe, known.pose.reference_from_current};
}

Expected<void> Mapper::add_keyframe(std::size_t frame_position,
                                    motion::FrameMeasurements measurements,
                                    const std::optional<PoseGraphEdge>& link, MapUpdate& step) {
  Frame& frame = frames_[frame_position];
  const KeyframeStamp newest{keyframes_.size(), frame.index, frame.timestamp_ns};
  frames_lost_ = 0;
  frame.place = FramePlace{newest.id, RigidTransform::identity()};
  frame.no_pose_reason.clear();
  keyframes_.push_back(newest);
  // Finds its features now at the latest: a key-frame does not hold on to its images.
  ROOMWISE_RETURN_IF_ERROR(store_.add(std::move(measurements)));
  ROOMWISE_TRY(const SharedMeasurements measured, store_.get(newest.id));
  set_reference(newest.id);
  if (link) graph_.add(*link);
  const bool is_newest_frame = frame_position + 1 == frames_.size();
  add_device_edge(newest.id, is_newest_frame, link && link->is_device_motion);
  const auto compare_newest = [&](KeyframeId reference) {
    // A prior from the odometry that leads from one to the other, where it is known throughout.
    std::optional<motion::PosePrior> prior;
    if (const auto steps = chain_odometry(reference))
      prior = motion::PosePrior::around(*steps, kStepsSigma_m, kStepsSigma_rad);
    return compare(reference, *measured, newest.frame_index, prior);
  };
  const std::vector<KeyframeId> similar =
      similar_keyframes(*measured, newest.id - std::min(newest.id, kNeighbors));
  ROOMWISE_TRY(const std::vector<PoseGraphEdge> loops,
               close_loops(newest, options_.loops, recent_references(2), similar, compare_newest,
                           options_.seed));
  for (const PoseGraphEdge& loop : loops) {
    if (!link || link->is_device_motion || loop.from != link->from) graph_.add(loop);
  }
  if (options_.loops.similar > 0) index_.add(newest.id, measured->features().features);
  step.new_keyframes.push_back(newest.id);
  step.is_checkpoint = is_newest_frame;
  frames_since_checkpoint_ = static_cast<int>(frames_.size() - 1 - frame_position);
  return {};
}

}  // namespace roomwise::mapping
