#include "roomwise/features/surf_descriptor.h"

#include <algorithm>
#include <cmath>
#include <limits>

#if defined(__x86_64__)
#include <immintrin.h>  // declares the gathering of numbers
#endif

// Vectors are passed only within functions that are always inlined.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace roomwise::features {
namespace {

using Tables = SurfDescriptor::Tables;

[[gnu::always_inline]] inline void absolute(const Float8& value, Float8& result) {
  result = (Float8)((Int8)value & 0x7fffffff);
}
[[gnu::always_inline]] inline void absolute(const Float4& value, Float4& result) {
  result = (Float4)((Int4)value & 0x7fffffff);
}
// Eight numbers, in one vector or in two.
[[gnu::always_inline]] inline float sum_of(const std::array<Float8, 1>& eight) {
  const Float8& v = eight[0];
  return ((v[0] + v[4]) + (v[1] + v[5])) + ((v[2] + v[6]) + (v[3] + v[7]));
}
[[gnu::always_inline]] inline float sum_of(const std::array<Float4, 2>& eight) {
  const Float4 v = eight[0] + eight[1];
  return (v[0] + v[1]) + (v[2] + v[3]);
}

template <Simd simd>
[[gnu::always_inline]] inline void gather(const std::uint32_t* from,
                                          const typename Lanes<simd>::Int& places,
                                          typename Lanes<simd>::UInt& values) {
#if defined(__x86_64__) && !defined(__clang__)
  if constexpr (simd == Simd::kAvx2) {
    // GCC's builtin, since the intrinsic cannot be taken into a template that is not AVX2's own.
    values = (UInt8)__builtin_ia32_gathersiv8si(Int8{}, reinterpret_cast<const int*>(from), places,
                                                ~Int8{}, sizeof *from);
    return;
  }
#endif
  for (int i = 0; i < Lanes<simd>::kCount; ++i) values[i] = from[places[i]];
}

// Haar wavelets of side 2 * half px around the pixel corners nearest to some places; zero where
// they leave the picture. A wavelet of even side is centred on a corner of pixels, and corner (c,
// r) lies at (c - 1/2, r - 1/2) px, so rounding x + 1/2 moves the sample by no more than half a
// pixel to either side, without a bias.
template <Simd simd>
class Haar {
  using Float = typename Lanes<simd>::Float;
  using Int = typename Lanes<simd>::Int;
  using UInt = typename Lanes<simd>::UInt;

 public:
  [[gnu::always_inline]] Haar(const IntegralImage& integral, int half)
      : half_(half),
        last_column_(integral.width() - half),
        last_row_(integral.height() - half),
        stride_(static_cast<std::int32_t>(integral.stride())),
        top_(integral.row(0)),
        middle_(integral.row(half)),
        bottom_(integral.row(2 * half)) {}

  [[gnu::always_inline]] void at(const Float& x, const Float& y, Float& dx, Float& dy) const {
    // Cutting off the decimals rounds down what is positive; the rest lies outside either way.
    const Int column = __builtin_convertvector(x + 1.0F, Int);
    const Int row = __builtin_convertvector(y + 1.0F, Int);
    const Int inside =
        (column >= half_) & (row >= half_) & (column <= last_column_) & (row <= last_row_);
    // Of the wavelet's top left corner; any that can be read where there is none.
    const Int place = ((row - half_) * stride_ + column - half_) & inside;
    UInt top_left, top, top_right, left, right, bottom_left, bottom, bottom_right;
    gather<simd>(top_, place, top_left);
    gather<simd>(top_ + half_, place, top);
    gather<simd>(top_ + 2 * half_, place, top_right);
    gather<simd>(middle_, place, left);
    gather<simd>(middle_ + 2 * half_, place, right);
    gather<simd>(bottom_, place, bottom_left);
    gather<simd>(bottom_ + half_, place, bottom);
    gather<simd>(bottom_ + 2 * half_, place, bottom_right);
    const UInt falling = bottom_right - top_left;
    const UInt rising = top_right - bottom_left;
    const UInt sum_dx = falling - rising + 2 * (top - bottom);
    const UInt sum_dy = falling + rising + 2 * (left - right);
    dx = __builtin_convertvector((Int)sum_dx & inside, Float);
    dy = __builtin_convertvector((Int)sum_dy & inside, Float);
  }

