#include "laboratory/trials/naive_objects.h"

#include <algorithm>
#include <set>
#include <string>

#include "roomwise/base/median.h"

namespace roomwise::trials {
namespace {

constexpr double kReach_m = 0.35;
constexpr std::size_t kMinKeyframes = 4;
constexpr float kMinBestScore = 0.5F;

struct PlacedBox {
  const objects::Detection* detection = nullptr;
  std::uint64_t keyframe = 0;
  Eigen::Vector3d place_world = Eigen::Vector3d::Zero();
};

Eigen::Vector3d median_point(std::vector<Eigen::Vector3f> points) {
  Eigen::Vector3d median;
  for (int axis = 0; axis < 3; ++axis) {
    const auto along = [axis](const Eigen::Vector3f& point) { return point[axis]; };
    median[axis] = static_cast<double>(along(median_of(points, along)));
  }
  return median;
}

// The best first.
std::vector<PlacedBox> placed_boxes(std::span<const objects::ObservedKeyframe> keyframes) {
  std::vector<PlacedBox> boxes;
  for (const objects::ObservedKeyframe& keyframe : keyframes) {
    for (const objects::Detection& detection : keyframe.detections) {
      if (detection.source != objects::DetectionSource::kDetector || !detection.is_in_vocabulary ||
          detection.surface.points.empty()) {
        continue;
      }
      boxes.push_back({&detection, keyframe.keyframe_id,
                       keyframe.world_from_camera * median_point(detection.surface.points)});
    }
  }
  std::ranges::stable_sort(boxes, std::ranges::greater{},
                           [](const PlacedBox& box) { return box.detection->score; });
  return boxes;
}

struct Cluster {
  std::string class_name;
  float best_score = 0;
  std::set<std::uint64_t> keyframes;
  std::size_t boxes = 0;
  Eigen::Vector3d sum_world = Eigen::Vector3d::Zero();

  [[nodiscard]] Eigen::Vector3d mean_world() const {
    return sum_world / static_cast<double>(boxes);
  }
};

}  // namespace

std::vector<evaluation::FoundObject> naive_objects(
    std::span<const objects::ObservedKeyframe> keyframes) {
  std::vector<Cluster> clusters;
  for (const PlacedBox& box : placed_boxes(keyframes)) {
    Cluster* nearest = nullptr;
    double distance_m = kReach_m;
    for (Cluster& cluster : clusters) {
      if (cluster.class_name != box.detection->class_name) continue;
      const double to_mean_m = (cluster.mean_world() - box.place_world).norm();
      if (to_mean_m > distance_m) continue;
      distance_m = to_mean_m;
      nearest = &cluster;
    }
    if (nearest == nullptr) {
      nearest = &clusters.emplace_back();
      nearest->class_name = box.detection->class_name;
    }
    nearest->best_score = std::max(nearest->best_score, box.detection->score);
    nearest->keyframes.insert(box.keyframe);
    nearest->sum_world += box.place_world;
    ++nearest->boxes;
  }
  std::vector<evaluation::FoundObject> found;
  for (const Cluster& cluster : clusters) {
    if (cluster.keyframes.size() < kMinKeyframes || cluster.best_score < kMinBestScore) continue;
    found.push_back({cluster.class_name, cluster.mean_world()});
  }
  return found;
}

}  // namespace roomwise::trials
