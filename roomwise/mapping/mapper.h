#pragma once

#include <optional>
#include <string>
#include <vector>

#include "roomwise/mapping/appearance_index.h"
#include "roomwise/mapping/keyframe.h"
#include "roomwise/mapping/loop_closer.h"
#include "roomwise/mapping/pose_graph.h"
#include "roomwise/motion/frame_locator.h"

namespace roomwise::mapping {

enum class MappingMethod {
  kPaper,     // features alone, frame against key-frame
  kCombined,  // whole views where the motion can be foreseen, features where not, each checked
};
[[nodiscard]] Expected<MappingMethod> parse_mapping_method(std::string_view name);
[[nodiscard]] std::string_view to_string(MappingMethod method);  // "paper", "combined"

struct MapperOptions {
  MappingMethod method = MappingMethod::kCombined;
  motion::LocatorOptions locator;
  // The motion is substantial, and the frame becomes a key-frame, from here on.
  double keyframe_translation_m = 0.12;
  double keyframe_rotation_rad = 0.14;
  LoopOptions loops;
  // After so many frames in a row that match nothing, mapping goes on in a new piece.
  int frames_until_new_piece = 5;
  std::uint64_t seed = 1;

  // The defaults of a method: the paper's draws all its far loop candidates at random.
  [[nodiscard]] static MapperOptions of(MappingMethod method);
  [[nodiscard]] Expected<void> validate() const;
};

// Where a frame is: relative to a key-frame, whose pose may still change.
struct FramePlace {
  KeyframeId keyframe = 0;
  geometry::RigidTransform keyframe_from_camera;
};

struct MappedFrame {
  std::uint64_t frame_index = 0;
  TimestampNs timestamp_ns = 0;
  std::optional<FramePlace> place;
  std::string why_unplaced;  // the motion's outcome, where there is no place
};

// What one frame changed, for those who store or show the map as it grows.
struct MapStep {
  // Key-frames made in this step, in order: none, the frame before (kept late, because this one no
  // longer matched the last key-frame), this frame, or both.
  std::vector<KeyframeId> new_keyframes;
};

// Mapping after the paper: each frame is located against the last key-frame, by the chosen method;
// a substantial motion makes it a key-frame, which is then compared with earlier ones to close
// loops; the pose graph is optimised on demand.
//
// Key-frames that are connected by edges make a piece. When tracking is lost and no key-frame is
// recognised, mapping goes on in a new piece; a loop closure joins pieces by itself, since it is an
// edge between them.
//
// Same frames and options, same bits. A Mapper restored at a key-frame goes on exactly as one that
// was never stopped.
class Mapper {
 public:
  // Options must be valid.
  Mapper(const geometry::PinholeCamera& camera, const MapperOptions& options);

  // Takes back what an earlier run had mapped up to and including its newest key-frame.
  void restore(std::vector<Keyframe> keyframes, std::vector<PoseGraphEdge> edges,
               std::vector<MappedFrame> frames);

  // Frames must come in the order of time. The combined method gains nothing over the paper's for
  // frames without views.
  MapStep add_frame(std::uint64_t frame_index, TimestampNs timestamp_ns,
                    motion::FrameMeasurements measurements);

  [[nodiscard]] const std::vector<Keyframe>& keyframes() const { return keyframes_; }
  [[nodiscard]] const std::vector<PoseGraphEdge>& edges() const { return edges_; }
  [[nodiscard]] const std::vector<MappedFrame>& frames() const { return frames_; }

 private:
  struct PreviousFrame {
    std::size_t position = 0;  // in frames_
    motion::FrameMeasurements measurements;
    PoseGraphEdge edge;  // from the last key-frame, should it become a key-frame
  };

  // Where the frame at `position` will be relative to the last key-frame if the camera goes on as
  // it moved last; nothing where it was lost for long.
  [[nodiscard]] std::optional<motion::PosePrior> foresee(std::size_t position) const;
  // A placed frame relative to the last key-frame, if it was placed against that or the one before.
  [[nodiscard]] std::optional<geometry::RigidTransform> from_last_keyframe(
      const MappedFrame& frame) const;
  [[nodiscard]] bool can_begin(const motion::FrameMeasurements& measurements) const;
  [[nodiscard]] motion::MotionOutcome track(std::size_t position,
                                            const motion::FrameMeasurements& current) const;
  // A key-frame a little before the newest: where the newest is along the steps between them.
  [[nodiscard]] std::optional<geometry::RigidTransform> along_steps(KeyframeId from) const;
  // Those with an id below `before` that look most like it, best first.
  [[nodiscard]] std::vector<KeyframeId> similar_keyframes(
      const motion::FrameMeasurements& measurements, KeyframeId before) const;
  // The frame against any key-frame, as loops are compared: surer than a step must be, and without
  // resting on what the map holds already.
  [[nodiscard]] motion::MotionOutcome compare(const Keyframe& reference,
                                              const motion::FrameMeasurements& current,
                                              std::uint64_t frame_index) const;
  // Looks for the frame among earlier key-frames; on success sets reference and outcome.
  void recognize(std::uint64_t frame_index, const motion::FrameMeasurements& current,
                 KeyframeId& reference, motion::MotionOutcome& outcome) const;
  void begin_piece(std::size_t frame_position, motion::FrameMeasurements measurements,
                   MapStep& step);
  void add_keyframe(std::size_t frame_position, motion::FrameMeasurements measurements,
                    const std::optional<PoseGraphEdge>& link, MapStep& step);

  geometry::PinholeCamera camera_;
  MapperOptions options_;
  std::vector<Keyframe> keyframes_;
  std::vector<PoseGraphEdge> edges_;
  std::vector<MappedFrame> frames_;
  std::optional<PreviousFrame> previous_;  // the frame before, if it was placed and is no key-frame
  int frames_lost_ = 0;
  AppearanceIndex index_;  // of all key-frames, where the method looks for similar ones
};

}  // namespace roomwise::mapping
