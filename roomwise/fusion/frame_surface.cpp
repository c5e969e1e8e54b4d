#include "roomwise/fusion/frame_surface.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "roomwise/image/rgbd_frame.h"

namespace roomwise::fusion {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;
using InverseDepth = image::Image<float>;  // 1/m; 0 where nothing was measured

struct Offset {
  int x, y;
};
// One of each pair of pixels about the middle. The first four are its neighbours.
constexpr std::size_t kNearestPairs = 4;
constexpr std::array<Offset, 16> kPairs{{{1, 0},
                                         {0, 1},
                                         {1, 1},
                                         {1, -1},
                                         {2, 0},
                                         {4, 0},
                                         {-4, 2},
                                         {-2, 2},
                                         {0, 2},
                                         {2, 2},
                                         {4, 2},
                                         {-4, 4},
                                         {-2, 4},
                                         {0, 4},
                                         {2, 4},
                                         {4, 4}}};

// The inverse depth about a pixel: value + slope . (offset in pixels).
struct LocalPlane {
  float value = 0;
  Vector2f slope = Vector2f::Zero();
  bool is_depth_edge = false;
};

// How far the middle of a pair may lie off the line between its two ends: three sigmas of
// a + b - 2 c.
float second_difference_threshold(const SurfaceOptions& options) {
  return static_cast<float>(3 * std::sqrt(6.0) * options.depth_noise_at_1m_m);
}

// `ridge` holds the slope near 0 where few pairs tell of it: the square of noise over what slope is
// likely.
LocalPlane fit_plane(const InverseDepth& inverse, int x, int y, float max_second_difference,
                     float ridge) {
  LocalPlane plane;
  const float middle = inverse.at(x, y);
  float sum = middle, count = 1;
  float xx = ridge, xy = 0, yy = ridge, xv = 0, yv = 0;
  for (std::size_t i = 0; i < kPairs.size(); ++i) {
    const auto [dx, dy] = kPairs[i];
    float ahead = 0, behind = 0;
    if (inverse.contains(x + dx, y + dy) && inverse.contains(x - dx, y - dy)) {
      ahead = inverse.at(x + dx, y + dy);
      behind = inverse.at(x - dx, y - dy);
    }
    const bool agrees =
        ahead > 0 && behind > 0 && std::abs(ahead + behind - 2 * middle) < max_second_difference;
    if (!agrees) {
      if (i < kNearestPairs) {
        plane.is_depth_edge = true;
        return plane;
      }
      continue;
    }
    const auto fx = static_cast<float>(dx), fy = static_cast<float>(dy);
    sum += ahead + behind;
    count += 2;
    xx += 2 * fx * fx;
    xy += 2 * fx * fy;
    yy += 2 * fy * fy;
    xv += fx * (ahead - behind);
    yv += fy * (ahead - behind);
  }
  const float determinant = xx * yy - xy * xy;
  plane.value = sum / count;
  plane.slope = Vector2f(yy * xv - xy * yv, xx * yv - xy * xv) / determinant;
  return plane;
}

// The largest value within `reach` pixels in x, or in y.
InverseDepth largest_about(const InverseDepth& values, int reach, bool along_x) {
  InverseDepth largest(values.width(), values.height());
  for (int y = 0; y < values.height(); ++y) {
    for (int x = 0; x < values.width(); ++x) {
      float most = 0;
      for (int d = -reach; d <= reach; ++d) {
        const int nx = along_x ? std::clamp(x + d, 0, values.width() - 1) : x;
        const int ny = along_x ? y : std::clamp(y + d, 0, values.height() - 1);
        most = std::max(most, values.at(nx, ny));
      }
      largest.at(x, y) = most;
    }
  }
  return largest;
}

PixelTable make_pixel_table(const geometry::PinholeCamera& camera) {
  PixelTable table;
  if (camera.distortion.is_none()) return table;
  table.reserve(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height));
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Eigen::Vector2d real = camera.project(camera.unproject_undistorted({x, y}, 1.0));
      const long rx = std::lround(real.x()), ry = std::lround(real.y());
      const bool inside = rx >= 0 && ry >= 0 && rx < camera.width && ry < camera.height;
      table.push_back(inside ? static_cast<std::int32_t>(ry * camera.width + rx) : -1);
    }
  }
  return table;
}

std::uint8_t weight_at(double depth_m, double cosine, const SurfaceOptions& options) {
  const double noise_m = options.depth_noise_at_1m_m * depth_m * depth_m;
  const double common2 = options.noise_floor_m * options.noise_floor_m;
  const double share = common2 / (common2 + noise_m * noise_m) * cosine;
  return static_cast<std::uint8_t>(
      std::clamp(std::lround(kMaxPixelWeight * share), 1L, static_cast<long>(kMaxPixelWeight)));
}

}  // namespace

