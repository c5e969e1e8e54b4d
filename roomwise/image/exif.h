#pragma once

#include <cstdint>
#include <span>

#include "roomwise/image/image.h"

namespace roomwise::image {

// How a camera was held, as the Exif tag Orientation (0x0112) numbers it: what has to be done to
// the stored picture to show it upright. 1 is nothing; 5 to 8 exchange width and height.
constexpr int kUpright = 1;

// The orientation (1 to 8) in the payload of a JPEG's APP1 segment ("Exif\0\0" and a TIFF header);
// kUpright where there is none or the bytes make no sense: they come from outside, and a photo
// without a usable orientation is still a photo. Source: Exif 2.3 (CIPA DC-008), TIFF 6.0.
[[nodiscard]] int exif_orientation(std::span<const std::uint8_t> app1);

// The picture turned and mirrored upright. orientation: 1 to 8.
[[nodiscard]] ColorImage apply_orientation(ColorImage image, int orientation);

}  // namespace roomwise::image
