#pragma once

#include <map>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "roomwise/mapping/backend/up_measurement.h"
#include "roomwise/mapping/bundle/landmarks.h"
#include "roomwise/mapping/frontend/keyframe.h"

namespace roomwise::mapping {

// The level ground under key-frames of one component: a node of its own, whose z axis is up, with
// an edge to each key-frame that tells of up. The edges hold the key-frames' tilt to each other and
// nothing else: which way the ground lies is found with them.
struct Ground {
  geometry::RigidTransform world_from_ground;
  std::vector<PoseGraphEdge> edges;  // from the ground's node to key-frames
};

// What the key-frames of a map tell of up.
class Grounds {
 public:
  // `component` by key-frame id; it is kept as a view.
  Grounds(const UpMeasurementOptions& options, std::span<const std::size_t> component)
      : options_(options), component_(component) {}

  // Up as the device of a key-frame felt it, in its camera's frame. It is where the search for up
  // begins, and a measurement of its own, which is dropped where what is level contradicts it.
  void add_gravity(KeyframeId id, const Eigen::Vector3d& up_camera) { gravity_[id] = up_camera; }

  // Measures up in these key-frames, by their normals, at poses that may still err by some degrees;
  // poses and how the camera turned (rad/s, in its frame) are by key-frame id. Where that is not
  // known nothing is measured but what the device felt: by how much depth lags behind the picture
  // is not known then. Of those that are not `own` (ascending) as well, what was measured before
  // stays: who owns them sees all that is around them.
  void measure(std::span<const KeyframeId> ids, std::span<const KeyframeId> own,
               std::span<const KeyframeFeatures> features,
               std::span<const geometry::RigidTransform> world_from_keyframe,
               std::span<const std::optional<Eigen::Vector3d>> turning_rad_s);

  // The key-frames of which it was dropped.
  [[nodiscard]] std::size_t contradicted() const { return contradicted_.size(); }

  // Under those of these key-frames that tell of up, one for each component; the first ground's
  // node is `first_node`, the others follow. Edges are made with up_edge().
  [[nodiscard]] std::vector<Ground> under(
      std::span<const KeyframeId> ids,
      std::span<const geometry::RigidTransform> world_from_keyframe, NodeId first_node,
      double kernel_sigmas) const;

 private:
  // To what surfaces say of a key-frame; so many key-frames of its component feel gravity.
  void add_felt(KeyframeId id, std::optional<UpMeasurement>& level, double felt_at);

  UpMeasurementOptions options_;
  std::span<const std::size_t> component_;
  std::map<KeyframeId, Eigen::Vector3d> gravity_;  // camera frame
  std::set<KeyframeId> contradicted_;
  // Of those that were measured; some tell nothing.
  std::map<KeyframeId, std::optional<UpMeasurement>> measured_;
};

}  // namespace roomwise::mapping
