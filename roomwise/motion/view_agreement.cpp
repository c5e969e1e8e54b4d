#include "roomwise/motion/view_agreement.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace roomwise::motion {
namespace {

using geometry::RigidTransform;

// Fine enough, and quick.
const ViewLevel& second_level(const SmallView& view) {
  return view.levels[std::min<std::size_t>(1, view.levels.size() - 1)];
}

}  // namespace

ViewAgreement compare_views(const SmallView& reference_view, const SmallView& current_view,
                            const RigidTransform& reference_from_current) {
  if (reference_view.empty() || current_view.empty()) return {};
  const ViewLevel& reference = second_level(reference_view);
  const ViewLevel& current = second_level(current_view);
  const RigidTransform current_from_reference = reference_from_current.inverse();
  const geometry::PinholeCamera& camera = current.camera;
  std::size_t measured = 0, compared = 0, agreeing = 0, through = 0, front = 0;
  for (int y = 1; y + 1 < reference.depth.height(); ++y) {
    for (int x = 1; x + 1 < reference.depth.width(); ++x) {
      if (reference.depth.at(x, y) == 0) continue;
      ++measured;
      const Eigen::Vector3d point =
          current_from_reference *
          reference.camera.unproject_undistorted(
              {x, y}, reference.depth.at(x, y) / reference.camera.depth_units_per_metre);
      if (!(point.z() > 0.1)) continue;
      const Eigen::Vector2d pixel = camera.project_undistorted(point);
      const int column = static_cast<int>(std::lround(pixel.x()));
      const int row = static_cast<int>(std::lround(pixel.y()));
      if (column < 1 || row < 1 || column + 1 >= camera.width || row + 1 >= camera.height) continue;
      // The smallest difference within a pixel, so that a steep surface and an edge are given their
      // due.
      std::optional<double> smallest;
      for (int v = row - 1; v <= row + 1; ++v) {
        for (int u = column - 1; u <= column + 1; ++u) {
          if (current.depth.at(u, v) == 0) continue;
          const double difference =
              current.depth.at(u, v) / camera.depth_units_per_metre - point.z();
          if (!smallest || std::abs(difference) < std::abs(*smallest)) smallest = difference;
        }
      }
      if (!smallest) continue;
      ++compared;
      const double tolerance = 0.02 + 0.015 * point.z() * point.z();
      if (std::abs(*smallest) <= tolerance) {
        ++agreeing;
      } else if (*smallest > 0) {
        ++through;
      } else {
        ++front;
      }
    }
  }
  ViewAgreement agreement;
  if (compared == 0) return agreement;
  const auto share = [](std::size_t part, std::size_t whole) {
    return static_cast<double>(part) / static_cast<double>(whole);
  };
  agreement.overlap = share(compared, measured);
  agreement.agreeing = share(agreeing, compared);
  agreement.seen_through = share(through, compared);
  agreement.in_front = share(front, compared);
  return agreement;
}

}  // namespace roomwise::motion
