#pragma once

#include "roomwise/network/vision/detector.h"

namespace roomwise::objects {

// Pictures have pixels. The square about the middle of a box whose sides are `margin` of the box's
// longest, moved and cut to lie in the picture: as much of it as a classifier needs to see what the
// box holds. Whole pixels.
[[nodiscard]] network::PixelBox square_about(const network::PixelBox& box, float margin,
                                             int width_px, int height_px);

}  // namespace roomwise::objects
