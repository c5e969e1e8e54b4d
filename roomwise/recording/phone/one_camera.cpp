#include "roomwise/recording/phone/one_camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "roomwise/image/resample.h"

namespace roomwise::recording {
namespace {

using geometry::PinholeCamera;
using image::DepthImage;

double median(std::span<const PinholeCamera> cameras, double PinholeCamera::*value) {
  std::vector<double> values;
  for (const PinholeCamera& camera : cameras) values.push_back(camera.*value);
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

// Where the pixels of a line of `to` lie in one of `from`, which looks the same way: px, pixel i
// from i - 0.5 to i + 0.5.
struct Axis {
  double first = 0, step = 1;

  [[nodiscard]] double at(double pixel) const { return first + step * pixel; }
};
Axis axis(double from_f, double from_c, double to_f, double to_c) {
  const double step = from_f / to_f;
  return {from_c - step * to_c, step};
}

// The measurements around a place between them: of columns x and x + 1, rows y and y + 1.
struct Cell {
  std::array<std::uint16_t, 4> depths{};  // left and right above, left and right below
  double right = 0, below = 0;            // parts, 0 to 1

  // Depths of one surface differ by less than its slope can make them; where it is seen at more
  // than some 80 degrees, it counts as an edge.
  [[nodiscard]] bool is_one_surface() const {
    constexpr double kMaxRatio = 1.06;
    const auto nearest = *std::ranges::min_element(depths);
    const auto farthest = *std::ranges::max_element(depths);
    return nearest > 0 && farthest < kMaxRatio * nearest;
  }
  // Of a plane the inverse depth is linear in the picture: 1 / (a/A + b/B + c/C + d/D), with one
  // division.
  [[nodiscard]] double on_plane() const {
    const double a = depths[0], b = depths[1], c = depths[2], d = depths[3];
    const double above = (1 - right) * b + right * a, under = (1 - right) * d + right * c;
    return a * b * c * d / ((1 - below) * above * c * d + below * under * a * b);
  }
};

Cell cell_at(const DepthImage& depth, double x, double y) {
  const int left = std::min(static_cast<int>(std::max(x, 0.0)), std::max(depth.width() - 2, 0));
  const int top = std::min(static_cast<int>(std::max(y, 0.0)), std::max(depth.height() - 2, 0));
  const int right = std::min(left + 1, depth.width() - 1);
  const int bottom = std::min(top + 1, depth.height() - 1);
  return {
      {depth.at(left, top), depth.at(right, top), depth.at(left, bottom), depth.at(right, bottom)},
      std::clamp(x - left, 0.0, 1.0),
      std::clamp(y - top, 0.0, 1.0)};
}

}  // namespace

PinholeCamera in_size(const PinholeCamera& camera, int width, int height) {
  const double x = 1.0 * width / camera.width;
  const double y = 1.0 * height / camera.height;
  PinholeCamera other = camera;
  other.fx *= x;
  other.fy *= y;
  other.cx = (camera.cx + 0.5) * x - 0.5;
  other.cy = (camera.cy + 0.5) * y - 0.5;
  other.width = width;
  other.height = height;
  return other;
}

PinholeCamera depth_camera(const PinholeCamera& camera, int width, int height) {
  PinholeCamera other = in_size(camera, width, height);
  other.cx = camera.cx * width / camera.width;
  other.cy = camera.cy * height / camera.height;
  return other;
}

bool has_shape_of(const PinholeCamera& camera, int width, int height) {
  const std::int64_t across = std::int64_t{width} * camera.height;
  const std::int64_t down = std::int64_t{height} * camera.width;
  // A pixel of the smaller of both.
  return std::abs(across - down) <= std::max({camera.width, camera.height, width, height});
}

std::size_t first_of_most(std::span<const PictureSize> sizes) {
  const auto most = std::ranges::max_element(
      sizes, {}, [&](const PictureSize& size) { return std::ranges::count(sizes, size); });
  return static_cast<std::size_t>(most - sizes.begin());
}

PinholeCamera common_camera(std::span<const PinholeCamera> cameras, int max_side_px) {
  PinholeCamera camera = cameras.front();
  for (const auto value :
       {&PinholeCamera::fx, &PinholeCamera::fy, &PinholeCamera::cx, &PinholeCamera::cy}) {
    camera.*value = median(cameras, value);
  }
  const double scale = std::min(1.0, 1.0 * max_side_px / std::max(camera.width, camera.height));
  const auto scaled = [&](int side) {
    return std::max(1, static_cast<int>(std::lround(scale * side)));
  };
  return in_size(camera, scaled(camera.width), scaled(camera.height));
}

image::ColorImage as_seen_by(const image::ColorImage& picture, const PinholeCamera& from,
                             const PinholeCamera& to) {
  const Axis x = axis(from.fx, from.cx, to.fx, to.cx);
  const Axis y = axis(from.fy, from.cy, to.fy, to.cy);
  const image::PictureArea part{x.at(-0.5) + 0.5, y.at(-0.5) + 0.5, x.at(to.width - 0.5) + 0.5,
                                y.at(to.height - 0.5) + 0.5};
  return image::resize(picture, part, to.width, to.height);
}

DepthImage as_seen_by(const DepthImage& depth, const PinholeCamera& from, const PinholeCamera& to) {
  const Axis x_axis = axis(from.fx, from.cx, to.fx, to.cx);
  const Axis y_axis = axis(from.fy, from.cy, to.fy, to.cy);
  const auto is_seen = [](double place, int size) { return place >= -0.5 && place < size - 0.5; };
  DepthImage seen(to.width, to.height);
  for (int y = 0; y < to.height; ++y) {
    const double from_y = y_axis.at(y);
    for (int x = 0; x < to.width; ++x) {
      const double from_x = x_axis.at(x);
      if (!is_seen(from_x, depth.width()) || !is_seen(from_y, depth.height())) continue;
      const Cell cell = cell_at(depth, from_x, from_y);
      if (!cell.is_one_surface()) continue;
      seen.at(x, y) = static_cast<std::uint16_t>(cell.on_plane() + 0.5);
    }
  }
  return seen;
}

}  // namespace roomwise::recording
