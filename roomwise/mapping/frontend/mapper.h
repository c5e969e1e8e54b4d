#pragma once

#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "roomwise/mapping/frontend/appearance_index.h"
#include "roomwise/mapping/frontend/device_odometry.h"
#include "roomwise/mapping/frontend/gyroscope.h"
#include "roomwise/mapping/frontend/keyframe.h"
#include "roomwise/mapping/frontend/keyframe_graph.h"
#include "roomwise/mapping/frontend/mapper_options.h"
#include "roomwise/mapping/frontend/measurement_store.h"
#include "roomwise/mapping/frontend/motion_prediction.h"
#include "roomwise/scene/frame.h"

namespace roomwise::mapping {

using scene::Frame;
using scene::FramePlace;

// What one frame changed, for those who store or show the map as it grows.
struct MapUpdate {
  // Key-frames made in this step, in order: none, the frame before (kept late, because this one no
  // longer matched the reference), this frame, or both.
  std::vector<KeyframeId> new_keyframes;
  // A Mapper that is restored with the key-frames, edges and frames up to this one goes on as this
  // one does. So it is at every frame that becomes a key-frame or comes back to an earlier one, and
  // now and then where neither happens for long.
  bool is_checkpoint = false;
};

// Mapping after the paper: each frame is located against a reference, the last key-frame, by the
// chosen method; a substantial motion makes it a key-frame, which is then compared with earlier
// ones to close loops; the pose graph is optimised on demand.
//
// Where the walk comes back to a place that it knows, an earlier key-frame becomes the reference
// again and no new one is made: one or two edges lead to it from the reference, and the frame is
// located against it as surely as a loop. So a map grows with the home and not with the walk.
//
// Where the device tells its own motion, that is the prediction, and consecutive key-frames get an
// edge by it besides what pictures say; it is dropped where the pictures surely say otherwise. A
// frame that pictures do not place at all is placed by it alone, as a key-frame where the camera
// moved far and shows something.
//
// Where the device tells no motion but has an inertial sensor, the prediction turns as that does;
// what pictures say of a frame takes it in. A frame that pictures do not place is placed by it and
// the walk as it goes on, for a second. Frames keep where up is felt.
//
// A map may be made from several walks, one after the other. A later walk begins as a component of
// its own, and its key-frames are compared with those of the walks before it as with its own. It
// goes on from none of theirs where it comes back to a place: what it saw is to be kept.
//
// Key-frames that are connected by edges make a component. When tracking is lost and no key-frame
// is recognised, mapping goes on in a new component; a loop closure joins components by itself,
// since it is an edge between them.
//
// Key-frames' measurements beyond the working set lie on the disk; of frames only those are kept
// that were not released. Same frames and options, same bits, whatever the working set. A Mapper
// restored at a checkpoint goes on exactly as one that was never stopped. Errors are those of the
// scratch file; after one the Mapper is not to be used.
class Mapper {
 public:
  // Options must be valid.
  Mapper(const geometry::PinholeCamera& camera, const MapperOptions& options,
         WorkingSet working_set = {});

  // What the device's inertial sensor felt along this walk, frames that tell their own motion
  // aside. Before the first frame, and before restore(); not empty.
  void feel(geometry::InertialTrack track);

  // Takes back what earlier runs had mapped up to a checkpoint: first all key-frames, by id, then
  // the rest. Those from `first_keyframe` on, and the frames, are of the walk that goes on: none
  // where it is to begin. What was measured in each key-frame was so with its own camera.
  [[nodiscard]] Expected<void> restore_keyframe(Keyframe keyframe);
  // The same of those of walks before this one, which come first, without measuring them: `index`
  // is of what they look like, by id, and they are measured when they are compared with.
  void restore_stored(std::vector<KeyframeStamp> keyframes, AppearanceIndex index,
                      MeasureStored measure);
  // What key-frames look like is indexed so, whatever the options' seed.
  static constexpr std::uint64_t kIndexSeed = AppearanceIndex::kUsualSeed;
  void restore(std::span<const PoseGraphEdge> edges, std::span<const Frame> frames,
               KeyframeId first_keyframe = 0);

  // Frames must come in the order of time. The combined method gains nothing over the paper's for
  // frames without views.
  [[nodiscard]] Expected<MapUpdate> add_frame(
      std::uint64_t frame_index, TimestampNs timestamp_ns, motion::FrameMeasurements measurements,
      const std::optional<geometry::DeviceMotion>& device = std::nullopt);

