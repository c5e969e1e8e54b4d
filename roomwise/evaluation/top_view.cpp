#include "roomwise/evaluation/top_view.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <vector>

#include "roomwise/evaluation/quantile.h"

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

// How far the points gather in lines along the axes of the plane turned by `angle_rad`: walls along
// an axis fall into few places of the other.
double gathering(const std::vector<Vector2d>& points, double angle_rad) {
  constexpr double kBin_m = 0.05;
  double squares = 0;
  for (const double turn : {0.0, std::numbers::pi / 2}) {
    const Vector2d axis(std::cos(angle_rad + turn), std::sin(angle_rad + turn));
    std::map<long, double> counts;
    for (const Vector2d& point : points) ++counts[std::lround(axis.dot(point) / kBin_m)];
    for (const auto& [bin, count] : counts) squares += count * count;
  }
  return squares;
}

// The direction, to a degree, along which or across which most walls run.
Vector2d direction_of_walls(const std::vector<Vector2d>& points) {
  constexpr std::size_t kEnough = 20'000;
  std::vector<Vector2d> some;
  for (std::size_t i = 0; i < points.size(); i += 1 + points.size() / kEnough) {
    some.push_back(points[i]);
  }
  double best_angle_rad = 0;
  double best = -1;
  for (int degrees = 0; degrees < 90; ++degrees) {
    const double angle_rad = degrees * std::numbers::pi / 180;
    const double value = gathering(some, angle_rad);
    if (value <= best) continue;
    best = value;
    best_angle_rad = angle_rad;
  }
  return {std::cos(best_angle_rad), std::sin(best_angle_rad)};
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

// The frame whose axes follow the walls, the first along the longer side, from where the walk
// begins.
GravityAlignedFrame frame_along_walls(const geometry::PointCloud& cloud,
                                      const std::vector<std::size_t>& kept,
                                      std::span<const Vector3d> cameras, const Vector3d& up) {
  const GravityAlignedFrame any = level_frame(up, up.unitOrthogonal());
  const Vector2d wall = direction_of_walls(on_plane(cloud, kept, any));
  GravityAlignedFrame level = level_frame(up, (any.transpose() * wall).normalized());
  const Bounds bounds = bounds_of(on_plane(cloud, kept, level), cameras, level);
  const Vector2d extent = bounds.high - bounds.low;
  Vector3d axis = level.row(extent.x() >= extent.y() ? 0 : 1);
  const Vector2d centre = (bounds.low + bounds.high) / 2;
  if (axis.dot(cameras.front()) > axis.dot(level.transpose() * centre)) axis = -axis;
  return level_frame(up, axis);
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
  ROOMWISE_CHECK_OK(options.validate());
  if (cameras.empty()) return fail("the map cannot be drawn: it has no key-frame");
  const auto kept = points_under_ceiling(cloud, cameras, up_world, options.cut_above_m);
  if (kept.empty()) return fail("the map cannot be drawn: it holds no point below the ceiling");

  const GravityAlignedFrame level = frame_along_walls(cloud, kept, cameras, up_world);
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
