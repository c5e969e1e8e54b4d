#pragma once

#include <span>
#include <vector>

#include "roomwise/base/simd.h"
#include "roomwise/features/integral_image.h"

namespace roomwise::features {

// A picture at one of the sizes at which SURF looks at it: an octave, for which four layers of
// filters run over it. Intensities are those of the picture times kIntensityScale, so that smoothing
// keeps its fractions.
struct SurfOctave {
  static constexpr float kIntensityScale = 16;
  IntegralImage integral;
  float pixel_size_px = 1;  // a pixel of the octave, in those of the picture

  // Centres of pixels are whole numbers in both.
  [[nodiscard]] float to_picture(float place) const {
    return (place + 0.5F) * pixel_size_px - 0.5F;
  }
  [[nodiscard]] float from_picture(float place_px) const {
    return (place_px + 0.5F) / pixel_size_px - 0.5F;
  }
};

// The picture at double, single, half, quarter ... size, each smoothed. The paper grows its box
// filters over one picture instead, unsmoothed; but boxes answer a turned picture otherwise than an
// upright one, and smoothing that grows with the scale mends much of that
// (docs/experiments/surf.md). Keeps its memory from one picture to the next.
class SurfPyramid {
 public:
  // `sizes` octaves, the first of which has the double size if `doubled`, otherwise the single one;
  // fewer where nothing is left of the picture.
  void build(const image::GrayImage& picture, int sizes, bool doubled, Simd simd);

  [[nodiscard]] std::span<const SurfOctave> octaves() const { return {octaves_.data(), used_}; }
  // The octave in whose pixels a scale (in pixels of the picture) lies between 1.6 and 3.2, or the
  // nearest to that. There must be one.
  [[nodiscard]] const SurfOctave& octave_of_scale(float scale) const;

 private:
  // Intensities times kIntensityScale.
  using WideImage = image::Image<std::uint16_t>;

  std::vector<SurfOctave> octaves_;
  std::size_t used_ = 0;           // of them and of what follows; the others only keep their memory
  WideImage smooth_;               // the picture, smoothed once
  std::vector<WideImage> halved_;  // before smoothing
  std::vector<WideImage> smoothed_;
  std::vector<std::uint16_t> row_, doubled_row_;
};

}  // namespace roomwise::features