Expected<void> SurfaceOptions::validate() const {
  if (!(farthest_m > 0)) return fail("farthest_m is {}; expected more than 0", farthest_m);
  if (!(depth_noise_at_1m_m > 0)) {
    return fail("depth_noise_at_1m_m is {}; expected more than 0", depth_noise_at_1m_m);
  }
  if (!(noise_floor_m > 0)) return fail("noise_floor_m is {}; expected more than 0", noise_floor_m);
  if (!(min_cosine >= 0 && min_cosine < 1)) {
    return fail("min_cosine is {}; expected 0 or more and less than 1", min_cosine);
  }
  return {};
}

FrameSurfaceMaker::FrameSurfaceMaker(const geometry::PinholeCamera& camera,
                                     const SurfaceOptions& options)
    : camera_(camera),
      options_(options),
      distorted_index_of_undistorted_(
          std::make_shared<const PixelTable>(make_pixel_table(camera))) {
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      rays_.emplace_back(camera.unproject({x, y}, 1.0).head<2>().cast<float>());
    }
  }
}

Vector2f FrameSurfaceMaker::by_ray(const Vector2f& by_pixel, int x, int y) const {
  if (camera_.distortion.is_none()) {
    return by_pixel.cwiseProduct(
        Vector2f(static_cast<float>(camera_.fx), static_cast<float>(camera_.fy)));
  }
  const int left = std::max(x - 1, 0), right = std::min(x + 1, camera_.width - 1);
  const int above = std::max(y - 1, 0), below = std::min(y + 1, camera_.height - 1);
  Eigen::Matrix2f ray_by_pixel;
  ray_by_pixel << (ray(right, y) - ray(left, y)) / static_cast<float>(right - left),
      (ray(x, below) - ray(x, above)) / static_cast<float>(below - above);
  return ray_by_pixel.transpose().inverse() * by_pixel;
}

FrameSurface FrameSurfaceMaker::make(const image::ColorImage& color,
                                     const image::DepthImage& depth) const {
  FrameSurface frame = make(depth);
  frame.has_colors = true;
  for (std::size_t i = 0; i < frame.pixels.pixels().size(); ++i) {
    frame.pixels.pixels()[i].color = color.pixels()[i];
  }
  return frame;
}

FrameSurface FrameSurfaceMaker::make(const image::DepthImage& depth) const {
  InverseDepth inverse(camera_.width, camera_.height);
  for (int y = 0; y < camera_.height; ++y) {
    for (int x = 0; x < camera_.width; ++x) {
      const double z_m = image::depth_m(depth, camera_, x, y);
      inverse.at(x, y) = z_m > 0 ? static_cast<float>(1 / z_m) : 0.0F;
    }
  }
  // A thing that is a few pixels wide must not be taken for empty space between two of them.
  constexpr int kOutlineReach_px = 2;
  const InverseDepth nearest = largest_about(largest_about(inverse, kOutlineReach_px, true),
                                             kOutlineReach_px, /*along_x=*/false);

  FrameSurface frame{
      camera_, distorted_index_of_undistorted_, {camera_.width, camera_.height}, options_};
  const float max_second_difference = second_difference_threshold(options_);
  const auto min_inverse = static_cast<float>(1 / options_.farthest_m);
  for (int y = 0; y < camera_.height; ++y) {
    for (int x = 0; x < camera_.width; ++x) {
      const float middle = inverse.at(x, y);
      if (middle <= 0) continue;
      SurfacePixel& pixel = frame.pixels.at(x, y);
      pixel.free_depth_m = 1 / std::max(nearest.at(x, y), min_inverse);
      pixel.weight = weight_at(pixel.free_depth_m, 1, options_);
      if (middle < min_inverse) continue;
      // A slope of 45 degrees is likely.
      const float ridge_root =
          static_cast<float>(options_.depth_noise_at_1m_m * camera_.fx) / middle;
      const LocalPlane plane =
          fit_plane(inverse, x, y, max_second_difference, ridge_root * ridge_root);
      if (plane.is_depth_edge) continue;
      // q = n . (ray, 1) on the plane n . p = 1, with q the inverse depth.
      const Vector2f across = by_ray(plane.slope, x, y);
      const Vector3f scaled(across.x(), across.y(), plane.value - across.dot(ray(x, y)));
      const float length = scaled.norm();
      const float cosine = plane.value / length / ray(x, y).homogeneous().norm();
      if (!(cosine >= static_cast<float>(options_.min_cosine))) continue;
      pixel.normal = scaled / length;
      pixel.offset_m = 1 / length;
      pixel.weight = weight_at(1 / static_cast<double>(plane.value), cosine, options_);
    }
  }
  return frame;
}

}  // namespace roomwise::fusion
