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

// A region that counts, in the world.
struct WorldObservation {
  std::string name;
  bool is_in_vocabulary = true;
  double score = 0;
  RegionSource source = RegionSource::kDetector;
  std::size_t keyframe = 0;  // index of LookedKeyframe
  network::PixelBox box;
  std::vector<Eigen::Vector3f> points_world;  // above the floor
  std::vector<VoxelKey> voxels;               // of kSightVoxel_m
  double quality = 0;                         // the score, more for what fills more of the picture
};
constexpr float kObservationVoxel_m = 0.1F;
// How much a region's score counts for its name: cells of activation maps see far beyond
// themselves, so that what they say is in part about the whole picture. Detections on proposals say
// the mean of all views, of what was measured before.
[[nodiscard]] constexpr double naming_weight(RegionSource source) {
  if (source == RegionSource::kActivation) return 0.5;
  return source == RegionSource::kProposal ? 2 : 1;
}
// What lies lower is floor.
constexpr double kFloorReach_m = 0.06;

// The regions that score enough, are near enough and have a surface above the floor; the best
// first, by quality, then by key-frame, name and box, so that their order is theirs alone.
[[nodiscard]] std::vector<WorldObservation> world_observations(
    std::span<const ObservedKeyframe> keyframes, const GroundPlane& level,
    const InstanceOptions& options);

// Sights of one thing, by index, the best first.
using ObservationCluster = std::vector<std::size_t>;

// Groups observations of one name and source that show the same part of space. Two regions beside
// each other in one picture are two things, and so are groups that are often seen so. A detector's
// boxes that show what detections on proposals measured belong to their group.
[[nodiscard]] std::vector<ObservationCluster> cluster_observations(
    std::span<const WorldObservation> observations);

// The box of a group and how sure its middle is: what most of its pictures' boxes hold of its
// surfaces. Fewer than four cells of it: a box without size.
struct ClusterBox {
  geometry::OrientedBox box_world;
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3f> surface_world;  // the middles of its cells
  // Whether what was seen of it is as large as such things are (ClassSizePrior): a door is no
  // wardrobe, nor is the corner of a room, and a bowl no bath.
  bool fits_size_prior = true;
};
[[nodiscard]] ClusterBox box_of_cluster(const ObservationCluster& group,
                                        std::span<const WorldObservation> observations,
                                        std::span<const ObservedKeyframe> keyframes,
                                        const GroundPlane& level);

// Whether a key-frame should have shown a surface: most of it lies in the picture, near enough and
// large enough, and not behind something.
[[nodiscard]] bool should_see(const ObservedKeyframe& keyframe,
                              std::span<const Eigen::Vector3f> surface_world, double max_range_m);

}  // namespace roomwise::objects
