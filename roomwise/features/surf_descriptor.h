#pragma once

#include <array>
#include <span>
#include <vector>

#include "roomwise/features/integral_image.h"

namespace roomwise::features {

// Orientation and descriptor of SURF (Bay et al. 2008, sections 4.1 and 4.2).
class SurfDescriptor {
 public:
  static constexpr int kValues = 64;

  SurfDescriptor();

  // The direction of the strongest summed Haar response in any sector of pi/3 within 6 s of a
  // place, from x to y in (-pi, pi]; 0 where the picture is flat.
  [[nodiscard]] float orientation_rad(const IntegralImage& integral, float x_px, float y_px,
                                      float scale) const;

  // 4x4 squares of 5 s side around the place, turned by angle_rad; of each the sums of dx, dy, |dx|
  // and |dy|; of unit length together. All zero where the picture is flat.
  void describe(const IntegralImage& integral, float x_px, float y_px, float scale, float angle_rad,
                std::span<float, kValues> values) const;

 private:
  struct Sample {
    float x, y;  // offset from the centre, in units of the scale
    float weight;
  };
  std::vector<Sample> disc_;                                     // of the orientation
  static constexpr int kSide = 20;                               // samples across the window
  std::array<float, static_cast<std::size_t>(kSide)> gaussian_;  // of the window, one axis
};

}  // namespace roomwise::features
