#include "roomwise/objects/instances/world_observation.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "roomwise/base/median.h"
#include "roomwise/objects/kinds/kinds.h"

namespace roomwise::objects {
namespace {

constexpr double kBehindSurface = 0.15;  // of the usual shorter level side
constexpr int kKeyBits = 21;
constexpr std::int64_t kKeyOffset = std::int64_t{1} << (kKeyBits - 1);
constexpr VoxelKey kStepX = 1;
constexpr VoxelKey kStepY = VoxelKey{1} << kKeyBits;
constexpr VoxelKey kStepZ = VoxelKey{1} << (2 * kKeyBits);

double median_depth(std::vector<Eigen::Vector3f> points) {
  const auto depth = [](const Eigen::Vector3f& point) { return point.z(); };
  return static_cast<double>(median_of(points, depth).z());
}

// Behind the median of the surface in the inner half of the box, by side (of the whole surface
// where nothing is there), by a share of the usual depth of such things; in the camera frame.
Eigen::Vector3d middle_of(const Detection& detection, const geometry::PinholeCamera& camera) {
  const network::PixelBox& box = detection.box;
  const Eigen::Vector2d middle(0.5F * (box.left + box.right), 0.5F * (box.top + box.bottom));
  const Eigen::Vector2d reach(0.25F * (box.right - box.left), 0.25F * (box.bottom - box.top));
  std::vector<Eigen::Vector3f> inside;
  for (const Eigen::Vector3f& point : detection.surface.points) {
    const Eigen::Vector2d off = camera.project(point.cast<double>()) - middle;
    if ((off.cwiseAbs().array() <= reach.array()).all()) inside.push_back(point);
  }
  if (inside.empty()) inside = detection.surface.points;
  Eigen::Vector3d median;
  for (int axis = 0; axis < 3; ++axis) {
    const auto along = [axis](const Eigen::Vector3f& point) { return point[axis]; };
    median[axis] = static_cast<double>(along(median_of(inside, along)));
  }
  // What is seen is the side that faces the camera.
  const Kind* kind = find_kind(detection.class_name);
  const bool is_known = kind != nullptr && kind->size;
  const double behind_m = is_known ? kBehindSurface * kind->size->usual_m.y() : 0;
  return median + behind_m * median.normalized();
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
  std::vector<WorldObservation> observations;
  for (std::size_t k = 0; k < keyframes.size(); ++k) {
    const ObservedKeyframe& keyframe = keyframes[k];
    for (const Detection& detection : keyframe.detections) {
      const std::vector<Eigen::Vector3f>& points = detection.surface.points;
      if (detection.score < options.min_score || points.empty()) continue;
      if (median_depth(points) > options.max_range_m) continue;
      WorldObservation observation{
          &detection, k, {}, keyframe.world_from_camera * middle_of(detection, keyframe.camera)};
      for (const Eigen::Vector3f& point : points) {
        const Eigen::Vector3d point_world = keyframe.world_from_camera * point.cast<double>();
        if (!level.is_floor_known || level.height_m(point_world) > kFloorReach_m) {
          observation.points_world.push_back(point_world.cast<float>());
        }
      }
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
