#include "roomwise/motion/rgbd_pyramid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>

namespace roomwise::motion {
namespace {

constexpr double kUnitsPerMetre = 1000;
constexpr int kMaxShrink = 8;

// A camera whose pixels are `shrink` times as large: the centre of its first pixel is the middle of
// the first shrink x shrink block.
geometry::PinholeCamera shrunk(const geometry::PinholeCamera& camera, int shrink) {
  geometry::PinholeCamera small = camera;
  const double middle = 0.5 * (shrink - 1);
  small.fx /= shrink;
  small.fy /= shrink;
  small.cx = (camera.cx - middle) / shrink;
  small.cy = (camera.cy - middle) / shrink;
  small.width /= shrink;
  small.height /= shrink;
  small.distortion = {};
  small.depth_units_per_metre = kUnitsPerMetre;
  return small;
}

// Depths further from the middle of a block than this part of it are another surface.
constexpr double kSameSurface = 0.03;

// The mean of the depths near their median; 0 where near and far are mixed evenly. Reorders the
// values, of which there must be some.
double middle_depth(std::span<std::uint16_t> measured) {
  const auto middle = measured.begin() + static_cast<std::ptrdiff_t>(measured.size() / 2);
  std::nth_element(measured.begin(), middle, measured.end());
  const double median = *middle;
  double sum = 0;
  std::size_t count = 0;
  for (const std::uint16_t value : measured) {
    if (std::abs(value - median) > kSameSurface * median) continue;
    sum += value;
    ++count;
  }
  return 4 * count < 3 * measured.size() ? 0 : sum / static_cast<double>(count);
}

// Where the blocks lie that the small pixels see, by their top left pixel.
struct BlockPlaces {
  BlockPlaces(const geometry::PinholeCamera& camera, const geometry::PinholeCamera& small,
              int shrink)
      : camera_(camera), small_(small), shrink_(shrink) {}

  [[nodiscard]] std::array<int, 2> at(int x, int y) const {
    if (camera_.distortion.is_none()) return {x * shrink_, y * shrink_};
    const double middle = 0.5 * (shrink_ - 1);
    const Eigen::Vector2d pixel = camera_.project(small_.unproject_undistorted({x, y}, 1));
    return {static_cast<int>(std::lround(pixel.x() - middle)),
            static_cast<int>(std::lround(pixel.y() - middle))};
  }

 private:
  const geometry::PinholeCamera& camera_;
  const geometry::PinholeCamera& small_;
  int shrink_;
};

PyramidLevel shrink_images(const image::GrayImage& gray, const image::DepthImage& depth,
                           const geometry::PinholeCamera& camera, int shrink, double farthest_m) {
  PyramidLevel level{shrunk(camera, shrink), {}, {}};
  level.gray = image::GrayImage(level.camera.width, level.camera.height);
  level.depth = image::DepthImage(level.camera.width, level.camera.height);
  const BlockPlaces places(camera, level.camera, shrink);
  const double to_mm = kUnitsPerMetre / camera.depth_units_per_metre;
  const double farthest = std::min(farthest_m * kUnitsPerMetre, 65535.0);
  std::array<std::uint16_t, kMaxShrink * kMaxShrink> measured;
  for (int y = 0; y < level.camera.height; ++y) {
    for (int x = 0; x < level.camera.width; ++x) {
      const auto [left, top] = places.at(x, y);
      int brightness = 0;
      int pixels = 0;
      std::uint32_t sum = 0;
      std::uint16_t nearest = 65535;
      std::uint16_t furthest = 0;
      std::size_t count = 0;
      for (int v = std::max(top, 0); v < std::min(top + shrink, gray.height()); ++v) {
        for (int u = std::max(left, 0); u < std::min(left + shrink, gray.width()); ++u) {
          brightness += gray.at(u, v);
          ++pixels;
          const std::uint16_t value = depth.at(u, v);
          if (value == 0) continue;
          measured[count++] = value;
          sum += value;
          nearest = std::min(nearest, value);
          furthest = std::max(furthest, value);
        }
      }
      if (pixels == 0) continue;
      level.gray.at(x, y) = static_cast<std::uint8_t>((brightness + pixels / 2) / pixels);
      if (count == 0 || 2 * count < static_cast<std::size_t>(pixels)) continue;
      const double mean = sum / static_cast<double>(count);
      const double middle = furthest - nearest <= kSameSurface * mean
                                ? mean
                                : middle_depth(std::span(measured).first(count));
      if (middle * to_mm <= farthest)
        level.depth.at(x, y) = static_cast<std::uint16_t>(std::lround(middle * to_mm));
    }
  }
  return level;
}

}  // namespace

bool RgbdPyramid::has_depth(double min_share) const {
  if (empty()) return false;
  const auto& pixels = levels.back().depth.pixels();
  const auto measured = std::ranges::count_if(pixels, [](std::uint16_t mm) { return mm > 0; });
  return static_cast<double>(measured) >= min_share * static_cast<double>(pixels.size());
}

Expected<void> RgbdPyramidOptions::validate() const {
  if (shrink < 1 || shrink > kMaxShrink)
    return fail("shrink = {} must be from 1 to {}", shrink, kMaxShrink);
  if (levels < 1) return fail("levels = {} must be at least 1", levels);
  if (!(farthest_m > 0)) return fail("farthest_m = {} must be positive", farthest_m);
  return {};
}

RgbdPyramid make_rgbd_pyramid(const image::GrayImage& gray, const image::DepthImage& depth,
                              const geometry::PinholeCamera& camera,
                              const RgbdPyramidOptions& options) {
  RgbdPyramid view;
  view.levels.push_back(shrink_images(gray, depth, camera, options.shrink, options.farthest_m));
  for (int i = 1; i < options.levels; ++i) {
    const PyramidLevel& larger = view.levels.back();
    view.levels.push_back(
        shrink_images(larger.gray, larger.depth, larger.camera, 2, options.farthest_m));
  }
  return view;
}

}  // namespace roomwise::motion
