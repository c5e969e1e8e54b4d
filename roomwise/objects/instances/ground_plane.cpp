#include <algorithm>
#include <cmath>
#include <map>

#include "roomwise/base/median.h"
#include "roomwise/mapping/graph/up_direction.h"
#include "roomwise/objects/instances/instances.h"

namespace roomwise::objects {
namespace {

constexpr double kBin_m = 0.02;
constexpr double kFloorOfFullest = 1.0 / 3;
constexpr double kMinCameraHeight_m = 0.8;

// The camera of the small depth image.
geometry::PinholeCamera coarse_camera(const geometry::PinholeCamera& camera,
                                      const image::DepthImage& coarse) {
  geometry::PinholeCamera small = camera;
  small.fx /= kCoarseDepthStep_px;
  small.fy /= kCoarseDepthStep_px;
  small.cx = (camera.cx + 0.5) / kCoarseDepthStep_px - 0.5;
  small.cy = (camera.cy + 0.5) / kCoarseDepthStep_px - 0.5;
  small.width = coarse.width();
  small.height = coarse.height();
  return small;
}

}  // namespace

GroundPlane fit_ground_plane(std::span<const ObservedKeyframe> keyframes) {
  mapping::UpDirectionOptions options;
  mapping::UpDirectionEstimator estimator(options);
  for (const ObservedKeyframe& keyframe : keyframes) {
    estimator.add(keyframe.world_from_camera, keyframe.coarse_depth,
                  coarse_camera(keyframe.camera, keyframe.coarse_depth));
    if (keyframe.up_world) estimator.add_gravity(*keyframe.up_world);
  }
  GroundPlane level{.up_world = estimator.estimate().up_world};

  std::vector<double> camera_heights;
  std::map<int, std::size_t> points_at;  // by bin of height
  for (const ObservedKeyframe& keyframe : keyframes) {
    const geometry::PinholeCamera camera = coarse_camera(keyframe.camera, keyframe.coarse_depth);
    camera_heights.push_back(level.up_world.dot(keyframe.world_from_camera.translation));
    for (int y = 0; y < camera.height; y += 2) {
      for (int x = 0; x < camera.width; x += 2) {
        const double depth_m = keyframe.coarse_depth.at(x, y) / camera.depth_units_per_metre;
        if (depth_m <= 0 || depth_m > options.max_depth_m) continue;
        const Eigen::Vector3d point =
            keyframe.world_from_camera * camera.unproject(Eigen::Vector2d(x, y), depth_m);
        ++points_at[static_cast<int>(std::floor(level.up_world.dot(point) / kBin_m))];
      }
    }
  }
  if (camera_heights.empty() || points_at.empty()) return level;
  const int below = static_cast<int>(std::floor((median_of(camera_heights) - 0.3) / kBin_m));
  std::size_t fullest = 0;
  for (const auto& [bin, points] : points_at) {
    if (bin < below) fullest = std::max(fullest, points);
  }
  // Where nothing was seen below the cameras, the lowest that was seen stands in for a floor.
  for (auto at = points_at.begin(); at != points_at.end(); ++at) {
    if (static_cast<double>(at->second) < kFloorOfFullest * static_cast<double>(fullest)) continue;
    // The floor fills a few bins: their middle, by points.
    double sum = 0, points = 0;
    for (auto bin = at; bin != points_at.end() && bin->first <= at->first + 3; ++bin) {
      sum += (bin->first + 0.5) * kBin_m * static_cast<double>(bin->second);
      points += static_cast<double>(bin->second);
    }
    level.floor_m = sum / points;
    level.is_floor_known = median_of(camera_heights) - level.floor_m >= kMinCameraHeight_m;
    break;
  }
  return level;
}

}  // namespace roomwise::objects
