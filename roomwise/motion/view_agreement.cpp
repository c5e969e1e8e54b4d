#include "roomwise/motion/view_agreement.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace roomwise::motion {

const PyramidLevel& compared_level(const RgbdPyramid& view) {
  return view.levels[std::min<std::size_t>(1, view.levels.size() - 1)];
}

ViewAgreement compare_views(const RgbdPyramid& reference_view, const RgbdPyramid& current_view,
                            const geometry::RigidTransform& reference_from_current) {
  if (reference_view.empty() || current_view.empty()) return {};
  const PyramidLevel& current = compared_level(current_view);
  std::size_t compared = 0, agreeing = 0, through = 0, front = 0;
  const std::size_t measured = for_each_correspondence(
      compared_level(reference_view), current, reference_from_current,
      [&](const Correspondence& pair) {
        // The smallest difference within a pixel, so that a steep surface and an edge are given
        // their due.
        std::optional<double> smallest;
        for (int v = pair.row - 1; v <= pair.row + 1; ++v) {
          for (int u = pair.column - 1; u <= pair.column + 1; ++u) {
            if (current.depth.at(u, v) == 0) continue;
            const double difference =
                current.depth.at(u, v) / current.camera.depth_units_per_metre - pair.point.z();
            if (!smallest || std::abs(difference) < std::abs(*smallest)) smallest = difference;
          }
        }
        if (!smallest) return;
        ++compared;
        if (std::abs(*smallest) <= same_surface_m(pair.point.z())) {
          ++agreeing;
        } else if (*smallest > 0) {
          ++through;
        } else {
          ++front;
        }
      });
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
