#include "roomwise/mapping/cloud/frame_cloud.h"

#include "roomwise/image/rgbd_frame.h"

namespace roomwise::mapping {

FrameCloudMaker::FrameCloudMaker(const geometry::PinholeCamera& camera,
                                 const FrameCloudOptions& options)
    : camera_(camera), options_(options) {
  for (int y = 0; y < camera.height; y += options.pixel_step) {
    for (int x = 0; x < camera.width; x += options.pixel_step) {
      rays_.push_back(camera.unproject({x, y}, 1.0).cast<float>());
    }
  }
}

geometry::PointCloud FrameCloudMaker::make(const image::ColorImage& color,
                                           const image::DepthImage& depth) const {
  geometry::PointCloud cloud;
  auto ray = rays_.begin();
  for (int y = 0; y < camera_.height; y += options_.pixel_step) {
    for (int x = 0; x < camera_.width; x += options_.pixel_step, ++ray) {
      const double distance_m = image::depth_m(depth, camera_, x, y);
      if (distance_m <= 0 || distance_m > options_.farthest_m) continue;
      cloud.add(static_cast<float>(distance_m) * *ray, color.at(x, y));
    }
  }
  return cloud;
}

}  // namespace roomwise::mapping
