#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include "roomwise/base/color.h"

namespace roomwise::image {

// A picture that owns its pixels: row after row from the top, without padding. at(x, y): x right, y
// down.
template <typename Pixel>
class Image {
 public:
  Image() = default;
  Image(int width, int height, Pixel fill = {})
      : width_(width),
        height_(height),
        pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), fill) {}

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] bool empty() const { return pixels_.empty(); }
  [[nodiscard]] bool contains(int x, int y) const {
    return x >= 0 && y >= 0 && x < width_ && y < height_;
  }

  Pixel& at(int x, int y) { return pixels_[offset(x, y)]; }
  const Pixel& at(int x, int y) const { return pixels_[offset(x, y)]; }
  std::span<Pixel> row(int y) {
    return {pixels_.data() + offset(0, y), static_cast<std::size_t>(width_)};
  }
  std::span<const Pixel> row(int y) const {
    return {pixels_.data() + offset(0, y), static_cast<std::size_t>(width_)};
  }
  std::span<Pixel> pixels() { return pixels_; }
  std::span<const Pixel> pixels() const { return pixels_; }

  friend bool operator==(const Image&, const Image&) = default;

 private:
  [[nodiscard]] std::size_t offset(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(x);
  }
  int width_ = 0;
  int height_ = 0;
  std::vector<Pixel> pixels_;
};

using ColorImage = Image<Rgb8>;
using GrayImage = Image<std::uint8_t>;
// Distances along the optical axis in the camera's depth_units_per_metre; 0 where nothing was
// measured.
using DepthImage = Image<std::uint16_t>;

}  // namespace roomwise::image
