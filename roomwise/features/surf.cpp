#include "roomwise/features/surf.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "roomwise/features/integral_image.h"
#include "roomwise/features/keypoint_selection.h"
#include "roomwise/features/surf_detector.h"

namespace roomwise::features {

Expected<void> SurfOptions::validate() const {
  if (!(hessian_threshold >= 0 && std::isfinite(hessian_threshold))) {
    return fail("SURF's hessian_threshold is {}; it must be at least 0", hessian_threshold);
  }
  if (octaves < 1 || octaves > 5) return fail("SURF's octaves are {}; give 1 to 5", octaves);
  if (intervals < 3 || intervals > 8) {
    return fail("SURF's intervals are {}; give 3 to 8", intervals);
  }
  if (initial_step < 1 || initial_step > 16) {
    return fail("SURF's initial_step is {} px; give 1 to 16", initial_step);
  }
  if (!(most_edge_ratio == 0 || (most_edge_ratio >= 1 && std::isfinite(most_edge_ratio)))) {
    return fail("SURF's most_edge_ratio is {}; give 0 (no limit), or 1 or more", most_edge_ratio);
  }
  if (most_keypoints < 0) {
    return fail("SURF's most_keypoints is {}; give 0 (all) or more", most_keypoints);
  }
  if (spread_cells < 0 || spread_cells > 100) {
    return fail("SURF's spread_cells is {}; give 0 (no grid) to 100", spread_cells);
  }
  return {};
}

SurfExtractor::SurfExtractor(const SurfOptions& options) : options_(options) {
  if (const auto valid = options.validate(); !valid) {
    throw std::invalid_argument(valid.error().message);
  }
}

Features SurfExtractor::extract(const image::GrayImage& image) const {
  constexpr float kWindow = 20;  // side of the descriptor's window over the scale
  const IntegralImage integral(image);
  std::vector<Keypoint> keypoints;
  for (const Blob& blob : find_blobs(integral, options_)) {
    Keypoint& keypoint = keypoints.emplace_back();
    keypoint.position_px = blob.position_px;
    keypoint.size_px = kWindow * blob.scale;
    keypoint.response = blob.response;
    keypoint.bright = blob.bright;
  }
  if (options_.most_keypoints > 0) {
    const auto most = static_cast<std::size_t>(options_.most_keypoints);
    keypoints = select_keypoints(std::move(keypoints), most, image.width(), image.height(),
                                 options_.spread_cells);
  } else {
    sort_strongest_first(keypoints);
  }

  RealDescriptors descriptors(keypoints.size(), SurfDescriptor::kValues);
  for (std::size_t i = 0; i < keypoints.size(); ++i) {
    Keypoint& keypoint = keypoints[i];
    const float x_px = keypoint.position_px.x();
    const float y_px = keypoint.position_px.y();
    const float scale = keypoint.size_px / kWindow;
    if (!options_.upright) {
      keypoint.angle_rad = descriptor_.orientation_rad(integral, x_px, y_px, scale);
    }
    descriptor_.describe(
        integral, x_px, y_px, scale, keypoint.angle_rad,
        std::span<float, SurfDescriptor::kValues>(
            descriptors.row(static_cast<Eigen::Index>(i)).data(), SurfDescriptor::kValues));
  }
  return {std::move(keypoints), std::move(descriptors)};
}

}  // namespace roomwise::features
