#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "roomwise/geometry/rigid_transform.h"
#include "roomwise/network/vision/classifier.h"
#include "roomwise/objects/detection/object_vocabulary.h"

namespace roomwise::objects {

// An object of the vocabulary that the network named in one key-frame, with its best label's score.
struct ObjectScore {
  std::string object;
  double score = 0;  // probability, [0, 1]
};

// The paper's first two rules: the objects of the vocabulary whose score reaches the threshold,
// best first. `scores` are in the order of `labels`. An object's score is the highest of its
// labels'.
[[nodiscard]] std::vector<ObjectScore> observations_in(std::span<const float> scores,
                                                       std::span<const std::string> labels,
                                                       const ObjectVocabulary& vocabulary,
                                                       double min_score);

// Every object of the vocabulary among the `most` best labels of a picture, best first, whatever
// its score (the two-frame rule looks at the top three).
[[nodiscard]] std::vector<ObjectScore> top_objects(std::span<const float> scores,
                                                   std::span<const std::string> labels,
                                                   const ObjectVocabulary& vocabulary,
                                                   std::size_t most);

// What one key-frame contributes. Key-frames come in the order of time; "continuous" means
// neighbours in it, unless the walk led over known ground in between.
struct KeyframeView {
  std::uint64_t keyframe_id = 0;
  bool is_continuous = true;  // with the one before
  std::vector<ObjectScore> observations;
  // The point that the image centre sees, in the key-frame's camera frame, m; absent without depth
  // there.
  std::optional<Eigen::Vector3d> center_point;
};

struct ObjectRules {
  double min_score = 0.3;  // rule 1: the score passes this threshold
  // Rule 3: seen in at least `min_observations` of `window` continuous key-frames in a row.
  int window = 4;
  int min_observations = 4;
  // Two confirmed observations of one name closer than this are one object, m.
  double same_object_distance_m = 1.0;

  [[nodiscard]] Expected<void> validate() const;
};

// An object of the home that the paper's three rules confirmed (ObjectRules), by whole pictures;
// the things that regions of pictures show are Instances (instances.h). Its place is kept relative
// to the key-frame that saw it best, so that it follows when the key-frame's pose changes:
// world_from_keyframe * position_keyframe.
struct ConfirmedObject {
  std::string name;
  std::uint64_t keyframe_id = 0;
  double score = 0;
  int observations = 0;  // key-frames that saw it
  // Absent where the best key-frame has no depth at its centre: known to be seen from there, not
  // where it stands.
  std::optional<Eigen::Vector3d> position_keyframe;
};

// The paper's three rules over a whole recording. world_from_keyframe gives the optimised pose of a
// key-frame. By name, then by key-frame.
[[nodiscard]] std::vector<ConfirmedObject> confirm_objects(
    std::span<const KeyframeView> views, const ObjectRules& rules,
    const std::function<geometry::RigidTransform(std::uint64_t keyframe_id)>& world_from_keyframe);

}  // namespace roomwise::objects
