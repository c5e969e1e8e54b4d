#include "roomwise/objects/own_things/color_likeness.h"

#include <algorithm>
#include <cmath>

namespace roomwise::objects {
namespace {

// From a quarter to four times what grey would have.
constexpr float kWidestLogRatio = 1.4F;
constexpr float kBrightEnough = 24;  // of 255, where noise no longer makes the colour

int bin_of(float log_ratio) {
  const float place = (log_ratio + kWidestLogRatio) / (2 * kWidestLogRatio);
  return std::clamp(static_cast<int>(place * kColorBins), 0, kColorBins - 1);
}

void add_pixel(const Rgb8& pixel, const PictureLight& light, ColorHistogram& shares) {
  const Eigen::Vector3f value(pixel.r, pixel.g, pixel.b);
  if (value.maxCoeff() < kBrightEnough) return;
  const Eigen::Vector3f lit = (value.array() + 1) / light.mean.array();
  const int red = bin_of(std::log(lit.x() / lit.y()));
  const int blue = bin_of(std::log(lit.z() / lit.y()));
  shares[static_cast<std::size_t>(red * kColorBins + blue)] += 1;
}

void normalize(ColorHistogram& shares) {
  float sum = 0;
  for (const float share : shares) sum += share;
  if (sum <= 0) return;
  for (float& share : shares) share /= sum;
}

}  // namespace

PictureLight light_of(const image::ColorImage& picture) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Rgb8& pixel : picture.pixels()) sum += Eigen::Vector3d(pixel.r, pixel.g, pixel.b);
  const auto count = static_cast<double>(std::max<std::size_t>(1, picture.pixels().size()));
  return {((sum / count).array() + 1).cast<float>()};
}

ColorHistogram color_histogram(const image::ColorImage& picture, const image::GrayImage& mask,
                               const PictureLight& light) {
  ColorHistogram shares{};
  for (std::size_t i = 0; i < picture.pixels().size(); ++i) {
    if (mask.pixels()[i] != 0) add_pixel(picture.pixels()[i], light, shares);
  }
  normalize(shares);
  return shares;
}

double color_likeness(const ColorHistogram& a, const ColorHistogram& b) {
  double likeness = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    likeness += static_cast<double>(std::sqrt(a[i] * b[i]));
  return likeness;
}

IntegralColorHistogram::IntegralColorHistogram(const image::ColorImage& picture)
    : columns_(picture.width() / kCell_px + 1),
      rows_(picture.height() / kCell_px + 1),
      sums_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)) {
  const PictureLight light = light_of(picture);
  for (int row = 1; row < rows_; ++row) {
    ColorHistogram line{};
    for (int column = 1; column < columns_; ++column) {
      // One pixel of the cell in two by two: colours of a window need no more.
      for (int y = (row - 1) * kCell_px; y < row * kCell_px; y += 2) {
        for (int x = (column - 1) * kCell_px; x < column * kCell_px; x += 2) {
          add_pixel(picture.at(x, y), light, line);
        }
      }
      const auto at = static_cast<std::size_t>(row * columns_ + column);
      const ColorHistogram& above = sums_[at - static_cast<std::size_t>(columns_)];
      for (std::size_t i = 0; i < line.size(); ++i) sums_[at][i] = above[i] + line[i];
    }
  }
}

ColorHistogram IntegralColorHistogram::shares(const network::PixelBox& box) const {
  const auto cell = [](float edge_px, int cells) {
    return std::clamp(static_cast<int>(std::lround(edge_px / kCell_px)), 0, cells - 1);
  };
  const int left = cell(box.left, columns_), right = cell(box.right, columns_);
  const int top = cell(box.top, rows_), bottom = cell(box.bottom, rows_);
  const auto sum = [&](int column, int row) -> const ColorHistogram& {
    return sums_[static_cast<std::size_t>(row * columns_ + column)];
  };
  ColorHistogram shares{};
  for (std::size_t i = 0; i < shares.size(); ++i) {
    shares[i] = std::max(
        0.F, sum(right, bottom)[i] - sum(left, bottom)[i] - sum(right, top)[i] + sum(left, top)[i]);
  }
  normalize(shares);
  return shares;
}

}  // namespace roomwise::objects