 private:
  int half_, last_column_, last_row_;
  std::int32_t stride_;
  const std::uint32_t *top_, *middle_, *bottom_;
};

int half_side_px(float side_px) {
  return std::max(1, static_cast<int>(std::lround(side_px / 2)));
}

// Directions are sorted into bins; a sector is a run of them. Only the sector's borders are rounded
// to bins, the sums keep the exact directions.
constexpr int kBins = 72;
constexpr int kSectorBins = kBins / 6;

// The bins of gradients: their angle in bins, 0 to kBins. The arc tangent is a quadratic good to
// 0.004 rad: enough to choose a bin.
template <typename Float, typename Int>
[[gnu::always_inline]] inline void find_bins(const Float& dx, const Float& dy, Int& bins) {
  Float x, y;
  absolute(dx, x);
  absolute(dy, y);
  const Int steep = y > x;
  const Float least = steep ? x : y;
  const Float most = steep ? y : x;
  const Float none = Float{} + std::numeric_limits<float>::min();
  const Float tangent = least / (most > none ? most : none);
  const Float eighth = tangent * (0.5F + 0.1738F * (1 - tangent));  // 1/2 at the diagonal
  const Float quarter = steep ? 1 - eighth : eighth;
  const Float half = dx < 0 ? 2 - quarter : quarter;
  const Float quarters = dy < 0 ? 4 - half : half;
  bins = __builtin_convertvector(quarters * (kBins / 4.0F), Int);
}

struct Gradient {
  float dx = 0;
  float dy = 0;
};

// The greatest sum over any sector, from the sums over bins, which are written behind themselves
// for a sector's width, so that sectors run on.
[[gnu::always_inline]] inline Gradient strongest_sector(Gradient* bins) {
  std::array<Gradient, kBins + kSectorBins> two, four;
  for (int i = 0; i < kSectorBins; ++i) bins[kBins + i] = bins[i];
  const auto add = [](const Gradient& a, const Gradient& b) {
    return Gradient{a.dx + b.dx, a.dy + b.dy};
  };
  for (std::size_t i = 0; i + 1 < two.size(); ++i) two[i] = add(bins[i], bins[i + 1]);
  for (std::size_t i = 0; i + 3 < four.size(); ++i) four[i] = add(two[i], two[i + 2]);
  Gradient strongest;
  float most = 0;
  for (std::size_t i = 0; i < kBins; ++i) {
    const Gradient sum = add(add(four[i], four[i + 4]), four[i + 8]);
    const float squared = sum.dx * sum.dx + sum.dy * sum.dy;
    if (squared > most) {
      most = squared;
      strongest = sum;
    }
  }
  return strongest;
}

struct Place {
  float x_px, y_px, scale;
};

template <Simd simd>
[[gnu::always_inline]] inline Gradient orient(const Tables& tables, const IntegralImage& integral,
                                              const Place& place) {
  const Haar<simd> haar(integral, half_side_px(4 * place.scale));
  std::array<Gradient, kBins + kSectorBins> bins{};
  constexpr int kCount = Lanes<simd>::kCount;
  for (std::size_t i = 0; i < tables.disc_x.size(); i += kCount) {
    typename Lanes<simd>::Float x, y, weight, dx, dy;
    load(&tables.disc_x[i], x);
    load(&tables.disc_y[i], y);
    load(&tables.disc_weight[i], weight);
    haar.at(place.x_px + x * place.scale, place.y_px + y * place.scale, dx, dy);
    dx *= weight;
    dy *= weight;
    typename Lanes<simd>::Int bin;
    find_bins(dx, dy, bin);
    bin = bin == kBins ? decltype(bin){} : bin;
    for (int k = 0; k < kCount; ++k) {
      Gradient& sum = bins[static_cast<std::size_t>(bin[k])];
      sum.dx += dx[k];
      sum.dy += dy[k];
    }
  }
  return strongest_sector(bins.data());
}

// dx, dy, |dx| and |dy| along a row of samples, or sums of rows.
template <typename Float>
using SampleRow =
    std::array<std::array<Float, 4>, sizeof(float) * SurfDescriptor::kSide / sizeof(Float)>;

template <Simd simd>
[[gnu::always_inline]] inline void describe_place(const Tables& tables,
                                                  const IntegralImage& integral, const Place& place,
                                                  float cos, float sin, float* values) {
  using Float = typename Lanes<simd>::Float;
  constexpr int kSide = SurfDescriptor::kSide;
  constexpr std::size_t kCount = Lanes<simd>::kCount, kOfEight = 8 / kCount;
  const Haar<simd> haar(integral, half_side_px(2 * place.scale));
  std::array<SampleRow<Float>, SurfDescriptor::kSquares>
      sums{};  // over the rows of each row of squares
  const float cos_step = cos * place.scale, sin_step = sin * place.scale;
  for (int j = 0; j < kSide; ++j) {
    const float v = tables.offset[static_cast<std::size_t>(j)];
    const float x_row = place.x_px - sin_step * v, y_row = place.y_px + cos_step * v;
    // The squares that the row crosses: at most two.
    const int last = std::min(j / SurfDescriptor::kSquareStep, SurfDescriptor::kSquares - 1);
    const int first = j < SurfDescriptor::kSquareSide
                          ? 0
                          : (j - SurfDescriptor::kSquareSide) / SurfDescriptor::kSquareStep + 1;
    for (std::size_t i = 0; i < sums[0].size(); ++i) {
      Float u, window, dx, dy;
      load(&tables.offset[kCount * i], u);
      load(&tables.window[kCount * i], window);
      haar.at(x_row + cos_step * u, y_row + sin_step * u, dx, dy);
      window *= tables.window[static_cast<std::size_t>(j)];
      std::array<Float, 4> samples;
      samples[0] = window * (cos * dx + sin * dy);
      samples[1] = window * (cos * dy - sin * dx);
      absolute(samples[0], samples[2]);
      absolute(samples[1], samples[3]);
      for (int square = first; square <= last; ++square) {
        const auto k = static_cast<std::size_t>(square);
        const float weight = tables.square[k][static_cast<std::size_t>(j)];
        for (std::size_t c = 0; c < 4; ++c) sums[k][i][c] += weight * samples[c];
      }
    }
  }
  for (const SampleRow<Float>& row : sums) {
    for (const auto& square : tables.square) {
      for (std::size_t c = 0; c < 4; ++c) {
        // Every eighth sample apart, however many a vector has.
        std::array<Float, kOfEight> sum{};
        for (std::size_t i = 0; i < row.size(); ++i) {
          Float weight;
          load(&square[kCount * i], weight);
          sum[i % kOfEight] += weight * row[i][c];
        }
        *values++ = sum_of(sum);
      }
    }
  }
}

// The same code for each kind of processor; without fused multiplications both give the same bits.
struct DescriptorKernels {
  Gradient (*orient)(const Tables&, const IntegralImage&, const Place&);
  void (*describe)(const Tables&, const IntegralImage&, const Place&, float, float, float*);
};

Gradient orient_portable(const Tables& tables, const IntegralImage& integral, const Place& place) {
  return orient<Simd::kPortable>(tables, integral, place);
}
void describe_portable(const Tables& tables, const IntegralImage& integral, const Place& place,
                       float cos, float sin, float* values) {
  describe_place<Simd::kPortable>(tables, integral, place, cos, sin, values);
}
constexpr DescriptorKernels kPortableDescriptor{orient_portable, describe_portable};

#if defined(__x86_64__)
__attribute__((target("avx2"))) Gradient orient_avx2(const Tables& tables,
                                                     const IntegralImage& integral,
                                                     const Place& place) {
  return orient<Simd::kAvx2>(tables, integral, place);
}
__attribute__((target("avx2"))) void describe_avx2(const Tables& tables,
                                                   const IntegralImage& integral,
                                                   const Place& place, float cos, float sin,
                                                   float* values) {
  describe_place<Simd::kAvx2>(tables, integral, place, cos, sin, values);
}
constexpr DescriptorKernels kAvx2Descriptor{orient_avx2, describe_avx2};
#elif defined(__aarch64__)
constexpr DescriptorKernels kNeonDescriptor{orient<Simd::kNeon>, describe_place<Simd::kNeon>};
#endif

const DescriptorKernels& descriptor_kernels([[maybe_unused]] Simd simd) {
#if defined(__x86_64__)
  if (simd == Simd::kAvx2) return kAvx2Descriptor;
#elif defined(__aarch64__)
  if (simd == Simd::kNeon) return kNeonDescriptor;
#endif
  return kPortableDescriptor;
}

float gaussian(float offset, float sigma) {
  return std::exp(-offset * offset / (2 * sigma * sigma));
}

Tables make_tables() {
  constexpr int kRadius = 6;
  constexpr float kDiscSigma = 2, kWindowSigma = 7.5F, kSquareSigma = 2.5F;
  Tables tables{};
  std::size_t count = 0;
  for (int y = -kRadius; y <= kRadius; ++y) {
    for (int x = -kRadius; x <= kRadius; ++x) {
      if (x * x + y * y >= kRadius * kRadius) continue;
      tables.disc_x.at(count) = static_cast<float>(x);
      tables.disc_y.at(count) = static_cast<float>(y);
      tables.disc_weight.at(count++) =
          std::exp(static_cast<float>(-(x * x + y * y)) / (2 * kDiscSigma * kDiscSigma));
    }
  }
  for (std::size_t i = 0; i < SurfDescriptor::kSide; ++i) {
    tables.offset[i] = static_cast<float>(i) + 0.5F - SurfDescriptor::kSide / 2.0F;
    tables.window[i] = gaussian(tables.offset[i], kWindowSigma);
  }
  for (int square = 0; square < SurfDescriptor::kSquares; ++square) {
    for (int i = 0; i < SurfDescriptor::kSquareSide; ++i) {
      const auto offset = static_cast<float>(i - SurfDescriptor::kSquareSide / 2);
      const auto sample = static_cast<std::size_t>(SurfDescriptor::kSquareStep * square + i);
      tables.square[static_cast<std::size_t>(square)][sample] = gaussian(offset, kSquareSigma);
    }
  }
  return tables;
}

}  // namespace

SurfDescriptor::SurfDescriptor(Simd simd) : simd_(simd), tables_(make_tables()) {}

float SurfDescriptor::orientation_rad(const IntegralImage& integral, float x_px, float y_px,
                                      float scale) const {
  const Gradient strongest =
      descriptor_kernels(simd_).orient(tables_, integral, {x_px, y_px, scale});
  return strongest.dx == 0 && strongest.dy == 0 ? 0 : std::atan2(strongest.dy, strongest.dx);
}

void SurfDescriptor::describe(const IntegralImage& integral, float x_px, float y_px, float scale,
                              float angle_rad, std::span<float, kValues> values) const {
  descriptor_kernels(simd_).describe(tables_, integral, {x_px, y_px, scale}, std::cos(angle_rad),
                                     std::sin(angle_rad), values.data());
  float squared = 0;
  for (const float value : values) squared += value * value;
  if (squared <= 0) return;
  const float per_length = 1 / std::sqrt(squared);
  for (float& value : values) value *= per_length;
}

}  // namespace roomwise::features
