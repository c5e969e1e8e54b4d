#include "roomwise/recording/robot/depth_registration.h"

#include <algorithm>
#include <cmath>

namespace roomwise::recording {
namespace {

using geometry::PinholeCamera;
using image::DepthImage;

constexpr float kMaxUnits = 65535;
// Depths that differ by less are of one surface.
constexpr float kOneSurface = 0.02F;

// Bends a point of the plane at distance 1 as the lens does.
void distort(const geometry::LensDistortion& lens, float& x, float& y) {
  const auto k1 = static_cast<float>(lens.k1), k2 = static_cast<float>(lens.k2);
  const auto k3 = static_cast<float>(lens.k3), p1 = static_cast<float>(lens.p1);
  const auto p2 = static_cast<float>(lens.p2);
  const float r2 = x * x + y * y;
  const float radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const float seen_x = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x);
  y = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;
  x = seen_x;
}

// For numbers that are not negative. std::ceil is a call where the processor's baseline has no
// instruction for it.
int ceiling(float value) {
  const int whole = static_cast<int>(value);
  return whole + (static_cast<float>(whole) < value ? 1 : 0);
}

std::uint16_t between(std::uint16_t a, std::uint16_t b) {
  const int difference = std::abs(int{a} - int{b});
  const bool is_one_surface =
      a != 0 && b != 0 && static_cast<float>(difference) <= kOneSurface * static_cast<float>(a);
  return is_one_surface ? static_cast<std::uint16_t>((int{a} + int{b}) / 2) : std::uint16_t{0};
}

DepthImage without_cracks(const DepthImage& depth) {
  DepthImage closed = depth;
  for (int y = 1; y + 1 < depth.height(); ++y) {
    for (int x = 1; x + 1 < depth.width(); ++x) {
      if (depth.at(x, y) != 0) continue;
      const std::uint16_t across = between(depth.at(x - 1, y), depth.at(x + 1, y));
      closed.at(x, y) = across != 0 ? across : between(depth.at(x, y - 1), depth.at(x, y + 1));
    }
  }
  return closed;
}

}  // namespace

DepthRegistration::DepthRegistration(const PinholeCamera& depth_camera,
                                     const PinholeCamera& color_camera,
                                     const geometry::RigidTransform& color_from_depth)
    : color_camera_(color_camera),
      offset_((color_from_depth.translation * color_camera.depth_units_per_metre).cast<float>()),
      half_pixel_(Eigen::Vector2d(color_camera.fx / depth_camera.fx / 2,
                                  color_camera.fy / depth_camera.fy / 2)
                      .cast<float>()) {
  const Eigen::Matrix3d rotation = color_from_depth.rotation_matrix();
  for (int y = 0; y < depth_camera.height; ++y) {
    for (int x = 0; x < depth_camera.width; ++x) {
      const Eigen::Vector3d ray = rotation * depth_camera.unproject(Eigen::Vector2d(x, y), 1);
      rays_x_.push_back(static_cast<float>(ray.x()));
      rays_y_.push_back(static_cast<float>(ray.y()));
      rays_z_.push_back(static_cast<float>(ray.z()));
    }
  }
}

DepthImage DepthRegistration::apply(const DepthImage& depth) const {
  DepthImage registered(color_camera_.width, color_camera_.height);
  const auto width = static_cast<std::size_t>(depth.width());
  MovedRow row{std::vector<float>(width), std::vector<float>(width), std::vector<float>(width)};
  for (int y = 0; y < depth.height(); ++y) {
    move_row(depth.row(y), static_cast<std::size_t>(y) * width, row);
    draw_row(depth.row(y), row, registered);
  }
  return without_cracks(registered);
}

// No branch, so that the compiler takes several pixels at once.
void DepthRegistration::move_row(std::span<const std::uint16_t> depths, std::size_t first,
                                 MovedRow& row) const {
  const geometry::LensDistortion lens = color_camera_.distortion;
  const auto fx = static_cast<float>(color_camera_.fx), fy = static_cast<float>(color_camera_.fy);
  const auto cx = static_cast<float>(color_camera_.cx), cy = static_cast<float>(color_camera_.cy);
  const float *ray_x = &rays_x_[first], *ray_y = &rays_y_[first], *ray_z = &rays_z_[first];
  const Eigen::Vector3f offset = offset_;
  float *moved_x = row.x.data(), *moved_y = row.y.data(), *moved_z = row.z.data();
  for (std::size_t i = 0; i < depths.size(); ++i) {
    const auto depth = static_cast<float>(depths[i]);
    const float z = ray_z[i] * depth + offset.z();
    const float x = (ray_x[i] * depth + offset.x()) / z;
    const float y = (ray_y[i] * depth + offset.y()) / z;
    moved_z[i] = z;
    moved_x[i] = fx * x + cx;
    moved_y[i] = fy * y + cy;
  }
  if (lens.is_none()) return;
  for (std::size_t i = 0; i < depths.size(); ++i) {
    float x = (moved_x[i] - cx) / fx, y = (moved_y[i] - cy) / fy;
    distort(lens, x, y);
    moved_x[i] = fx * x + cx;
    moved_y[i] = fy * y + cy;
  }
}

void DepthRegistration::draw_row(std::span<const std::uint16_t> depths, const MovedRow& row,
                                 DepthImage& registered) const {
  const auto width = static_cast<float>(registered.width());
  const auto height = static_cast<float>(registered.height());
  for (std::size_t i = 0; i < depths.size(); ++i) {
    const float z = row.z[i];
    if (depths[i] == 0 || !(z >= 0.5F && z <= kMaxUnits)) continue;
    const float nearer = static_cast<float>(depths[i]) / z;
    const float half_x = std::max(0.5F, half_pixel_.x() * nearer);
    const float half_y = std::max(0.5F, half_pixel_.y() * nearer);
    const float left = row.x[i] - half_x, right = row.x[i] + half_x;
    const float top = row.y[i] - half_y, bottom = row.y[i] + half_y;
    // Asked in this way, numbers that are none are outside.
    if (!(right > 0 && left < width && bottom > 0 && top < height)) continue;
    // The pixels whose centres lie within.
    const int first_x = ceiling(std::max(left, 0.0F)), end_x = ceiling(std::min(right, width));
    const int first_y = ceiling(std::max(top, 0.0F)), end_y = ceiling(std::min(bottom, height));
    const auto rounded = static_cast<std::uint16_t>(z + 0.5F);
    for (int y = first_y; y < end_y; ++y) {
      for (int x = first_x; x < end_x; ++x) {
        std::uint16_t& there = registered.at(x, y);
        // 0, where nothing is yet, becomes the largest.
        if (rounded <= static_cast<std::uint16_t>(there - 1U)) there = rounded;
      }
    }
  }
}

}  // namespace roomwise::recording
