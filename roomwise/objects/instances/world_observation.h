#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "roomwise/objects/instances/instances.h"

// Steps of find_instances(); private to objects/ and to what fits its model.
namespace roomwise::objects {

// A cell of space, packed into one number.
using VoxelKey = std::int64_t;
[[nodiscard]] VoxelKey voxel_of(const Eigen::Vector3f& point, float size_m);
// Sorted, each once.
[[nodiscard]] std::vector<VoxelKey> voxels_of(std::span<const Eigen::Vector3f> points,
                                              float size_m);
// The cells of the cube that reaches so many cells from this one to each side, but for this one.
[[nodiscard]] std::vector<VoxelKey> cube_neighbors(VoxelKey key, int reach);

constexpr double kFloorReach_m = 0.06;  // what lies lower over a floor is floor

// A detection that counts, in the world.
struct WorldObservation {
  const Detection* detection = nullptr;
  std::size_t keyframe = 0;                   // index of ObservedKeyframe
  std::vector<Eigen::Vector3f> points_world;  // above the floor, where one is known
  // Where it has the thing: a little behind the median of the surface in the inner half of its box.
  Eigen::Vector3d middle_world = Eigen::Vector3d::Zero();
};

// The detections that score enough, are near enough and have a surface; the best first, by their
// score, more for what fills more of the picture, then by key-frame, class and box, so that their
// order is theirs alone.
[[nodiscard]] std::vector<WorldObservation> world_observations(
    std::span<const ObservedKeyframe> keyframes, const GroundPlane& level,
    const InstanceOptions& options);

// Observations of one thing, by index, the best first.
using ObservationCluster = std::vector<std::size_t>;

// Groups observations of one class that have their thing in one place (association by votes). The
// place where most key-frames have one becomes a group and takes those within reach of it, of each
// key-frame and source the nearest; then the place where most of the rest have one, and so on. A
// reach is 0.6 of the class's usual extent, a hand's breadth at least. Groups within reach of each
// other are joined unless they are seen side by side in more than 0.15 of the smaller one's
// pictures.
[[nodiscard]] std::vector<ObservationCluster> associate(
    std::span<const WorldObservation> observations);

// A group of observations that may be an instance.
struct Candidate {
  ObservationCluster group;
  std::string class_name;
  Eigen::Vector3d middle_world = Eigen::Vector3d::Zero();  // mean of what its observations say
  double spread_m = 0;                                     // RMS distance of those from it
  // What most of its pictures' boxes hold of its surfaces. Fewer than four cells of it: a box
  // without size.
  geometry::OrientedBox box_world;
  // The standard deviation of the box's middle along its axes, by what differs from picture to
  // picture alone.
  Eigen::Vector3d jackknife_m = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3f> surface_world;  // the middles of its cells

  [[nodiscard]] bool has_extent() const { return box_world.size_m.norm() > 0; }
  // As of a cube of the same volume, m; 5 cm at least.
  [[nodiscard]] double extent_m() const;
};
[[nodiscard]] Candidate candidate_of(ObservationCluster group,
                                     std::span<const WorldObservation> observations,
                                     std::span<const ObservedKeyframe> keyframes,
                                     const GroundPlane& level);

// All of them, those without extent left out.
[[nodiscard]] std::vector<Candidate> find_candidates(std::span<const WorldObservation> observations,
                                                     std::span<const ObservedKeyframe> keyframes,
                                                     const GroundPlane& level);

// Whether a key-frame should have shown a surface: most of it lies in the picture, near enough and
// large enough, and not behind something.
[[nodiscard]] bool should_see(const ObservedKeyframe& keyframe,
                              std::span<const Eigen::Vector3f> surface_world, double max_range_m);

// The share of a box that lies in another, by a grid of its points.
[[nodiscard]] double share_inside(const geometry::OrientedBox& box,
                                  const geometry::OrientedBox& of);

}  // namespace roomwise::objects
