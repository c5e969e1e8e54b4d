#pragma once

#include <Eigen/Geometry>

#include "roomwise/image/image.h"

namespace roomwise::evaluation {

// The picture, no wider than `width_px`, with a frame around a box of its own pixels, yellow
// between black, which stands out from anything. Nothing within the box is covered but at the
// picture's rim. An empty box: no frame.
[[nodiscard]] image::ColorImage framed_picture(const image::ColorImage& picture,
                                               const Eigen::AlignedBox2f& box, int width_px);

}  // namespace roomwise::evaluation
