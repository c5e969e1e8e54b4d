#pragma once

#include <Eigen/Core>
#include <vector>

#include "roomwise/image/image.h"

namespace roomwise::simulation {

// A picture that covers surfaces, repeated in both directions, with smaller copies of itself for
// where it is seen small.
class MipTexture {
 public:
  explicit MipTexture(const image::ColorImage& srgb);

  // The linear colour at texture coordinates (v upwards), bilinear in the copy that fits
  // `footprint_texels`, the width that one sample covers in the full picture.
  [[nodiscard]] Eigen::Vector3f color(const Eigen::Vector2f& uv, float footprint_texels) const;
  [[nodiscard]] Eigen::Vector3f mean() const;
  [[nodiscard]] int width() const { return levels_.front().width(); }
  [[nodiscard]] int height() const { return levels_.front().height(); }

 private:
  // sRGB: eight bits of linear light would show steps in the dark.
  std::vector<image::ColorImage> levels_;
};

}  // namespace roomwise::simulation
