#include "roomwise/evaluation/drawing/top_view.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "roomwise/evaluation/statistics/quantile.h"
#include "roomwise/geometry/drawing_direction.h"

namespace roomwise::evaluation {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Places on the level plane: metres along two axes at right angles to `up`, seen from above (the
// second axis lies a quarter turn to the left of the first).
using GravityAlignedFrame = Eigen::Matrix<double, 2, 3>;

GravityAlignedFrame level_frame(const Vector3d& up, const Vector3d& first_axis) {
  GravityAlignedFrame frame;
  frame << first_axis.transpose(), up.cross(first_axis).transpose();
  return frame;
}

std::vector<std::size_t> points_under_ceiling(const geometry::PointCloud& cloud,
                                              std::span<const Vector3d> cameras, const Vector3d& up,
                                              double cut_above_m) {
  std::vector<double> camera_heights;
  for (const Vector3d& camera : cameras) camera_heights.push_back(up.dot(camera));
  const double ceiling = quantile(std::move(camera_heights), 0.5) + cut_above_m;
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Vector3d point = cloud.points[i].cast<double>();
    if (point.allFinite() && up.dot(point) <= ceiling) kept.push_back(i);
  }
  return kept;
}

std::vector<Vector2d> on_plane(const geometry::PointCloud& cloud,
                               const std::vector<std::size_t>& kept,
                               const GravityAlignedFrame& level) {
  std::vector<Vector2d> points;
  points.reserve(kept.size());
  for (const std::size_t i : kept) points.emplace_back(level * cloud.points[i].cast<double>());
  return points;
}

struct Bounds {
  Vector2d low;
  Vector2d high;
};

// All cameras and all but the outermost points on each side.
Bounds bounds_of(const std::vector<Vector2d>& points, std::span<const Vector3d> cameras,
                 const GravityAlignedFrame& level) {
  constexpr double kOutermost = 0.002;
  Bounds bounds;
  for (int axis = 0; axis < 2; ++axis) {
    std::vector<double> values;
    values.reserve(points.size());
    for (const Vector2d& point : points) values.push_back(point(axis));
    bounds.low(axis) = quantile(values, kOutermost);
    bounds.high(axis) = quantile(std::move(values), 1 - kOutermost);
  }
  for (const Vector3d& camera : cameras) {
    bounds.low = bounds.low.cwiseMin(level * camera);
    bounds.high = bounds.high.cwiseMax(level * camera);
  }
  return bounds;
}

// The frame whose first axis lies to the right.
GravityAlignedFrame drawing_frame(const geometry::PointCloud& cloud,
                                  const std::vector<std::size_t>& kept,
                                  std::span<const Vector3d> cameras, const Vector3d& up,
                                  const std::optional<Vector3d>& right_world) {
  if (right_world) return level_frame(up, (*right_world - up.dot(*right_world) * up).normalized());
  const GravityAlignedFrame any = level_frame(up, up.unitOrthogonal());
  const double right_rad =
      geometry::drawing_direction_rad(on_plane(cloud, kept, any), any * cameras.front());
  return level_frame(
      up, (any.transpose() * Vector2d(std::cos(right_rad), std::sin(right_rad))).normalized());
}

// Paints squares; the highest point wins each pixel.
class Painter {
 public:
  Painter(image::ColorImage& picture, int square_px)
      : picture_(picture),
        square_px_(square_px),
        heights_(picture.width(), picture.height(), -std::numeric_limits<double>::infinity()) {}

  void paint(const Vector2d& centre_px, double height, Rgb8 color) {
    const Eigen::Array2d farthest(picture_.width() + square_px_, picture_.height() + square_px_);
    if ((centre_px.array() < -square_px_).any() || (centre_px.array() > farthest).any()) return;
    const int left = static_cast<int>(std::floor(centre_px.x() - (square_px_ - 1) / 2.0));
    const int top = static_cast<int>(std::floor(centre_px.y() - (square_px_ - 1) / 2.0));
    for (int y = top; y < top + square_px_; ++y) {
      for (int x = left; x < left + square_px_; ++x) {
        if (!picture_.contains(x, y) || height <= heights_.at(x, y)) continue;
        heights_.at(x, y) = height;
        picture_.at(x, y) = color;
      }
    }
  }

 private:
  image::ColorImage& picture_;
  int square_px_;
  image::Image<double> heights_;
};

}  // namespace

Expected<void> TopViewOptions::validate() const {
  if (longer_side_px < 16 || longer_side_px > 10'000) {
    return fail("longer_side_px is {}; expected 16 to 10000", longer_side_px);
  }
  if (!std::isfinite(cut_above_m)) return fail("cut_above_m is {}; expected metres", cut_above_m);
  if (!(point_size_m > 0)) return fail("point_size_m is {}; expected more than 0", point_size_m);
  if (!(margin_m > 0)) return fail("margin_m is {}; expected more than 0", margin_m);
  return {};
}

Expected<TopView> render_top_view(const geometry::PointCloud& cloud,
                                  std::span<const Vector3d> cameras, const Vector3d& up_world,
                                  const TopViewOptions& options) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  if (cameras.empty()) return fail("the map cannot be drawn: it has no key-frame");
  const auto kept = points_under_ceiling(cloud, cameras, up_world, options.cut_above_m);
  if (kept.empty()) return fail("the map cannot be drawn: it holds no point below the ceiling");

  const GravityAlignedFrame level =
      drawing_frame(cloud, kept, cameras, up_world, options.right_world);
  const Bounds bounds = bounds_of(on_plane(cloud, kept, level), cameras, level);

  const Vector2d extent_m = bounds.high - bounds.low + Vector2d::Constant(2 * options.margin_m);
  TopView view;
  view.pixels_per_metre = options.longer_side_px / extent_m.maxCoeff();
  // The picture's y goes down, the gravity-aligned frame's second axis up.
  const Vector2d px_per_m(view.pixels_per_metre, -view.pixels_per_metre);
  view.pixel_from_world_linear = px_per_m.asDiagonal() * level;
  view.pixel_from_world_offset = px_per_m.cwiseProduct(
      Vector2d(options.margin_m - bounds.low.x(), -options.margin_m - bounds.high.y()));
  const auto size_px = [&](int axis) {
    return std::max(1, static_cast<int>(std::lround(extent_m(axis) * view.pixels_per_metre)));
  };
  view.picture = image::ColorImage(size_px(0), size_px(1), options.ground);

  Painter painter(
      view.picture,
      std::max(1, static_cast<int>(std::ceil(options.point_size_m * view.pixels_per_metre))));
  for (const std::size_t i : kept) {
    const Vector3d point = cloud.points[i].cast<double>();
    painter.paint(view.to_px(point), up_world.dot(point), cloud.colors[i]);
  }
  return view;
}

}  // namespace roomwise::evaluation
