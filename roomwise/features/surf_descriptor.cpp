#include "roomwise/features/surf_descriptor.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace roomwise::features {
namespace {

struct Gradient {
  float dx = 0;
  float dy = 0;
};

// Haar wavelets of side 2 * half px around the pixel corner nearest to (x, y); zero where they
// leave the picture. A wavelet of even side is centred on a corner of pixels, and corner (c, r)
// lies at (c - 1/2, r - 1/2) px, so rounding x + 1/2 moves the sample by no more than half a pixel
// to either side, without a bias.
[[gnu::always_inline]] inline Gradient haar(const IntegralImage& integral, float x, float y,
                                            int half) {
  // Cutting off the decimals rounds down what is positive; the rest lies outside either way.
  const int column = static_cast<int>(x + 1);
  const int row = static_cast<int>(y + 1);
  const int left = column - half;
  const int right = column + half;
  const int top = row - half;
  const int bottom = row + half;
  if (left < 0 || top < 0 || right > integral.width() || bottom > integral.height()) return {};
  const std::uint32_t* sums_top = integral.row(top);
  const std::uint32_t* sums_middle = integral.row(row);
  const std::uint32_t* sums_bottom = integral.row(bottom);
  const std::uint32_t left_half =
      sums_bottom[column] - sums_bottom[left] - sums_top[column] + sums_top[left];
  const std::uint32_t upper_half =
      sums_middle[right] - sums_middle[left] - sums_top[right] + sums_top[left];
  const std::uint32_t whole =
      sums_bottom[right] - sums_bottom[left] - sums_top[right] + sums_top[left];
  return {static_cast<float>(static_cast<std::int32_t>(whole - 2 * left_half)),
          static_cast<float>(static_cast<std::int32_t>(whole - 2 * upper_half))};
}

int half_side_px(float side_px) {
  return std::max(1, static_cast<int>(std::lround(side_px / 2)));
}

// The direction of a gradient as a number in [0, 4] that grows with its angle, 1 for each quarter
// turn. A quarter of the arc tangent, by a quadratic good to 0.004 rad: enough to choose a bin.
[[gnu::always_inline]] inline float quarters(const Gradient& gradient) {
  const float x = std::abs(gradient.dx);
  const float y = std::abs(gradient.dy);
  const float least = std::min(x, y);
  const float tangent = least / std::max(std::max(x, y), std::numeric_limits<float>::min());
  const float eighth = tangent * (0.5F + 0.1738F * (1 - tangent));  // 1/2 at the diagonal
  const float quarter = y > x ? 1 - eighth : eighth;
  const float half = gradient.dx < 0 ? 2 - quarter : quarter;
  return gradient.dy < 0 ? 4 - half : half;
}

}  // namespace

SurfDescriptor::SurfDescriptor() {
  constexpr int kRadius = 6;
  constexpr float kDiscSigma = 2;
  for (int y = -kRadius; y <= kRadius; ++y) {
    for (int x = -kRadius; x <= kRadius; ++x) {
      const int squared = x * x + y * y;
      if (squared >= kRadius * kRadius) continue;
      disc_.push_back({static_cast<float>(x), static_cast<float>(y),
                       std::exp(static_cast<float>(-squared) / (2 * kDiscSigma * kDiscSigma))});
    }
  }
  constexpr float kWindowSigma = 3.3F;
  for (int i = 0; i < kSide; ++i) {
    const float offset = static_cast<float>(i) + 0.5F - kSide / 2.0F;
    gaussian_[static_cast<std::size_t>(i)] =
        std::exp(-offset * offset / (2 * kWindowSigma * kWindowSigma));
  }
}

float SurfDescriptor::orientation_rad(const IntegralImage& integral, float x_px, float y_px,
                                      float scale) const {
  // Responses are gathered by direction in narrow bins; a sector is a run of bins. Only the
  // sector's borders are rounded to bins, the sums keep the exact directions.
  constexpr std::size_t kBins = 72;
  constexpr std::size_t kSectorBins = kBins / 6;
  std::array<Gradient, kBins> bins{};
  const int half = half_side_px(4 * scale);
  for (const Sample& sample : disc_) {
    Gradient response = haar(integral, x_px + sample.x * scale, y_px + sample.y * scale, half);
    response.dx *= sample.weight;
    response.dy *= sample.weight;
    Gradient& bin = bins[static_cast<std::size_t>(quarters(response) * (kBins / 4.0F)) % kBins];
    bin.dx += response.dx;
    bin.dy += response.dy;
  }
  // sums_before[i]: of the first i bins, twice round.
  std::array<Gradient, 2 * kBins + 1> sums_before;
  for (std::size_t i = 0; i < 2 * kBins; ++i) {
    sums_before[i + 1] = {sums_before[i].dx + bins[i % kBins].dx,
                          sums_before[i].dy + bins[i % kBins].dy};
  }
  Gradient strongest;
  float most = 0;
  for (std::size_t first = 0; first < kBins; ++first) {
    const Gradient sum{sums_before[first + kSectorBins].dx - sums_before[first].dx,
                       sums_before[first + kSectorBins].dy - sums_before[first].dy};
    const float squared = sum.dx * sum.dx + sum.dy * sum.dy;
    if (squared > most) {
      most = squared;
      strongest = sum;
    }
  }
  return most > 0 ? std::atan2(strongest.dy, strongest.dx) : 0;
}

void SurfDescriptor::describe(const IntegralImage& integral, float x_px, float y_px, float scale,
                              float angle_rad, std::span<float, kValues> values) const {
  constexpr int kSquares = 4;
  constexpr int kSamples = kSide / kSquares;
  std::fill(values.begin(), values.end(), 0.0F);
  const float cos = std::cos(angle_rad);
  const float sin = std::sin(angle_rad);
  const int half = half_side_px(2 * scale);
  for (int j = 0; j < kSide; ++j) {
    const float v = (static_cast<float>(j) + 0.5F - kSide / 2.0F) * scale;
    float* row_of_squares = values.data() + j / kSamples * kSquares * 4;
    for (int i = 0; i < kSide; ++i) {
      const float u = (static_cast<float>(i) + 0.5F - kSide / 2.0F) * scale;
      const Gradient response =
          haar(integral, x_px + cos * u - sin * v, y_px + sin * u + cos * v, half);
      const float weight =
          gaussian_[static_cast<std::size_t>(i)] * gaussian_[static_cast<std::size_t>(j)];
      const float along = weight * (cos * response.dx + sin * response.dy);
      const float across = weight * (cos * response.dy - sin * response.dx);
      float* square = row_of_squares + i / kSamples * 4;
      square[0] += along;
      square[1] += across;
      square[2] += std::abs(along);
      square[3] += std::abs(across);
    }
  }
  float squared = 0;
  for (const float value : values) squared += value * value;
  if (squared <= 0) return;
  const float per_length = 1 / std::sqrt(squared);
  for (float& value : values) value *= per_length;
}

}  // namespace roomwise::features
