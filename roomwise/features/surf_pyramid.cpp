#include "roomwise/features/surf_pyramid.h"

#include <algorithm>

namespace roomwise::features {
namespace {

using WideImage = image::Image<std::uint16_t>;

void fit(WideImage& image, int width, int height) {
  if (image.width() != width || image.height() != height) image = WideImage(width, height);
}

// A row with room for `border` values on either side, which repeat its first and last.
class PaddedRow {
 public:
  static constexpr int kBorder = 2;
  PaddedRow(std::vector<std::uint16_t>& memory, int width) : width_(width) {
    memory.resize(static_cast<std::size_t>(width) + 2 * kBorder);
    values_ = memory.data() + kBorder;
  }
  std::uint16_t* values() { return values_; }
  void pad() {
    std::fill_n(values_ - kBorder, kBorder, values_[0]);
    std::fill_n(values_ + width_, kBorder, values_[width_ - 1]);
  }

 private:
  int width_;
  std::uint16_t* values_;
};

// The binomial filter 1 4 6 4 1 down and across, which has a variance of one pixel squared. The
// sums down the columns are divided by 2^vertical_shift. All sums fit 16 bits.
template <typename Pixel>
[[gnu::always_inline]] inline void smooth(const image::Image<Pixel>& picture, int vertical_shift,
                                          std::vector<std::uint16_t>& memory, WideImage& target) {
  const int width = picture.width(), height = picture.height();
  fit(target, width, height);
  PaddedRow row(memory, width);
  const int rounding = (1 << vertical_shift) / 2;
  for (int y = 0; y < height; ++y) {
    const auto above_or_below = [&](int by) {
      return picture.row(std::clamp(y + by, 0, height - 1)).data();
    };
    const Pixel *a = above_or_below(-2), *b = above_or_below(-1), *c = above_or_below(0),
                *d = above_or_below(1), *e = above_or_below(2);
    std::uint16_t* __restrict down = row.values();
    for (int x = 0; x < width; ++x) {
      down[x] = static_cast<std::uint16_t>(
          (a[x] + e[x] + 4 * (b[x] + d[x]) + 6 * c[x] + rounding) >> vertical_shift);
    }
    row.pad();
    std::uint16_t* __restrict across = target.row(y).data();
    for (int x = 0; x < width; ++x) {
      across[x] = static_cast<std::uint16_t>(
          (down[x - 2] + down[x + 2] + 4 * (down[x - 1] + down[x + 1]) + 6 * down[x] + 8) >> 4);
    }
  }
}

// Half the size, rounded down, by 1 3 3 1: edges of pixels stay on edges of pixels.
[[gnu::always_inline]] inline void halve(const WideImage& fine, std::vector<std::uint16_t>& memory,
                                         WideImage& target) {
  fit(target, fine.width() / 2, fine.height() / 2);
  PaddedRow row(memory, fine.width());
  for (int y = 0; y < target.height(); ++y) {
    const auto fine_row = [&](int v) {
      return fine.row(std::clamp(2 * y + v, 0, fine.height() - 1)).data();
    };
    const std::uint16_t *a = fine_row(-1), *b = fine_row(0), *c = fine_row(1), *d = fine_row(2);
    std::uint16_t* __restrict down = row.values();
    for (int x = 0; x < fine.width(); ++x) {
      down[x] = static_cast<std::uint16_t>((a[x] + d[x] + 3 * (b[x] + c[x]) + 4) >> 3);
    }
    row.pad();
    std::uint16_t* __restrict across = target.row(y).data();
    for (int x = 0; x < target.width(); ++x) {
      const std::uint16_t* from = down + 2 * x;
      across[x] =
          static_cast<std::uint16_t>((from[-1] + from[2] + 3 * (from[0] + from[1]) + 4) >> 3);
    }
  }
}

// Row y of a picture at double size: bilinear, edges of pixels on edges of pixels.
[[gnu::always_inline]] inline void double_row(const WideImage& picture, int y,
                                              std::vector<std::uint16_t>& memory,
                                              std::vector<std::uint16_t>& target) {
  const int width = picture.width();
  const int further = std::clamp(y % 2 == 0 ? y / 2 - 1 : y / 2 + 1, 0, picture.height() - 1);
  const std::uint16_t* a = picture.row(y / 2).data();
  const std::uint16_t* b = picture.row(further).data();
  PaddedRow row(memory, width);
  std::uint16_t* __restrict down = row.values();
  for (int x = 0; x < width; ++x) down[x] = static_cast<std::uint16_t>(3 * a[x] + b[x]);
  row.pad();
  std::uint16_t* __restrict across = target.data();
  for (int x = 0; x < width; ++x) {
    across[2 * x] = static_cast<std::uint16_t>((3 * down[x] + down[x - 1] + 8) >> 4);
    across[2 * x + 1] = static_cast<std::uint16_t>((3 * down[x] + down[x + 1] + 8) >> 4);
  }
}

// The same code for each kind of processor; whole numbers give the same bits. What the compiler
// makes of it for any arm64 is NEON's already.
struct PyramidKernels {
  void (*smooth_picture)(const image::GrayImage&, std::vector<std::uint16_t>&, WideImage&);
  void (*smooth)(const WideImage&, std::vector<std::uint16_t>&, WideImage&);
  void (*halve)(const WideImage&, std::vector<std::uint16_t>&, WideImage&);
  void (*double_row)(const WideImage&, int y, std::vector<std::uint16_t>&,
                     std::vector<std::uint16_t>&);
};
#define ROOMWISE_KERNELS(name, target)                                                  \
  constexpr PyramidKernels name {                                                       \
    [](const image::GrayImage& from, std::vector<std::uint16_t>& memory, WideImage& to) \
        target { smooth(from, 0, memory, to); },                                        \
        [](const WideImage& from, std::vector<std::uint16_t>& memory, WideImage& to)    \
            target { smooth(from, 4, memory, to); },                                    \
        [](const WideImage& from, std::vector<std::uint16_t>& memory, WideImage& to)    \
            target { halve(from, memory, to); },                                        \
        [](const WideImage& from, int y, std::vector<std::uint16_t>& memory,            \
           std::vector<std::uint16_t>& to) target { double_row(from, y, memory, to); }  \
  }
ROOMWISE_KERNELS(kPortablePyramid, );
#if defined(__x86_64__)
ROOMWISE_KERNELS(kAvx2Pyramid, __attribute__((target("avx2"))));
#endif
#undef ROOMWISE_KERNELS

const PyramidKernels& pyramid_kernels([[maybe_unused]] Simd simd) {
#if defined(__x86_64__)
  if (simd == Simd::kAvx2) return kAvx2Pyramid;
#endif
  return kPortablePyramid;
}

}  // namespace

void SurfPyramid::build(const image::GrayImage& picture, int sizes, bool doubled, Simd simd) {
  octaves_.resize(static_cast<std::size_t>(sizes));
  halved_.resize(octaves_.size());
  smoothed_.resize(octaves_.size());
  used_ = 0;
  if (picture.empty()) return;
  const PyramidKernels& kernels = pyramid_kernels(simd);
  kernels.smooth_picture(picture, row_, smooth_);
  const WideImage* last = &smooth_;
  float pixel_size_px = doubled ? 0.5F : 1;
  for (std::size_t i = 0; i < octaves_.size(); ++i, pixel_size_px *= 2) {
    SurfOctave& octave = octaves_[i];
    octave.pixel_size_px = pixel_size_px;
    if (pixel_size_px < 1) {
      octave.integral.reset(2 * picture.width(), 2 * picture.height());
      doubled_row_.resize(static_cast<std::size_t>(octave.integral.width()));
      for (int y = 0; y < octave.integral.height(); ++y) {
        kernels.double_row(smooth_, y, row_, doubled_row_);
        octave.integral.set_row(y, doubled_row_, simd);
      }
    } else {
      if (pixel_size_px > 1) {
        if (std::min(last->width(), last->height()) < 2) return;
        kernels.halve(*last, row_, halved_[i]);
        last = &halved_[i];
      }
      kernels.smooth(*last, row_, smoothed_[i]);
      last = &smoothed_[i];
      octave.integral.reset(last->width(), last->height());
      for (int y = 0; y < last->height(); ++y) {
        octave.integral.set_row(y, last->row(y), simd);
      }
    }
    ++used_;
  }
}

const SurfOctave& SurfPyramid::octave_of_scale(float scale) const {
  constexpr float kMax = 3.2F;
  const auto found = std::ranges::find_if(
      octaves(), [&](const SurfOctave& octave) { return scale < kMax * octave.pixel_size_px; });
  return found == octaves().end() ? octaves().back() : *found;
}

}  // namespace roomwise::features
