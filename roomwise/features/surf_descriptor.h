#pragma once

#include <array>
#include <span>

#include "roomwise/base/simd.h"
#include "roomwise/features/integral_image.h"

namespace roomwise::features {

// Orientation and descriptor of SURF (Bay et al. 2008, sections 4.1 and 4.2), the latter with the
// overlapping, softly bounded squares of M-SURF (Agrawal, Konolige and Blas, "CenSurE: Center
// Surround Extremas for Realtime Feature Detection and Matching", ECCV 2008, section 4).
// Places and scales are in pixels of the integral image, which is at least 5 scales wide and high.
class SurfDescriptor {
 public:
  static constexpr int kValues = 64;

  explicit SurfDescriptor(Simd simd);

  // The direction of the strongest summed Haar response in any sector of pi/3 within 6 s of a
  // place, from x to y in (-pi, pi]; 0 where the picture is flat.
  [[nodiscard]] float orientation_rad(const IntegralImage& integral, float x_px, float y_px,
                                      float scale) const;

  // 4x4 squares of 9 s side, 5 s apart, around the place, turned by angle_rad; of each the sums of
  // dx, dy, |dx| and |dy|, weighted towards its centre; of unit length together. All zero where the
  // picture is flat.
  void describe(const IntegralImage& integral, float x_px, float y_px, float scale, float angle_rad,
                std::span<float, kValues> values) const;

  static constexpr int kDiscSamples = 112;  // of the orientation, filled up to whole vectors
  static constexpr int kSide = 24;          // samples across the descriptor's window
  static constexpr int kSquares = 4;        // across
  static constexpr int kSquareSide = 9;     // samples
  static constexpr int kSquareStep = 5;     // samples from one square to the next

  // What does not depend on the picture. Offsets are in units of the scale.
  struct Tables {
    std::array<float, kDiscSamples> disc_x, disc_y, disc_weight;
    std::array<float, kSide> offset, window;
    std::array<std::array<float, kSide>, kSquares> square;  // 0 outside the square
  };

 private:
  Simd simd_;
  Tables tables_;
};

}  // namespace roomwise::features
