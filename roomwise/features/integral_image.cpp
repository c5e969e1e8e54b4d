#include "roomwise/features/integral_image.h"

#include <algorithm>

namespace roomwise::features {

IntegralImage::IntegralImage(const image::GrayImage& image)
    : width_(image.width()),
      height_(image.height()),
      stride_(static_cast<std::size_t>(width_) + 1),
      sums_(stride_ * (static_cast<std::size_t>(height_) + 1)) {
  for (int y = 0; y < height_; ++y) {
    const std::uint8_t* pixels = image.row(y).data();
    const std::uint32_t* above = row(y);
    std::uint32_t* below = sums_.data() + (static_cast<std::size_t>(y) + 1) * stride_;
    std::uint32_t sum_of_row = 0;
    for (int x = 0; x < width_; ++x) {
      sum_of_row += pixels[x];
      below[x + 1] = above[x + 1] + sum_of_row;
    }
  }
}

std::uint32_t IntegralImage::box_sum(int left, int top, int right, int bottom) const {
  left = std::clamp(left, 0, width_);
  right = std::clamp(right, 0, width_);
  top = std::clamp(top, 0, height_);
  bottom = std::clamp(bottom, 0, height_);
  if (left >= right || top >= bottom) return 0;
  return row(bottom)[right] - row(bottom)[left] - row(top)[right] + row(top)[left];
}

}  // namespace roomwise::features
