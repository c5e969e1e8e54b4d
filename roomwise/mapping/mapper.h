#pragma once

#include <optional>
#include <string>
#include <vector>

#include "roomwise/mapping/keyframe.h"
#include "roomwise/mapping/loop_closer.h"
#include "roomwise/mapping/pose_graph.h"
#include "roomwise/motion/motion_estimator.h"

namespace roomwise::mapping {

struct MapperOptions {
  motion::MotionOptions motion;
  // The motion is substantial, and the frame becomes a key-frame, from here on.
  double keyframe_translation_m = 0.12;
  double keyframe_rotation_rad = 0.14;
  LoopOptions loops;
  // After so many frames in a row that match nothing, mapping goes on in a new piece.
  int frames_until_new_piece = 5;
  std::uint64_t seed = 1;

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

// The paper's mapping: each frame is located against the last key-frame; a substantial motion makes
// it a key-frame, which is then compared with earlier ones to close loops; the pose graph is
// optimised on demand.
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

  MapStep add_frame(std::uint64_t frame_index, TimestampNs timestamp_ns,
                    motion::MeasuredFeatures features);

  [[nodiscard]] const std::vector<Keyframe>& keyframes() const { return keyframes_; }
  [[nodiscard]] const std::vector<PoseGraphEdge>& edges() const { return edges_; }
  [[nodiscard]] const std::vector<MappedFrame>& frames() const { return frames_; }

 private:
  struct PreviousFrame {
    std::size_t position = 0;  // in frames_
    motion::MeasuredFeatures features;
    PoseGraphEdge edge;  // from the last key-frame, should it become a key-frame
  };

  motion::MotionOutcome locate(const Keyframe& reference, std::uint64_t frame_index,
                               const motion::MeasuredFeatures& features) const;
  // Looks for the frame among earlier key-frames; on success sets reference and outcome.
  void recognize(std::uint64_t frame_index, const motion::MeasuredFeatures& features,
                 KeyframeId& reference, motion::MotionOutcome& outcome) const;
  void begin_piece(std::size_t frame_position, motion::MeasuredFeatures features, MapStep& step);
  void add_keyframe(std::size_t frame_position, motion::MeasuredFeatures features,
                    const std::optional<PoseGraphEdge>& link, MapStep& step);

  geometry::PinholeCamera camera_;
  MapperOptions options_;
  std::vector<Keyframe> keyframes_;
  std::vector<PoseGraphEdge> edges_;
  std::vector<MappedFrame> frames_;
  std::optional<PreviousFrame> previous_;  // the frame before, if it was placed and is no key-frame
  int frames_lost_ = 0;
};

}  // namespace roomwise::mapping
