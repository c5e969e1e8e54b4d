#include "roomwise/motion/view_pattern.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "roomwise/motion/view_agreement.h"

namespace roomwise::motion {
namespace {

constexpr double kPlain = 128;

// Sums of a value over rectangles of pixels, each from four corners.
class RectangleSums {
 public:
  template <typename Value>
  RectangleSums(int width, int height, const Value& value)
      : stride_(static_cast<std::size_t>(width) + 1),
        sums_(stride_ * (static_cast<std::size_t>(height) + 1)) {
    for (int y = 0; y < height; ++y) {
      std::int64_t row = 0;
      for (int x = 0; x < width; ++x) {
        row += value(x, y);
        sums_[index(x + 1, y + 1)] = sums_[index(x + 1, y)] + row;
      }
    }
  }
  // Without the right column and the bottom row.
  [[nodiscard]] std::int64_t between(int left, int top, int right, int bottom) const {
    return sums_[index(right, bottom)] - sums_[index(left, bottom)] - sums_[index(right, top)] +
           sums_[index(left, top)];
  }

 private:
  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * stride_ + static_cast<std::size_t>(x);
  }

  std::size_t stride_;
  std::vector<std::int64_t> sums_;
};

image::GrayImage normalize_contrast(const image::GrayImage& gray) {
  constexpr int kAround = 16;        // the mean is over an eighth of the width
  constexpr double kNoise = 6;       // grey levels; less contrast than this is noise
  constexpr double kDeviation = 50;  // what a pixel one standard deviation brighter gets
  const int width = gray.width(), height = gray.height();
  const int reach = std::max(1, width / kAround);
  const auto value = [&](int x, int y) { return std::int64_t{gray.at(x, y)}; };
  const RectangleSums sums(width, height, value);
  const RectangleSums squares(width, height,
                              [&](int x, int y) { return value(x, y) * value(x, y); });
  image::GrayImage even(width, height);
  for (int y = 0; y < height; ++y) {
    const int top = std::max(y - reach, 0), bottom = std::min(y + reach + 1, height);
    for (int x = 0; x < width; ++x) {
      const int left = std::max(x - reach, 0), right = std::min(x + reach + 1, width);
      const double count = (right - left) * (bottom - top);
      const auto mean_of = [&](const RectangleSums& all) {
        return static_cast<double>(all.between(left, top, right, bottom)) / count;
      };
      const double mean = mean_of(sums);
      const double variance = std::max(0.0, mean_of(squares) - mean * mean);
      const double deviation = (gray.at(x, y) - mean) / std::sqrt(variance + kNoise * kNoise);
      even.at(x, y) = static_cast<std::uint8_t>(
          std::lround(std::clamp(kPlain + kDeviation * deviation, 0.0, 255.0)));
    }
  }
  return even;
}

}  // namespace

ViewPattern ViewPattern::of(const RgbdPyramid& view) {
  if (view.empty()) return {};
  return {normalize_contrast(compared_level(view).gray)};
}

double PatternCorrelation::value() const {
  if (pixels == 0) return 0;
  constexpr double kNoise = 8;  // of an even image
  const double noise = pixels * kNoise * kNoise;
  return products / std::sqrt((reference_squares + noise) * (current_squares + noise));
}

PatternCorrelation& PatternCorrelation::operator+=(const PatternCorrelation& other) {
  products += other.products;
  reference_squares += other.reference_squares;
  current_squares += other.current_squares;
  pixels += other.pixels;
  return *this;
}

PatternCorrelation compare_patterns(const RgbdPyramid& reference_view,
                                    const ViewPattern& reference_pattern,
                                    const RgbdPyramid& current_view,
                                    const ViewPattern& current_pattern,
                                    const geometry::RigidTransform& reference_from_current) {
  PatternCorrelation pattern_correlation;
  if (reference_view.empty() || current_view.empty()) return pattern_correlation;
  const PyramidLevel& current = compared_level(current_view);
  for_each_correspondence(
      compared_level(reference_view), current, reference_from_current,
      [&](const Correspondence& pair) {
        const std::uint16_t depth = current.depth.at(pair.column, pair.row);
        if (depth == 0) return;
        const double distance_m = depth / current.camera.depth_units_per_metre - pair.point.z();
        if (std::abs(distance_m) > same_surface_m(pair.point.z())) return;
        const double a = reference_pattern.even.at(pair.x, pair.y) - kPlain;
        const double b = current_pattern.even.at(pair.column, pair.row) - kPlain;
        pattern_correlation.products += a * b;
        pattern_correlation.reference_squares += a * a;
        pattern_correlation.current_squares += b * b;
        ++pattern_correlation.pixels;
      });
  return pattern_correlation;
}

}  // namespace roomwise::motion
