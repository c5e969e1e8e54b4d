#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "roomwise/image/image.h"

namespace roomwise::features {

// Sums of all pixels above and left of a corner (Crow 1984), from which the sum over any upright
// box takes four look-ups whatever its size.
//
// Sums are kept modulo 2^32. Differences of them are exact for every box of at most 16 million
// pixels (2^32 / 255), however large the picture is.
class IntegralImage {
 public:
  explicit IntegralImage(const image::GrayImage& image);

  // Of the picture, pixels.
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }

  // row(y)[x]: the sum of the pixels in columns [0, x) and rows [0, y); 0 <= x <= width and
  // 0 <= y <= height.
  [[nodiscard]] const std::uint32_t* row(int y) const {
    return sums_.data() + static_cast<std::size_t>(y) * stride_;
  }

  // The sum of the pixels in columns [left, right) and rows [top, bottom). What lies outside the
  // picture counts as 0; a box without pixels has the sum 0.
  [[nodiscard]] std::uint32_t box_sum(int left, int top, int right, int bottom) const;

 private:
  int width_;
  int height_;
  std::size_t stride_;
  std::vector<std::uint32_t> sums_;
};

}  // namespace roomwise::features
