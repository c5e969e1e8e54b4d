#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/geometry/oriented_box.h"
#include "roomwise/geometry/pinhole_camera.h"
#include "roomwise/geometry/rigid_transform.h"
#include "roomwise/objects/detection/confirmed_objects.h"
#include "roomwise/objects/detection/region_surface.h"

// From a network's box to a spoken prompt, a type for each step:
// 1. network::Detection: a network's box in a picture, with the index of its label.
// 2. objects::Detection: the same in a key-frame (KeyframeDetections; ObservedKeyframe, which has
//    the pose), with the surface that depth shows in it, and its class. Stored.
// 3. WorldObservation: a detection that counts, with its surface in the world.
// 4. Candidate: the observations of one class that show one thing, with the box about them.
// 5. Instance: a candidate that is believed, relative to the key-frame that shows it best. Stored.
// 6. guide::KnownThing: an instance, its place on the map and its room.
// 7. guide::Prompt: what is said of it.
// Beside them, PlacedInstance (changes.h) is an instance in the world, to compare a visit with the
// map.
namespace roomwise::objects {

// A thing of the home, joined from what many key-frames show of it. Its place is kept relative to
// the key-frame that shows it best.
struct Instance {
  std::string name;
  double probability = 0;  // that it is there and is called so, [0, 1]
  // What it may be called, by how probable that is beside the others; they sum to 1.
  std::map<std::string, double> names;
  int observations = 0;  // key-frames that saw it
  // Key-frames that should have; of what stands apart in depth (DetectionSource::kProposal) those
  // that did, since the others say nothing against it.
  int expected = 0;
  std::uint64_t keyframe_id = 0;
  network::PixelBox picture_box;  // there
  // Upright: z of the box frame is up. Its "world" is the key-frame's camera frame.
  geometry::OrientedBox box_keyframe;
  // Standard deviation of the box's middle along x, y, z of the box frame, m, as it was fitted
  // (InstanceModel).
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();
  // Of what only a later visit to the home showed (home::VisitId): its key-frame is one near by,
  // which does not show it, and has no box in its picture. 0: the key-frames of the map show it.
  std::int64_t visit = 0;
  // A sample of its surface, in the key-frame's camera frame; only of what a visit brought.
  std::vector<Eigen::Vector3f> surface_keyframe;

  [[nodiscard]] geometry::OrientedBox box_world(
      const geometry::RigidTransform& world_from_keyframe) const {
    return {world_from_keyframe * box_keyframe.world_from_box, box_keyframe.size_m};
  }
};

// A key-frame that was looked at; of its detections those that have a class (classified()).
struct ObservedKeyframe : KeyframeDetections {
  std::uint64_t keyframe_id = 0;
  geometry::RigidTransform world_from_camera;
  geometry::PinholeCamera camera;
  // That did not look at it: what they find elsewhere is not missed here.
  std::set<DetectionSource> sources_not_run;
  std::optional<Eigen::Vector3d> up_world = std::nullopt;  // where its device feels gravity

  // What was measured where the picture shows a point before the camera, m; 0 where nothing was,
  // absent outside of the picture.
  [[nodiscard]] std::optional<double> depth_at_m(const Eigen::Vector3d& point_camera) const;
};

// The level of the world: heights above the floor are up . point - floor_m.
struct GroundPlane {
  Eigen::Vector3d up_world = -Eigen::Vector3d::UnitY();  // unit length
  double floor_m = 0;
  // Otherwise the lowest that was seen is no floor: a desk's top, say, or nothing at all.
  bool is_floor_known = false;

  [[nodiscard]] double height_m(const Eigen::Vector3d& point_world) const {
    return up_world.dot(point_world) - floor_m;
  }
};

// Which way is up, by the surfaces that the key-frames show (mapping::UpDirectionEstimator), and
// the floor: the lowest height that holds a third of the points of the fullest one below the
// cameras, or more. It is known where it lies at least 0.8 m below the cameras, which nobody
// carries lower.
[[nodiscard]] GroundPlane fit_ground_plane(std::span<const ObservedKeyframe> keyframes);

struct InstanceOptions {
  double min_score = 0.3;    // of a detection that counts
  double max_range_m = 4.5;  // detections beyond are not measured well enough
  int min_observations = 2;  // key-frames
  // Of what is told; absent: as it was fitted (InstanceModel).
  std::optional<double> min_probability = std::nullopt;

  [[nodiscard]] Expected<void> validate() const;
};

// Joins the detections of all key-frames of one component of a map into instances: candidates by
// association (world_observation.h), each with the probability that its evidence gives it
// (instance_model.h); of those that share their space the most probable stays. The result hangs on
// the key-frames' poses as they are now, and not on the order in which key-frames and detections
// come.
// By name, then by key-frame.
[[nodiscard]] std::vector<Instance> find_instances(std::span<const ObservedKeyframe> keyframes,
                                                   const GroundPlane& level,
                                                   const InstanceOptions& options);

}  // namespace roomwise::objects
