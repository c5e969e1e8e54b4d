#include "roomwise/features/integral_image.h"

#include <algorithm>

namespace roomwise::features {

namespace {

// Row `below` of the sums from the one above it, from column `first` of the picture on.
template <typename Pixel>
void add_row(const Pixel* pixels, int first, int width, std::uint32_t sum_of_row,
             const std::uint32_t* above, std::uint32_t* __restrict below) {
  for (int x = first; x < width; ++x) {
    sum_of_row += pixels[x];
    below[x + 1] = above[x + 1] + sum_of_row;
  }
}

// The same, as many columns at a time as there are lanes: each lane takes up those before it, the
// next one first, then the two before, then the four.
[[gnu::always_inline]] inline void add_up_lanes(UInt8& sum) {
  const UInt8 zero{};
  sum += __builtin_shufflevector(zero, sum, 0, 8, 9, 10, 11, 12, 13, 14);
  sum += __builtin_shufflevector(zero, sum, 0, 0, 8, 9, 10, 11, 12, 13);
  sum += __builtin_shufflevector(zero, sum, 0, 0, 0, 0, 8, 9, 10, 11);
}
[[gnu::always_inline]] inline void repeat_last_lane(const UInt8& sum, UInt8& last) {
  last = __builtin_shufflevector(sum, sum, 7, 7, 7, 7, 7, 7, 7, 7);
}
[[gnu::always_inline]] inline void add_up_lanes(UInt4& sum) {
  const UInt4 zero{};
  sum += __builtin_shufflevector(zero, sum, 0, 4, 5, 6);
  sum += __builtin_shufflevector(zero, sum, 0, 0, 4, 5);
}
[[gnu::always_inline]] inline void repeat_last_lane(const UInt4& sum, UInt4& last) {
  last = __builtin_shufflevector(sum, sum, 3, 3, 3, 3);
}
template <Simd simd>
[[gnu::always_inline]] inline void add_row_by_lanes(const std::uint16_t* pixels, int width,
                                                    const std::uint32_t* above,
                                                    std::uint32_t* __restrict below) {
  using UInt = typename Lanes<simd>::UInt;
  constexpr int kCount = Lanes<simd>::kCount;
  UInt sum_before{};
  int x = 0;
  for (; x + kCount <= width; x += kCount) {
    typename Lanes<simd>::UShort loaded;
    UInt over;
    load(pixels + x, loaded);
    load(above + x + 1, over);
    UInt sum = __builtin_convertvector(loaded, UInt);
    add_up_lanes(sum);
    sum += sum_before;
    repeat_last_lane(sum, sum_before);
    store(over + sum, below + x + 1);
  }
  add_row(pixels, x, width, sum_before[0], above, below);
}

#if defined(__x86_64__)
__attribute__((target("avx2"))) void add_row_avx2(const std::uint16_t* pixels, int width,
                                                  const std::uint32_t* above,
                                                  std::uint32_t* __restrict below) {
  add_row_by_lanes<Simd::kAvx2>(pixels, width, above, below);
}
#endif

}  // namespace

IntegralImage::IntegralImage(const image::GrayImage& image) {
  reset(image.width(), image.height());
  for (int y = 0; y < height_; ++y) {
    add_row(image.row(y).data(), 0, width_, 0, row(y), sums_.data() + offset(y + 1));
  }
}

void IntegralImage::reset(int width, int height) {
  width_ = width;
  height_ = height;
  stride_ = static_cast<std::size_t>(width) + 1;
  sums_.resize(offset(height + 1) + kTailPadding);
  std::fill_n(sums_.begin(), stride_, 0U);
  for (int y = 1; y <= height; ++y) sums_[offset(y)] = 0;
}

void IntegralImage::set_row(int y, std::span<const std::uint16_t> pixels,
                            [[maybe_unused]] Simd simd) {
  std::uint32_t* below = sums_.data() + offset(y + 1);
#if defined(__x86_64__)
  if (simd == Simd::kAvx2) {
    add_row_avx2(pixels.data(), width_, row(y), below);
    return;
  }
#elif defined(__aarch64__)
  if (simd == Simd::kNeon) {
    add_row_by_lanes<Simd::kNeon>(pixels.data(), width_, row(y), below);
    return;
  }
#endif
  add_row(pixels.data(), 0, width_, 0, row(y), below);
}

std::uint32_t IntegralImage::box_sum(int left, int top, int right, int bottom) const {
  left = std::clamp(left, 0, width_);
  right = std::clamp(right, 0, width_);
  top = std::clamp(top, 0, height_);
  bottom = std::clamp(bottom, 0, height_);
  if (left >= right || top >= bottom) return 0;
  return row(bottom)[right] - row(bottom)[left] - row(top)[right] + row(top)[left];
}

}  // namespace roomwise::features
