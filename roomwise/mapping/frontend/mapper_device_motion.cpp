// The part of Mapper that takes the device's own motion for a prior.

#include <algorithm>
#include <cmath>
#include <numeric>

#include "roomwise/mapping/frontend/mapper.h"

namespace roomwise::mapping {
namespace {

using scene::MotionUse;

// e^T Omega e with six degrees of freedom is above this once in ten thousand times.
constexpr double kContradiction = 28;
constexpr double kTurnContradiction = 21;  // the same with three
// What pictures err by although they are sure: rolling shutter, depth.
constexpr double kPicturesSigma_m = 0.01;
constexpr double kPicturesSigma_rad = 0.01;

// So long somebody is believed to walk on as he did: 0.4 m off is all that a place may be.
constexpr double kLongestByTurn_s = 1;

// What the place of the anchor errs by itself.
constexpr double kAnchorSigma_m = 0.004;
constexpr double kAnchorSigma_rad = 0.003;

bool contradicts(const motion::MotionOutcome& outcome, const motion::PosePrior& prior) {
  motion::PosePrior both = prior;
  both.information =
      motion::with_systematic_error(prior.information, kPicturesSigma_m, 0.5 * kPicturesSigma_rad);
  return motion::squared_mahalanobis(outcome.pose.reference_from_current, both) > kContradiction;
}

bool contradicts_turn(const motion::MotionOutcome& outcome, const motion::PosePrior& prior) {
  motion::PosePrior turn = prior;
  turn.information =
      motion::with_systematic_error(prior.information, kPicturesSigma_m, 0.5 * kPicturesSigma_rad);
  turn.information.topRows<3>().setZero();
  turn.information.leftCols<3>().setZero();
  return motion::squared_mahalanobis(outcome.pose.reference_from_current, turn) >
         kTurnContradiction;
}

// What a device says alone, where the walk would go on elsewhere: that is how unsure it is, since
// it may have jumped and no picture tells.
geometry::Matrix6d doubted(const geometry::Matrix6d& information,
                           const std::optional<motion::PosePrior>& by_device,
                           const std::optional<motion::PosePrior>& by_walk) {
  constexpr double kUsual = 6;  // e^T Omega e, with six degrees of freedom
  if (!by_device || !by_walk ||
      motion::squared_mahalanobis(by_device->reference_from_current, *by_walk) < kUsual) {
    return information;
  }
  const geometry::RigidTransform apart =
      by_walk->reference_from_current.inverse() * by_device->reference_from_current;
  return motion::with_systematic_error(information, apart.distance_m(), 0.5 * apart.angle_rad());
}

// Whether pictures placed it.
bool is_seen(const scene::Frame& frame) {
  return frame.place && !(frame.motion && frame.motion->use == MotionUse::kAlone);
}

bool is_seen(const motion::MotionOutcome& outcome) {
  return outcome.found() && !outcome.rests_on_prior;
}

}  // namespace

bool Mapper::is_keyframe(const Frame& frame) const {
  return frame.place && keyframes_[frame.place->keyframe].frame_index == frame.index;
}

void Mapper::feel(geometry::InertialTrack track) {
  if (options_.takes_device_motion()) gyroscope_.emplace(std::move(track));
}

std::optional<scene::FrameMotion> Mapper::felt_motion(TimestampNs timestamp_ns) const {
  const auto rotation = gyroscope_->track().world_from_camera(timestamp_ns);
  if (!rotation) return std::nullopt;
  return scene::FrameMotion{
      {{*rotation, Eigen::Vector3d::Zero()}, gyroscope_->track().up_camera(timestamp_ns)}};
}

void Mapper::learn_bias() {
  // The two frames before stay as they are: who goes on later learns the same.
  if (frames_.size() < 3) return;
  const Frame& from = frames_[frames_.size() - 3];
  const Frame& to = frames_[frames_.size() - 2];
  const auto tells = [](const Frame& frame) {
    return is_seen(frame) && frame.motion && frame.motion->use == MotionUse::kTaken;
  };
  if (!tells(from) || !tells(to)) return;
  if (const auto shown = step(from, to))
    gyroscope_->learn(from.timestamp_ns, to.timestamp_ns, shown->rotation);
}

void Mapper::follow_seen() {
  const Frame& newest = frames_.back();
  if (is_seen(newest)) {
    seen_ = SeenCamera{newest.timestamp_ns, geometry::RigidTransform::identity()};
    return;
  }
  const auto back = frames_.size() > 1 ? step(newest, frames_[frames_.size() - 2]) : std::nullopt;
  if (!back) seen_.reset();
  if (seen_) seen_->newest_from_seen = *back * seen_->newest_from_seen;
}

std::optional<geometry::RigidTransform> Mapper::step(const Frame& from, const Frame& to) const {
  if (!from.place || !to.place) return std::nullopt;
  const geometry::RigidTransform camera_from_keyframe = from.place->keyframe_from_camera.inverse();
  const KeyframeId start = from.place->keyframe, end = to.place->keyframe;
  if (start == end) return camera_from_keyframe * to.place->keyframe_from_camera;
  // Edges that were found later are not there yet for who maps without a break.
  if (graph_.tracked_from(end) != start && graph_.tracked_from(start) != end) return std::nullopt;
  return camera_from_keyframe * *graph_.between(start, end) * to.place->keyframe_from_camera;
}

std::optional<motion::PosePrior> Mapper::predict_turned_pose() const {
  if (!gyroscope_ || !seen_ || frames_.size() < 2 || !frames_.back().motion) return std::nullopt;
  const TimestampNs now_ns = frames_.back().timestamp_ns;
  const double since_s = seconds_between(seen_->timestamp_ns, now_ns);
  const auto turn = gyroscope_->turn(seen_->timestamp_ns, now_ns);
  const auto before = pose_in_reference(frames_[frames_.size() - 2]);
  const auto by_walk = predict_pose();
  if (!turn || since_s > kLongestByTurn_s || !before || !by_walk) return std::nullopt;
  const Eigen::Quaterniond rotation =
      before->keyframe_from_camera.rotation * seen_->newest_from_seen.rotation * turn->from_from_to;
  const auto turned = [&](const geometry::RigidTransform& pose) {
    return geometry::RigidTransform{rotation, pose.translation};
  };
  // Where the walk goes is known from two frames.
  const double sigma_m = (by_walk->other_start ? 1 : 2) * walk_sigma_m(since_s);
  motion::PosePrior prior =
      motion::PosePrior::around(turned(by_walk->reference_from_current), sigma_m,
                                std::hypot(turn->sigma_rad, kAnchorSigma_rad));
  if (by_walk->other_start) prior.other_start = turned(*by_walk->other_start);
  return prior;
}

motion::MotionOutcome Mapper::track_by_turn(const motion::FrameMeasurements& reference,
                                            const motion::FrameMeasurements& current,
                                            const motion::PosePrior& prior,
                                            const RandomStream& random) {
  const auto locate = [&](const std::optional<motion::PosePrior>& from) {
    return motion::locate_frame(reference, current, from, camera_, options_.locator, random);
  };
  const motion::MotionOutcome expected = locate(prior);
  if (is_seen(expected) && !contradicts_turn(expected, prior)) return expected;
  const motion::MotionOutcome by_walk = locate(predict_pose());
  for (const motion::MotionOutcome& outcome : {by_walk, expected}) {
    if (!is_seen(outcome)) continue;
    if (contradicts_turn(outcome, prior)) frames_.back().motion->use = MotionUse::kDropped;
    return outcome;
  }
  // Pictures leave it open where it is: a guess, as where nothing is seen.
  if (expected.found() || by_walk.found()) frames_.back().motion->use = MotionUse::kAlone;
  return expected.found() ? expected : by_walk;
}

void Mapper::take_device_motion(const Frame& frame) {
  if (gyroscope_) {
    follow_seen();
    learn_bias();
    return;
  }
  device_.pass(frame);
  if (!mark_ || !frame.place) return;
  // Relative to itself a key-frame is where it is, whatever brought it there.
  if (frame.motion->use != MotionUse::kAlone || is_keyframe(frame))
    anchor_ = DeviceAnchor{frame.index, *frame.place, *mark_};
}

void Mapper::drop_device_motion() {
  frames_.back().motion->use = MotionUse::kDropped;
  mark_ = device_.mark(frames_.back());
}

std::optional<motion::PosePrior> Mapper::device_pose() const {
  if (!mark_ || !anchor_) return std::nullopt;
  auto step = device_step(anchor_->mark, *mark_);
  if (!step) return std::nullopt;
  step->reference_from_current = anchor_->place.keyframe_from_camera * step->reference_from_current;
  step->information =
      motion::with_systematic_error(step->information, kAnchorSigma_m, 0.5 * kAnchorSigma_rad);
  return step;
}

std::optional<motion::PosePrior> Mapper::device_pose_in_reference() const {
  auto in_anchor = device_pose();
  if (!in_anchor) return std::nullopt;
  const auto pose =
      pose_in_reference(FramePlace{anchor_->place.keyframe, in_anchor->reference_from_current});
  if (!pose) return std::nullopt;
  in_anchor->reference_from_current = *pose;
  return in_anchor;
}

std::optional<Mapper::DeadReckonedPose> Mapper::dead_reckoned_pose() const {
  if (const auto turned = predict_turned_pose())
    return DeadReckonedPose{reference_history_.back(), *turned};
  if (const auto by_device = device_pose()) {
    DeadReckonedPose reckoned{anchor_->place.keyframe, *by_device};
    reckoned.in_keyframe.information =
        doubted(by_device->information, device_pose_in_reference(), predict_pose());
    return reckoned;
  }
  // Across one jump, not over many: the walk goes on as it went for a frame, no longer.
  const auto is_jump = [](const Frame& frame) {
    return frame.motion && frame.motion->use == MotionUse::kDropped;
  };
  const bool has_jumped = mark_ && is_jump(frames_.back());
  if (!has_jumped || frames_.size() < 2 || !frames_[frames_.size() - 2].place ||
      is_jump(frames_[frames_.size() - 2])) {
    return std::nullopt;
  }
  const auto by_walk = predict_pose();
  if (!by_walk) return std::nullopt;
  return DeadReckonedPose{reference_history_.back(), *by_walk};
}

motion::MotionOutcome Mapper::track_by_walk(const motion::FrameMeasurements& reference,
                                            const motion::FrameMeasurements& current,
                                            const RandomStream& random) {
  const motion::MotionOutcome outcome =
      motion::locate_frame(reference, current, predict_pose(), camera_, options_.locator, random);
  const auto by_device = device_pose_in_reference();
  if (is_seen(outcome) && by_device && contradicts(outcome, *by_device)) drop_device_motion();
  return outcome;
}

motion::MotionOutcome Mapper::track_by_device(const motion::FrameMeasurements& reference,
                                              const motion::FrameMeasurements& current,
                                              const motion::PosePrior& prior,
                                              const RandomStream& random) {
  // The device's motion has an edge of its own.
  motion::LocatorOptions apart = options_.locator;
  apart.counts_prior = false;
  const motion::MotionOutcome expected =
      motion::locate_frame(reference, current, prior, camera_, apart, random);
  if (is_seen(expected) && !contradicts(expected, prior)) return expected;

  const auto by_walk = predict_pose();
  const motion::MotionOutcome seen =
      motion::locate_frame(reference, current, by_walk, camera_, options_.locator, random);
  if (is_seen(seen) && !contradicts(seen, prior)) return seen;
  const auto is_sure = [&](const motion::MotionOutcome& outcome) {
    // By whole views, by many features, or by few that agree with how the walk goes on where the
    // device does not.
    return outcome.matches == 0 || outcome.inliers >= options_.locator.min_inliers_against_prior ||
           (by_walk && motion::squared_mahalanobis(prior.reference_from_current, *by_walk) >
                           options_.locator.max_squared_mahalanobis);
  };
  for (const motion::MotionOutcome& outcome : {seen, expected}) {
    if (!is_seen(outcome) || !is_sure(outcome)) continue;
    drop_device_motion();
    return outcome;
  }
  if (!is_seen(expected)) return expected;
  motion::MotionOutcome nothing = expected;
  nothing.status = motion::MotionStatus::kContradictsPrior;
  return nothing;
}

Expected<void> Mapper::place_by_dead_reckoning(const DeadReckonedPose& pose,
                                               motion::FrameMeasurements measurements,
                                               MapUpdate& step) {
  previous_.reset();
  frames_lost_ = 0;
  Frame& frame = frames_.back();
  frame.place = FramePlace{pose.keyframe, pose.in_keyframe.reference_from_current};
  // Across a jump the walk is a guess, whose covariance an edge is to hold.
  bool becomes_keyframe = frame.motion->use == MotionUse::kDropped;
  if (!becomes_keyframe) {
    frame.motion->use = MotionUse::kAlone;
    becomes_keyframe = needs_keyframe(frame.place->keyframe_from_camera) &&
                       (measurements.view().has_depth(options_.locator.views.min_overlap) ||
                        can_start_component(measurements));
  }
  if (!becomes_keyframe) {
    set_reference(pose.keyframe);
    return {};
  }
  return add_keyframe(frames_.size() - 1, std::move(measurements),
                      edge_from_device(pose.keyframe, keyframes_.size(), pose.in_keyframe), step);
}

void Mapper::add_device_edge(KeyframeId newest, bool is_newest_frame, bool is_linked_by_device) {
  std::optional<DeviceMark> mark;
  if (is_newest_frame) {
    mark = mark_;
  } else if (anchor_ && anchor_->frame_index == keyframes_[newest].frame_index) {
    // From now on it is where it is by itself.
    anchor_->place = FramePlace{newest, geometry::RigidTransform::identity()};
    mark = anchor_->mark;
  }
  if (!mark) return;
  if (!is_linked_by_device && marked_keyframe_) {
    if (const auto device = device_step(marked_keyframe_->mark, *mark))
      graph_.add(edge_from_device(marked_keyframe_->id, newest, *device));
  }
  marked_keyframe_ = MarkedKeyframe{newest, *mark};
}

}  // namespace roomwise::mapping
