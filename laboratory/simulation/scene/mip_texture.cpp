#include "laboratory/simulation/scene/mip_texture.h"

#include <algorithm>
#include <cmath>

#include "laboratory/simulation/scene/color_math.h"
#include "laboratory/simulation/scene/noise.h"
#include "roomwise/image/resample.h"

namespace roomwise::simulation {

MipTexture::MipTexture(const image::ColorImage& srgb) {
  levels_.push_back(srgb.empty() ? image::ColorImage(1, 1, Rgb8{200, 200, 200}) : srgb);
  while (levels_.back().width() > 1 || levels_.back().height() > 1) {
    const image::ColorImage& last = levels_.back();
    levels_.push_back(
        image::resize(last, std::max(1, last.width() / 2), std::max(1, last.height() / 2)));
  }
}

Eigen::Vector3f MipTexture::color(const Eigen::Vector2f& uv, float footprint_texels) const {
  int level = 0;
  for (float size = footprint_texels; size > 1.41F; size /= 2) ++level;
  const image::ColorImage& picture =
      levels_[std::min(levels_.size() - 1, static_cast<std::size_t>(level))];
  const float x = fraction(uv.x()) * static_cast<float>(picture.width()) - 0.5F;
  const float y = (1 - fraction(uv.y())) * static_cast<float>(picture.height()) - 0.5F;
  const int left = floor_to_int(x), top = floor_to_int(y);
  const float fx = x - static_cast<float>(left), fy = y - static_cast<float>(top);
  const auto texel = [&](int column, int row) {
    const int wrapped_column = (column + picture.width()) % picture.width();
    const int wrapped_row = (row + picture.height()) % picture.height();
    return linear_from_srgb(picture.at(wrapped_column, wrapped_row));
  };
  return (1 - fy) * ((1 - fx) * texel(left, top) + fx * texel(left + 1, top)) +
         fy * ((1 - fx) * texel(left, top + 1) + fx * texel(left + 1, top + 1));
}

Eigen::Vector3f MipTexture::mean() const {
  return linear_from_srgb(levels_.back().at(0, 0));
}

}  // namespace roomwise::simulation