  [[nodiscard]] const std::vector<KeyframeStamp>& keyframes() const { return keyframes_; }
  [[nodiscard]] const std::vector<PoseGraphEdge>& edges() const { return graph_.edges(); }
  [[nodiscard]] bool uses_device_motion() const { return options_.device_motion; }
  // Of a key-frame that is there.
  [[nodiscard]] Expected<SharedMeasurements> measurements(KeyframeId id) { return store_.get(id); }
  // No frame is to come any more: what key-frames look like, some 13 kB each, is given back.
  void release_index() { index_ = AppearanceIndex(kIndexSeed); }
  // The frames that are not released yet, in the order of time.
  [[nodiscard]] const std::deque<Frame>& frames() const { return frames_; }
  // How many were added in all.
  [[nodiscard]] std::uint64_t frame_count() const { return released_ + frames_.size(); }
  // The caller has taken the frames down to the newest but `keep`: they need not be kept for it.
  // (A few stay, since the motion goes on from them.)
  void release_frames(std::size_t keep);

 private:
  struct PreviousFrame {
    motion::FrameMeasurements measurements;
    PoseGraphEdge edge;  // from the reference, should it become a key-frame
  };
  struct RevisitedKeyframe {
    KeyframeId keyframe = 0;
    motion::RefinedPose pose;
  };
  using Outcome = Expected<motion::MotionOutcome>;
  // The last frame whose place does not rest on the device's motion, and that has some.
  struct DeviceAnchor {
    std::uint64_t frame_index = 0;
    FramePlace place;
    DeviceMark mark;
  };
  // Where a frame is that no picture places.
  struct DeadReckonedPose {
    KeyframeId keyframe = 0;
    motion::PosePrior in_keyframe;
  };
  // The camera when pictures last placed it, relative to that of the newest frame.
  struct SeenCamera {
    TimestampNs timestamp_ns = 0;
    geometry::RigidTransform newest_from_seen;
  };
  struct MarkedKeyframe {
    KeyframeId id = 0;
    DeviceMark mark;
  };

  [[nodiscard]] Expected<MapUpdate> place_newest(motion::FrameMeasurements measurements);
  // What the newest frame says of the device's motion, once it has its place.
  void take_device_motion(const Frame& frame);
  void drop_device_motion();
  // Of a frame, by the inertial sensor.
  [[nodiscard]] std::optional<scene::FrameMotion> felt_motion(TimestampNs timestamp_ns) const;
  void learn_bias();
  void follow_seen();
  // How the camera went from one frame to the next; nothing where the walk did not lead from the
  // key-frame of one to that of the other.
  [[nodiscard]] std::optional<geometry::RigidTransform> step(const Frame& from,
                                                             const Frame& to) const;
  // predict_pose(), turned as the inertial sensor says since pictures last placed a frame; nothing
  // where that is long ago.
  [[nodiscard]] std::optional<motion::PosePrior> predict_turned_pose() const;
  [[nodiscard]] motion::MotionOutcome track_by_turn(const motion::FrameMeasurements& reference,
                                                    const motion::FrameMeasurements& current,
                                                    const motion::PosePrior& prior,
                                                    const RandomStream& random);
  // Where the newest frame is by the device's motion since the anchor, relative to the anchor's
  // key-frame, and relative to the reference.
  [[nodiscard]] std::optional<motion::PosePrior> device_pose() const;
  [[nodiscard]] std::optional<motion::PosePrior> device_pose_in_reference() const;
  // The first, or where the device has just jumped, the walk as it goes on.
  [[nodiscard]] std::optional<DeadReckonedPose> dead_reckoned_pose() const;
  // track() as the walk goes on, and as the device says; the second asks the pictures alone where
  // they disagree.
  [[nodiscard]] motion::MotionOutcome track_by_walk(const motion::FrameMeasurements& reference,
                                                    const motion::FrameMeasurements& current,
                                                    const RandomStream& random);
  [[nodiscard]] motion::MotionOutcome track_by_device(const motion::FrameMeasurements& reference,
                                                      const motion::FrameMeasurements& current,
                                                      const motion::PosePrior& prior,
                                                      const RandomStream& random);
  // The newest frame, which the pictures do not place, gets this place.
  [[nodiscard]] Expected<void> place_by_dead_reckoning(const DeadReckonedPose& pose,
                                                       motion::FrameMeasurements measurements,
                                                       MapUpdate& step);
  // The device's motion from the last key-frame that has some to the newest, unless its link is
  // that already. The newest is the newest frame, or the one before.
  void add_device_edge(KeyframeId newest, bool is_newest_frame, bool is_linked_by_device);
  [[nodiscard]] bool is_keyframe(const Frame& frame) const;

