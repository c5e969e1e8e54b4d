#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "roomwise/objects/instances/instances.h"

// Steps of find_instances(); private to objects/.
namespace roomwise::objects {

// A cell of space, packed into one number.
using VoxelKey = std::int64_t;
[[nodiscard]] VoxelKey voxel_of(const Eigen::Vector3f& point, float size_m);
// Sorted, each once.
[[nodiscard]] std::vector<VoxelKey> voxels_of(std::span<const Eigen::Vector3f> points,
                                              float size_m);
// The cells that share a face with this one.
[[nodiscard]] std::array<VoxelKey, 6> face_neighbors(VoxelKey key);
// The cells of the cube that reaches so many cells from this one to each side, but for this one.
[[nodiscard]] std::vector<VoxelKey> cube_neighbors(VoxelKey key, int reach);

// A detection that counts, in the world.
struct WorldObservation {
  const Detection* detection = nullptr;
  std::size_t keyframe = 0;                   // index of ObservedKeyframe
  std::vector<Eigen::Vector3f> points_world;  // above the floor
  std::vector<VoxelKey> voxels;               // of kObservationVoxel_m

  // How much its score counts for its class: cells of activation maps see far beyond themselves, so
  // that what they say is in part about the whole picture. Detections on proposals say the mean of
  // all views, of what was measured before.
  [[nodiscard]] double weighted_score() const {
    const bool is_of_proposal = detection->source == DetectionSource::kProposal;
    const bool is_of_map = detection->source == DetectionSource::kActivation;
    return (is_of_proposal ? 2 : is_of_map ? 0.5 : 1) * static_cast<double>(detection->score);
  }
};
constexpr float kObservationVoxel_m = 0.1F;
// What lies lower is floor.
constexpr double kFloorReach_m = 0.06;

// The detections that score enough, are near enough and have a surface above the floor; the best
// first, by their score, more for what fills more of the picture, then by key-frame, class and box,
// so that their order is theirs alone.
[[nodiscard]] std::vector<WorldObservation> world_observations(
    std::span<const ObservedKeyframe> keyframes, const GroundPlane& level,
    const InstanceOptions& options);

// Observations of one instance, by index, the best first.
using ObservationCluster = std::vector<std::size_t>;

// Groups observations of one class and source that show the same part of space. Two detections
// beside each other in one picture are two things, and so are groups that are often seen so. A
// detector's boxes that show what detections on proposals measured belong to their group.
[[nodiscard]] std::vector<ObservationCluster> cluster_observations(
    std::span<const WorldObservation> observations);

// A group of observations that may be an instance.
struct Candidate {
  ObservationCluster group;
  // What most of its pictures' boxes hold of its surfaces, and how sure the middle is. Fewer than
  // four cells of it: a box without size.
  geometry::OrientedBox box_world;
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3f> surface_world;  // the middles of its cells
  std::vector<VoxelKey> voxels;                // of the surface, of kObservationVoxel_m
  // Whether what was seen of it is as large as such things are (ClassSizePrior): a door is no
  // wardrobe, nor is the corner of a room, and a bowl no bath.
  bool fits_size_prior = true;
  double foot_m = 0;                                      // the box's lower end, over the floor
  std::map<std::string, double> scores;                   // by class
  DetectionSource source = DetectionSource::kActivation;  // the surest of the group's
  Instance instance;                                      // once it was found to be one

  [[nodiscard]] bool has_extent() const { return box_world.size_m.norm() > 0; }
};
[[nodiscard]] Candidate candidate_of(ObservationCluster group,
                                     std::span<const WorldObservation> observations,
                                     std::span<const ObservedKeyframe> keyframes,
                                     const GroundPlane& level);

// Whether a key-frame should have shown a surface: most of it lies in the picture, near enough and
// large enough, and not behind something.
[[nodiscard]] bool should_see(const ObservedKeyframe& keyframe,
                              std::span<const Eigen::Vector3f> surface_world, double max_range_m);

}  // namespace roomwise::objects
