#include "dlib_surf.h"

#include <dlib/array2d.h>
#include <dlib/image_keypoint.h>

namespace roomwise::bench {

features::Features DlibSurfExtractor::extract(const image::GrayImage& image) const {
  constexpr double kMinResponse = 0.1;  // low, so that the strongest fill the number
  constexpr int kValues = 64;
  dlib::array2d<unsigned char> pixels(image.height(), image.width());
  for (int y = 0; y < image.height(); ++y) {
    std::copy(image.row(y).begin(), image.row(y).end(), &pixels[y][0]);
  }
  const auto points = dlib::get_surf_points(pixels, max_keypoints_, kMinResponse);
  features::Features found;
  features::FloatDescriptors descriptors(points.size(), kValues);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const dlib::surf_point& point = points[i];
    features::Keypoint& keypoint = found.keypoints.emplace_back();
    keypoint.position_px = {static_cast<float>(point.p.center.x()),
                            static_cast<float>(point.p.center.y())};
    keypoint.size_px = static_cast<float>(20 * point.p.scale);
    keypoint.angle_rad = static_cast<float>(point.angle);
    keypoint.response = static_cast<float>(point.p.score);
    keypoint.bright = point.p.laplacian < 0;
    for (int k = 0; k < kValues; ++k) {
      descriptors(static_cast<Eigen::Index>(i), k) = static_cast<float>(point.des(k));
    }
  }
  found.descriptors = std::move(descriptors);
  return found;
}

}  // namespace roomwise::bench
