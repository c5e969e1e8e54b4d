#include "roomwise/geometry/pinhole_camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <utility>

namespace roomwise::geometry {
namespace {

// Distorts a point of the plane z = 1.
Eigen::Vector2d distort(const LensDistortion& lens, const Eigen::Vector2d& p) {
  const double r2 = p.squaredNorm();
  const double radial = 1 + r2 * (lens.k1 + r2 * (lens.k2 + r2 * lens.k3));
  return {p.x() * radial + 2 * lens.p1 * p.x() * p.y() + lens.p2 * (r2 + 2 * p.x() * p.x()),
          p.y() * radial + lens.p1 * (r2 + 2 * p.y() * p.y()) + 2 * lens.p2 * p.x() * p.y()};
}

// False for NaN.
bool is_within(double value, double least, double most) {
  return value >= least && value <= most;
}

// Whether what lies farther out stays farther out, up to what the lens shows at `corner` (of the
// plane z = 1), and that lies within a tenth and ten times as far out.
bool is_unfolded_to(const LensDistortion& lens, const Eigen::Vector2d& corner) {
  constexpr int kStepsToCorner = 200;  // to the corner, without a lens
  constexpr int kMaxTimes = 10;
  const Eigen::Vector2d outwards = corner.normalized();
  double before = 0;
  int step = 0;
  while (before < corner.norm()) {
    const double shown = outwards.dot(distort(lens, corner * ++step / kStepsToCorner));
    if (!(shown > before) || step > kMaxTimes * kStepsToCorner) return false;
    before = shown;
  }
  return step >= kStepsToCorner / kMaxTimes;
}

auto tie(const PinholeCamera& c) {
  return std::tie(c.fx, c.fy, c.cx, c.cy, c.width, c.height, c.distortion.k1, c.distortion.k2,
                  c.distortion.p1, c.distortion.p2, c.distortion.k3, c.depth_units_per_metre);
}

}  // namespace

Expected<void> PinholeCamera::validate() const {
  if (width <= 0 || height <= 0) return fail("image size {}x{} must be positive", width, height);
  // From a fish-eye to a telescope; a pinhole camera of a room is far from both.
  constexpr double kMinWidths = 0.2, kMaxWidths = 5;
  for (const double f : {fx, fy}) {
    if (!is_within(f / width, kMinWidths, kMaxWidths)) {
      return fail(
          "focal lengths fx = {} px, fy = {} px cannot be: a camera of pictures {} px wide has "
          "{:g} "
          "to {:g} px",
          fx, fy, width, kMinWidths * width, kMaxWidths * width);
    }
  }
  if (!is_within(cx, -0.5, width - 0.5) || !is_within(cy, -0.5, height - 0.5)) {
    return fail("the principal point cx = {} px, cy = {} px lies outside the picture of {}x{} px",
                cx, cy, width, height);
  }
  constexpr double kMinUnits = 100, kMaxUnits = 100'000;  // centimetres, hundredths of a millimetre
  if (!is_within(depth_units_per_metre, kMinUnits, kMaxUnits)) {
    return fail(
        "depth_units_per_metre = {} cannot be: expected {} to {}, 1000 where depth is in mm",
        depth_units_per_metre, kMinUnits, kMaxUnits);
  }
  for (const double k :
       {distortion.k1, distortion.k2, distortion.p1, distortion.p2, distortion.k3}) {
    if (!std::isfinite(k)) return fail("distortion values must be finite, found {}", k);
  }
  if (distortion.is_none()) return {};
  for (const double x : {-0.5, width - 0.5}) {
    for (const double y : {-0.5, height - 0.5}) {
      if (is_unfolded_to(distortion, {(x - cx) / fx, (y - cy) / fy})) continue;
      const auto& [k1, k2, p1, p2, k3] = distortion;
      return fail(
          "the lens distortion k1 = {}, k2 = {}, p1 = {}, p2 = {}, k3 = {} cannot be: it folds the "
          "picture before its corner, or stretches it tenfold; give the values in this order, or "
          "all 0 where pictures are rectified",
          k1, k2, p1, p2, k3);
    }
  }
  return {};
}

std::optional<std::string> PinholeCamera::doubt() const {
  const double widths = fx / std::max(width, height);
  if (!is_within(widths, 0.4, 2)) {
    return fmt::format("a focal length of {:.4g} px is unusual for pictures of {}x{} px", fx, width,
                       height);
  }
  if (!is_within(fy / fx, 0.9, 1.1)) {
    return fmt::format("its pixels are far from square: fx = {:.4g}, fy = {:.4g}", fx, fy);
  }
  if (!is_within(cx / width, 0.3, 0.7) || !is_within(cy / height, 0.3, 0.7)) {
    return fmt::format("its principal point {:.4g}, {:.4g} is far from the middle of {}x{} px", cx,
                       cy, width, height);
  }
  if (!is_within(depth_units_per_metre, 1000, 10'000)) {
    return fmt::format("{:g} depth units per metre are unusual", depth_units_per_metre);
  }
  return std::nullopt;
}

Eigen::Vector2d PinholeCamera::project(const Eigen::Vector3d& point_camera) const {
  if (distortion.is_none()) return project_undistorted(point_camera);
  const Eigen::Vector2d p = distort(distortion, point_camera.head<2>() / point_camera.z());
  return {fx * p.x() + cx, fy * p.y() + cy};
}

Eigen::Vector2d PinholeCamera::undistort(const Eigen::Vector2d& pixel) const {
  if (distortion.is_none()) return pixel;
  const Eigen::Vector2d distorted((pixel.x() - cx) / fx, (pixel.y() - cy) / fy);
  // The fixed point converges in a handful of steps for lenses like the Kinect's; far outside the
  // image it may not, and the last value is then as good as any.
  constexpr int kMaxSteps = 30;
  constexpr double kConverged = 1e-12;
  Eigen::Vector2d p = distorted;
  for (int step = 0; step < kMaxSteps; ++step) {
    const Eigen::Vector2d error = distorted - distort(distortion, p);
    p += error;
    if (error.squaredNorm() < kConverged * kConverged) break;
  }
  return {fx * p.x() + cx, fy * p.y() + cy};
}

bool operator==(const PinholeCamera& a, const PinholeCamera& b) {
  return tie(a) == tie(b);
}

Expected<PinholeCamera> camera_preset(std::string_view name) {
  static const std::array<std::pair<std::string_view, PinholeCamera>, 5> kPresets{{
      {"fr1",
       {517.3, 516.5, 318.6, 255.3, 640, 480, {0.2624, -0.9531, -0.0054, 0.0026, 1.1633}, 5000}},
      {"fr2",
       {520.9, 521.0, 325.1, 249.7, 640, 480, {0.2312, -0.7849, -0.0033, -0.0001, 0.9172}, 5000}},
      {"fr3", {535.4, 539.2, 320.1, 247.6, 640, 480, {}, 5000}},
      {"kinect-v1", {525.0, 525.0, 319.5, 239.5, 640, 480, {}, 1000}},
      {"xtion", {525.0, 525.0, 319.5, 239.5, 640, 480, {}, 1000}},
  }};
  for (const auto& [preset, camera] : kPresets) {
    if (preset == name) return camera;
  }
  return fail("'{}' is not a camera preset; there are fr1, fr2, fr3, kinect-v1 and xtion", name);
}

}  // namespace roomwise::geometry
