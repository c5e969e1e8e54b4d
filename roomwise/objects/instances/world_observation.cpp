#include "roomwise/objects/instances/world_observation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "roomwise/base/median.h"

namespace roomwise::objects {
namespace {

constexpr int kKeyBits = 21;
constexpr std::int64_t kKeyOffset = std::int64_t{1} << (kKeyBits - 1);
constexpr VoxelKey kStepX = 1;
constexpr VoxelKey kStepY = VoxelKey{1} << kKeyBits;
constexpr VoxelKey kStepZ = VoxelKey{1} << (2 * kKeyBits);

double median_depth(std::vector<Eigen::Vector3f> points) {
  const auto depth = [](const Eigen::Vector3f& point) { return point.z(); };
  return static_cast<double>(median_of(points, depth).z());
}

// Whether the box leaves the picture on three sides or four: a door, a wall, a blurred corner
// look like many a thing from so near.
bool is_cut_all_round(const network::PixelBox& box, const geometry::PinholeCamera& camera) {
  constexpr float kRim_px = 3;
  const int sides = (box.left < kRim_px ? 1 : 0) + (box.top < kRim_px ? 1 : 0) +
                    (box.right > static_cast<float>(camera.width) - kRim_px ? 1 : 0) +
                    (box.bottom > static_cast<float>(camera.height) - kRim_px ? 1 : 0);
  return sides >= 3;
}

}  // namespace

VoxelKey voxel_of(const Eigen::Vector3f& point, float size_m) {
  const auto cell = [&](float coordinate) {
    const auto index = static_cast<std::int64_t>(std::floor(coordinate / size_m));
    return std::clamp(index + kKeyOffset, std::int64_t{1}, 2 * kKeyOffset - 2);
  };
  return cell(point.x()) * kStepX + cell(point.y()) * kStepY + cell(point.z()) * kStepZ;
}

std::vector<VoxelKey> voxels_of(std::span<const Eigen::Vector3f> points, float size_m) {
  std::vector<VoxelKey> keys;
  keys.reserve(points.size());
  for (const Eigen::Vector3f& point : points) keys.push_back(voxel_of(point, size_m));
  std::ranges::sort(keys);
  const auto repeats = std::ranges::unique(keys);
  keys.erase(repeats.begin(), repeats.end());
  return keys;
}

std::array<VoxelKey, 6> face_neighbors(VoxelKey key) {
  return {key - kStepX, key + kStepX, key - kStepY, key + kStepY, key - kStepZ, key + kStepZ};
}

std::vector<VoxelKey> cube_neighbors(VoxelKey key, int reach) {
  std::vector<VoxelKey> keys;
  for (int x = -reach; x <= reach; ++x) {
    for (int y = -reach; y <= reach; ++y) {
      for (int z = -reach; z <= reach; ++z) {
        if (x == 0 && y == 0 && z == 0) continue;
        keys.push_back(key + x * kStepX + y * kStepY + z * kStepZ);
      }
    }
  }
  return keys;
}

std::optional<double> ObservedKeyframe::depth_at_m(const Eigen::Vector3d& point_camera) const {
  const Eigen::Vector2d place = camera.project(point_camera) / kCoarseDepthStep_px;
  const int x = static_cast<int>(std::floor(place.x()));
  const int y = static_cast<int>(std::floor(place.y()));
  if (!coarse_depth.contains(x, y)) return std::nullopt;
  return coarse_depth.at(x, y) / camera.depth_units_per_metre;
}

std::vector<WorldObservation> world_observations(std::span<const ObservedKeyframe> keyframes,
                                                 const GroundPlane& level,
                                                 const InstanceOptions& options) {
  constexpr std::size_t kFewestPoints = 8;
  std::vector<WorldObservation> observations;
  for (std::size_t k = 0; k < keyframes.size(); ++k) {
    for (const Detection& detection : keyframes[k].detections) {
      const std::vector<Eigen::Vector3f>& points = detection.surface.points;
      if (detection.score < options.min_score || points.size() < kFewestPoints) continue;
      if (detection.source != DetectionSource::kProposal &&
          is_cut_all_round(detection.box, keyframes[k].camera)) {
        continue;
      }
      if (median_depth(points) > options.max_range_m) continue;
      WorldObservation observation{&detection, k, {}, {}};
      for (const Eigen::Vector3f& point : points) {
        const Eigen::Vector3d point_world = keyframes[k].world_from_camera * point.cast<double>();
        if (level.height_m(point_world) > kFloorReach_m) {
          observation.points_world.push_back(point_world.cast<float>());
        }
      }
      if (observation.points_world.size() < kFewestPoints) continue;
      observation.voxels = voxels_of(observation.points_world, kObservationVoxel_m);
      observations.push_back(std::move(observation));
    }
  }
  std::ranges::stable_sort(observations, {}, [&](const WorldObservation& observation) {
    const Detection& detection = *observation.detection;
    const double quality =
        static_cast<double>(detection.score) * std::sqrt(static_cast<double>(detection.box.area()));
    return std::tuple(-quality, keyframes[observation.keyframe].keyframe_id, detection.class_name,
                      detection.source, detection.box.left, detection.box.top);
  });
  return observations;
}

}  // namespace roomwise::objects
