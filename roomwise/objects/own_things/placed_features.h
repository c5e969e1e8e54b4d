#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "roomwise/features/feature_extractor.h"
#include "roomwise/network/vision/detector.h"

namespace roomwise::objects {

// A view of a thing found in a picture by its local features.
struct PlacedView {
  std::size_t inliers = 0;                 // matches that agree
  network::PixelBox box;                   // about where the view's outline falls, in the picture
  std::vector<Eigen::Vector2f> places_px;  // of the agreeing key-points in the picture
};

// Where the matches of a view's features agree best: each match tells by its two places, sizes and
// angles how the view would lie in the picture, and the one that most others fit is taken; then an
// affine transform through all that fit. Where fewer than three agree there is nothing. No chance
// is in it: all are tried. Time: the square of the number of matches.
[[nodiscard]] std::optional<PlacedView> verify_view(const features::Features& view, int width_px,
                                                    int height_px,
                                                    const features::Features& picture);

}  // namespace roomwise::objects