  // Where the newest frame will be relative to the reference if the camera goes on as it moved
  // last; nothing where it was lost for long.
  [[nodiscard]] std::optional<motion::PosePrior> predict_pose() const;
  // A placed frame relative to the reference, if an edge leads there from where it was placed.
  [[nodiscard]] std::optional<StampedMotion> pose_in_reference(const Frame& frame) const;
  [[nodiscard]] std::optional<geometry::RigidTransform> pose_in_reference(
      const FramePlace& place) const;
  [[nodiscard]] bool can_start_component(const motion::FrameMeasurements& measurements) const;
  [[nodiscard]] bool needs_keyframe(const geometry::RigidTransform& motion) const;
  // A motion by what makes a key-frame: 1 just does.
  [[nodiscard]] double motion_ratio(const geometry::RigidTransform& motion) const;
  void set_reference(KeyframeId id);

  [[nodiscard]] Outcome track(const motion::FrameMeasurements& current);
  // The references of the walk before the last one.
  [[nodiscard]] std::vector<KeyframeId> recent_references(std::size_t skip_newest) const;
  // A reference a little before the newest: where the newest is along the odometry edges between
  // them.
  [[nodiscard]] std::optional<geometry::RigidTransform> chain_odometry(KeyframeId from) const;
  // Of this walk's with an id below `before` those that look most like it, best first, and then as
  // many of earlier walks'.
  [[nodiscard]] std::vector<KeyframeId> similar_keyframes(
      const motion::FrameMeasurements& measurements, KeyframeId before) const;
  // The frame against any key-frame, as loops are compared: surer than an odometry edge must be,
  // and without resting on what the map holds already, which may say nearly where it is.
  [[nodiscard]] Outcome compare(KeyframeId reference, const motion::FrameMeasurements& current,
                                std::uint64_t frame_index,
                                const std::optional<motion::PosePrior>& prior);
  // Looks for the newest frame among earlier key-frames; on success sets reference and outcome.
  [[nodiscard]] Expected<void> relocalize(const motion::FrameMeasurements& current,
                                          KeyframeId& reference, motion::MotionOutcome& outcome);
  // An earlier key-frame that the newest frame, here relative to the reference, came back to.
  [[nodiscard]] Expected<std::optional<RevisitedKeyframe>> find_revisited(
      const motion::FrameMeasurements& current, const geometry::RigidTransform& motion);
  void reuse_keyframe(const RevisitedKeyframe& known, const motion::RefinedPose& in_reference);
  [[nodiscard]] Expected<void> add_keyframe(std::size_t frame_position,
                                            motion::FrameMeasurements measurements,
                                            const std::optional<PoseGraphEdge>& link,
                                            MapUpdate& step);
  // Nothing that is needed of the newest frame is anywhere but in frames_.
  void reach_checkpoint(MapUpdate& step);

  geometry::PinholeCamera camera_;  // of this walk
  MapperOptions options_;
  std::vector<KeyframeStamp> keyframes_;
  KeyframeId first_keyframe_ = 0;  // of this walk; the others before it are of earlier ones
  MeasurementStore store_;
  KeyframeGraph graph_;
  std::deque<Frame> frames_;
  std::uint64_t released_ = 0;  // frames before those
  // The key-frames that were the reference last, the present one at the end; each frame that was
  // placed belongs to one.
  std::deque<KeyframeId> reference_history_;
  std::optional<PreviousFrame> previous_;  // the frame before, if it was placed and is no key-frame
  int frames_lost_ = 0;
  int frames_since_checkpoint_ = 0;
  DeviceOdometry device_;                          // up to the frame before
  std::optional<DeviceMark> mark_;                 // of the newest frame
  std::optional<MarkedKeyframe> marked_keyframe_;  // the newest one
  std::optional<DeviceAnchor> anchor_;
  std::optional<Gyroscope> gyroscope_;  // and accelerometer
  std::optional<SeenCamera> seen_;      // with a gyroscope
  AppearanceIndex index_;  // of all key-frames, where the method looks for similar ones
};

}  // namespace roomwise::mapping
