#include "roomwise/evaluation/drawing/framed_picture.h"

#include <algorithm>
#include <cmath>

#include "roomwise/image/resample.h"

namespace roomwise::evaluation {

image::ColorImage framed_picture(const image::ColorImage& picture, const Eigen::AlignedBox2f& box,
                                 int width_px) {
  constexpr int kWidth = 4;
  const int width = std::min(width_px, picture.width());
  const float scale = static_cast<float>(width) / static_cast<float>(picture.width());
  const int height =
      std::max(1, static_cast<int>(std::lround(scale * static_cast<float>(picture.height()))));
  image::ColorImage framed = image::resize(picture, width, height);
  if (box.isEmpty()) return framed;
  const Eigen::Array2i rim(width - 1, height - 1);
  const Eigen::Array2i first =
      ((scale * box.min()).array().floor().cast<int>() - kWidth).max(0).min(rim);
  const Eigen::Array2i last =
      ((scale * box.max()).array().ceil().cast<int>() + (kWidth - 1)).max(0).min(rim);
  for (int y = first.y(); y <= last.y(); ++y) {
    for (int x = first.x(); x <= last.x(); ++x) {
      const int depth = std::min({x - first.x(), last.x() - x, y - first.y(), last.y() - y});
      if (depth >= kWidth) continue;
      const bool is_rim = depth == 0 || depth == kWidth - 1;
      framed.at(x, y) = is_rim ? Rgb8{0, 0, 0} : Rgb8{255, 220, 0};
    }
  }
  return framed;
}

}  // namespace roomwise::evaluation
