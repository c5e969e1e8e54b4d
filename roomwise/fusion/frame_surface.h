#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "roomwise/base/color.h"
#include "roomwise/base/expected.h"
#include "roomwise/geometry/pinhole_camera.h"
#include "roomwise/image/image.h"

namespace roomwise::fusion {

struct SurfaceOptions {
  double farthest_m = 4.5;  // beyond it only the emptiness before it is believed
  // Standard deviation of depth at 1 m; it grows with the square of the distance (Khoshelham and
  // Elberink, Sensors 12, 2012).
  double depth_noise_at_1m_m = 0.0014;
  // What does not grow with the distance: errors of poses and calibration.
  double noise_floor_m = 0.003;
  // Surfaces seen more slantwise than that (cosine of the angle between ray and normal) are left to
  // other frames.
  double min_cosine = 0.2;

  [[nodiscard]] Expected<void> validate() const;
};

// How sure a measurement can be at most; see SurfacePixel::weight.
constexpr int kMaxPixelWeight = 128;

// What one pixel says of the space before it, in the camera frame.
struct SurfacePixel {
  // The plane of the surface at the pixel: normal . p = offset_m, the normal (unit length) pointing
  // away from the camera. offset_m = 0: no surface that can be trusted (the outline of a thing,
  // seen too slantwise, too far).
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();
  float offset_m = 0;
  // Nothing was seen nearer than this, along the optical axis; 0: nothing was measured.
  float free_depth_m = 0;
  // Proportional to 1 / sigma^2 of the distance, 1 to kMaxPixelWeight.
  std::uint8_t weight = 0;
  Rgb8 color;

  [[nodiscard]] bool has_surface() const { return offset_m > 0; }
  // How far a point lies before the surface; negative behind it.
  [[nodiscard]] float distance_m(const Eigen::Vector3f& point_camera) const {
    return offset_m - normal.dot(point_camera);
  }
};

// For every pixel of an ideal pinhole camera the pixel of the real one that sees the same, by index
// (y * width + x); -1 where there is none. Empty without distortion, where they are the same.
using PixelTable = std::vector<std::int32_t>;

// An RGB-D frame made ready for fusion: a patch of surface a pixel.
struct FrameSurface {
  geometry::PinholeCamera camera;
  std::shared_ptr<const PixelTable> distorted_index_of_undistorted;
  image::Image<SurfacePixel> pixels;  // of the real camera
  SurfaceOptions options;             // it was made with
  bool has_colors = false;
};

// Makes frames of one camera ready. A plane is fitted about each pixel to the inverse depth, which
// on a plane is linear in the ray, and within a few pixels in the pixel, from pairs of pixels on
// opposite sides: a pair takes part if it lies on one line with the middle, give or take the noise,
// so that nothing is averaged over an edge. A pixel whose nearest pairs do not all agree belongs to
// an outline and is no surface.
class FrameSurfaceMaker {
 public:
  // The options must be valid.
  explicit FrameSurfaceMaker(const geometry::PinholeCamera& camera,
                             const SurfaceOptions& options = {});

  // Both images must have the camera's size.
  [[nodiscard]] FrameSurface make(const image::ColorImage& color,
                                  const image::DepthImage& depth) const;
  // Without colours.
  [[nodiscard]] FrameSurface make(const image::DepthImage& depth) const;

 private:
  // What changes by so much a pixel, as change by the ray's x and y.
  [[nodiscard]] Eigen::Vector2f by_ray(const Eigen::Vector2f& by_pixel, int x, int y) const;
  [[nodiscard]] const Eigen::Vector2f& ray(int x, int y) const {
    return rays_[static_cast<std::size_t>(y) * static_cast<std::size_t>(camera_.width) +
                 static_cast<std::size_t>(x)];
  }

  geometry::PinholeCamera camera_;
  SurfaceOptions options_;
  std::vector<Eigen::Vector2f> rays_;  // of the real pixels, on the plane z = 1
  std::shared_ptr<const PixelTable> distorted_index_of_undistorted_;
};

}  // namespace roomwise::fusion
