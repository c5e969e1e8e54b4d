#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "roomwise/base/simd.h"
#include "roomwise/image/image.h"

namespace roomwise::features {

// Sums of all pixels above and left of a corner (Crow 1984), from which the sum over any upright
// box takes four look-ups whatever its size.
//
// Sums are kept modulo 2^32. Differences of them are exact for every box whose own sum fits: of at
// most 16 million pixels of 8 bits (2^32 / 255), however large the picture is.
class IntegralImage {
 public:
  static constexpr std::size_t kTailPadding = 16;

  IntegralImage() = default;
  explicit IntegralImage(const image::GrayImage& image);

  // Makes room for a picture of this size; its rows are then given from the top with set_row(),
  // each once. Memory is kept from one picture to the next.
  void reset(int width, int height);
  // pixels: row y, `width` values.
  void set_row(int y, std::span<const std::uint16_t> pixels, Simd simd);

  // Of the picture, pixels.
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  // From one row of sums to the next.
  [[nodiscard]] std::size_t stride() const { return stride_; }

  // row(y)[x]: the sum of the pixels in columns [0, x) and rows [0, y); 0 <= x <= width and
  // 0 <= y <= height. Up to kTailPadding values beyond the end of a row may be read; they mean
  // nothing.
  [[nodiscard]] const std::uint32_t* row(int y) const { return sums_.data() + offset(y); }

  // The sum of the pixels in columns [left, right) and rows [top, bottom). What lies outside the
  // picture counts as 0; a box without pixels has the sum 0.
  [[nodiscard]] std::uint32_t box_sum(int left, int top, int right, int bottom) const;

 private:
  [[nodiscard]] std::size_t offset(int y) const { return static_cast<std::size_t>(y) * stride_; }

  int width_ = 0;
  int height_ = 0;
  std::size_t stride_ = 0;
  std::vector<std::uint32_t> sums_;
};

}  // namespace roomwise::features
