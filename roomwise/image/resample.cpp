#include "roomwise/image/resample.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace roomwise::image {
namespace {

// One pixel of a line as a weighted sum of old pixels first, first + 1, ... The weights sum to 1.
struct Mix {
  std::size_t first = 0;
  std::vector<float> weights;
};

// The part of each old pixel that the new one covers.
Mix covered_by(double first, int pixel, double scale, int old_size) {
  const double begin = std::max(first + pixel * scale, 0.0);
  const double end = std::min(first + (pixel + 1) * scale, static_cast<double>(old_size));
  if (begin >= end) return {begin > 0 ? static_cast<std::size_t>(old_size - 1) : 0, {1.0F}};
  Mix mix{static_cast<std::size_t>(begin), {}};
  for (int i = static_cast<int>(begin); i < old_size && i < end; ++i) {
    const double part = std::min(end, i + 1.0) - std::max(begin, static_cast<double>(i));
    mix.weights.push_back(static_cast<float>(part / (end - begin)));
  }
  return mix;
}

// The two old pixels whose centres lie on both sides of the new one's; the edge continues.
Mix between(double first, int pixel, double scale, int old_size) {
  const double centre = std::clamp(first + (pixel + 0.5) * scale - 0.5, 0.0, old_size - 1.0);
  const int left = std::min(static_cast<int>(centre), std::max(old_size - 2, 0));
  const auto right_weight = static_cast<float>(centre - left);
  if (old_size == 1) return {0, {1.0F}};
  return {static_cast<std::size_t>(left), {1.0F - right_weight, right_weight}};
}

// Of the old pixels from `first` to `last`.
std::vector<Mix> line_of_mixes(double first, double last, int old_size, int new_size) {
  const double scale = (last - first) / new_size;
  std::vector<Mix> line;
  line.reserve(static_cast<std::size_t>(new_size));
  for (int pixel = 0; pixel < new_size; ++pixel) {
    line.push_back(scale > 1 ? covered_by(first, pixel, scale, old_size)
                             : between(first, pixel, scale, old_size));
  }
  return line;
}

using RgbSum = std::array<float, 3>;

std::uint8_t rounded(float value) {
  return static_cast<std::uint8_t>(std::clamp(value + 0.5F, 0.0F, 255.0F));
}

}  // namespace

GrayImage to_gray(const ColorImage& image) {
  GrayImage gray(image.width(), image.height());
  // In whole numbers, exact: 299 R + 587 G + 114 B is at most 255,000.
  std::ranges::transform(image.pixels(), gray.pixels().begin(), [](Rgb8 pixel) {
    return static_cast<std::uint8_t>((299 * pixel.r + 587 * pixel.g + 114 * pixel.b + 500) / 1000);
  });
  return gray;
}

ColorImage resize(const ColorImage& image, int width, int height) {
  return resize(image, {0, 0, 1.0 * image.width(), 1.0 * image.height()}, width, height);
}

ColorImage resize(const ColorImage& image, const PictureArea& part, int width, int height) {
  const bool has_pixels = part.left < part.right && part.top < part.bottom;
  if (image.empty() || width <= 0 || height <= 0 || !has_pixels) {
    throw std::invalid_argument("resize: no pixels");
  }
  const auto columns = line_of_mixes(part.left, part.right, image.width(), width);
  const auto rows = line_of_mixes(part.top, part.bottom, image.height(), height);

  // Row by row: the old rows that a new row needs are first mixed into one, then its pixels.
  ColorImage resized(width, height);
  std::vector<RgbSum> mixed_row(static_cast<std::size_t>(image.width()));
  for (int y = 0; y < height; ++y) {
    std::ranges::fill(mixed_row, RgbSum{});
    const Mix& row = rows[static_cast<std::size_t>(y)];
    for (std::size_t i = 0; i < row.weights.size(); ++i) {
      const float weight = row.weights[i];
      const auto old_row = image.row(static_cast<int>(row.first + i));
      for (std::size_t x = 0; x < old_row.size(); ++x) {
        mixed_row[x][0] += weight * static_cast<float>(old_row[x].r);
        mixed_row[x][1] += weight * static_cast<float>(old_row[x].g);
        mixed_row[x][2] += weight * static_cast<float>(old_row[x].b);
      }
    }
    const auto new_row = resized.row(y);
    for (std::size_t x = 0; x < new_row.size(); ++x) {
      RgbSum sum{};
      for (std::size_t i = 0; i < columns[x].weights.size(); ++i) {
        const RgbSum& old = mixed_row[columns[x].first + i];
        for (std::size_t c = 0; c < sum.size(); ++c) sum[c] += columns[x].weights[i] * old[c];
      }
      new_row[x] = {rounded(sum[0]), rounded(sum[1]), rounded(sum[2])};
    }
  }
  return resized;
}

ColorImage crop(const ColorImage& image, int x, int y, int width, int height) {
  if (x < 0 || y < 0 || width <= 0 || height <= 0 || width > image.width() - x ||
      height > image.height() - y) {
    throw std::invalid_argument("crop: not inside the image");
  }
  ColorImage part(width, height);
  for (int row = 0; row < height; ++row) {
    const auto from = image.row(y + row).subspan(static_cast<std::size_t>(x), part.row(row).size());
    std::ranges::copy(from, part.row(row).begin());
  }
  return part;
}

ColorImage mirror(const ColorImage& image) {
  ColorImage mirrored = image;
  for (int y = 0; y < mirrored.height(); ++y) std::ranges::reverse(mirrored.row(y));
  return mirrored;
}

}  // namespace roomwise::image
