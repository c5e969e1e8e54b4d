#include "roomwise/objects/changes/point_votes.h"

#include <algorithm>
#include <cmath>

namespace roomwise::objects {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

// What depth and poses err by: this, and this part of the distance.
constexpr double kMargin_m = 0.04;
constexpr double kMarginOfDistance = 0.015;
constexpr double kNearestLook_m = 0.3, kFarthest_m = 4.5;
// How far from its pixel a point may be found, px of the camera's picture: poses err.
constexpr int kAround_px = 8;

enum class Verdict { kNothing, kSeen, kLookedThrough };

// Whether the lens model holds there: far aside of the picture it may lead back into it.
bool is_near_picture(const Vector3d& point, const geometry::PinholeCamera& camera) {
  const Eigen::Vector2d pixel = camera.project_undistorted(point);
  return std::abs(pixel.x() - 0.5 * camera.width) < camera.width &&
         std::abs(pixel.y() - 0.5 * camera.height) < camera.height;
}

Verdict verdict(const Vector3d& point, const DepthView& view) {  // in the camera's frame
  if (!(point.z() >= kNearestLook_m && point.z() <= kFarthest_m)) return Verdict::kNothing;
  if (!is_near_picture(point, *view.camera)) return Verdict::kNothing;
  const Eigen::Vector2d pixel = view.camera->project(point);
  const int around = kAround_px / view.step_px;
  const int stride = std::max(1, around / 2);
  const int x = static_cast<int>(std::floor((pixel.x() + 0.5) / view.step_px));
  const int y = static_cast<int>(std::floor((pixel.y() + 0.5) / view.step_px));
  const double margin_m = kMargin_m + kMarginOfDistance * point.z();
  int measured = 0, behind = 0;
  for (int dy = -around; dy <= around; dy += stride) {
    for (int dx = -around; dx <= around; dx += stride) {
      if (!view.depth->contains(x + dx, y + dy)) return Verdict::kNothing;
      const double seen_m = view.depth->at(x + dx, y + dy) / view.camera->depth_units_per_metre;
      if (seen_m <= 0) continue;
      ++measured;
      if (std::abs(seen_m - point.z()) <= margin_m) return Verdict::kSeen;
      if (seen_m > point.z()) ++behind;
    }
  }
  return measured > 0 && behind == measured ? Verdict::kLookedThrough : Verdict::kNothing;
}

}  // namespace

PointVotes count_votes(std::span<const Vector3f> points_world, std::span<const DepthView> views) {
  PointVotes votes{
      std::vector<int>(points_world.size()), std::vector<int>(points_world.size()), {}};
  for (const DepthView& view : views) {
    const geometry::RigidTransform camera_from_world = view.world_from_camera.inverse();
    std::size_t& decided = votes.decided_by_view.emplace_back(0);
    for (std::size_t i = 0; i < points_world.size(); ++i) {
      const Verdict says = verdict(camera_from_world * points_world[i].cast<double>(), view);
      if (says == Verdict::kSeen) ++votes.seen[i];
      if (says == Verdict::kLookedThrough) ++votes.through[i];
      if (says != Verdict::kNothing) ++decided;
    }
  }
  return votes;
}

PointVotes count_votes(std::span<const Vector3f> points_world, std::span<const DepthView> views,
                       ThreadPool& pool) {
  constexpr std::size_t kPart = 4096;  // points
  const std::size_t parts = (points_world.size() + kPart - 1) / kPart;
  std::vector<PointVotes> of_parts(parts);
  pool.parallel_for(parts, [&](std::size_t part) {
    const std::size_t first = part * kPart;
    of_parts[part] = count_votes(
        points_world.subspan(first, std::min(kPart, points_world.size() - first)), views);
  });
  PointVotes votes{{}, {}, std::vector<std::size_t>(views.size())};
  for (const PointVotes& part : of_parts) {
    votes.seen.insert(votes.seen.end(), part.seen.begin(), part.seen.end());
    votes.through.insert(votes.through.end(), part.through.begin(), part.through.end());
    for (std::size_t v = 0; v < views.size(); ++v) {
      votes.decided_by_view[v] += part.decided_by_view[v];
    }
  }
  return votes;
}

}  // namespace roomwise::objects
