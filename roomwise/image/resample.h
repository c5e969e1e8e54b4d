#pragma once

#include "roomwise/image/image.h"

namespace roomwise::image {

// Luma of BT.601 (0.299 R + 0.587 G + 0.114 B), rounded.
[[nodiscard]] GrayImage to_gray(const ColorImage& image);

// Another size by the mean of the pixels that each new pixel covers (weighted by the covered part)
// where the image shrinks, and by bilinear interpolation where it grows. width, height > 0.
[[nodiscard]] ColorImage resize(const ColorImage& image, int width, int height);

// A part of a picture by its edges, px: pixel (0, 0) is the square from 0 to 1.
struct PictureArea {
  double left = 0, top = 0, right = 0, bottom = 0;
};
// The same of a part alone, which need not begin or end between pixels; where it leaves the picture
// its border goes on. The part must have a width and a height.
[[nodiscard]] ColorImage resize(const ColorImage& image, const PictureArea& part, int width,
                                int height);

// The part of the image from (x, y) of the given size, which must lie inside it.
[[nodiscard]] ColorImage crop(const ColorImage& image, int x, int y, int width, int height);

// Left and right exchanged.
[[nodiscard]] ColorImage mirror(const ColorImage& image);

}  // namespace roomwise::image
