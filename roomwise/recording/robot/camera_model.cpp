#include "roomwise/recording/robot/camera_model.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace roomwise::recording {
namespace {

using Eigen::Vector2d;
using geometry::LensDistortion;
using geometry::PinholeCamera;

constexpr double kMaxFitError_px = 1;
constexpr int kGridSteps = 24;  // a side of the picture, for the fit

enum class LensModel { kNone, kBrown, kRational, kInverseBrown, kModifiedBrown, kOther };

// "plumb_bob" of ROS, "Inverse Brown Conrady" of RealSense.
LensModel lens_model_named(std::string name) {
  std::ranges::transform(name, name.begin(), [](unsigned char c) {
    return c == ' ' ? '_' : static_cast<char>(std::tolower(c));
  });
  if (name.empty() || name == "none") return LensModel::kNone;
  if (name == "plumb_bob" || name == "brown_conrady") return LensModel::kBrown;
  if (name == "rational_polynomial") return LensModel::kRational;
  if (name == "inverse_brown_conrady") return LensModel::kInverseBrown;
  if (name == "modified_brown_conrady") return LensModel::kModifiedBrown;
  return LensModel::kOther;
}

// Coefficients in OpenCV's order: k1 k2 p1 p2 k3 k4 k5 k6.
using Coefficients = std::array<double, 8>;

Vector2d brown(const Coefficients& c, const Vector2d& p) {
  const double r2 = p.squaredNorm();
  const double radial =
      (1 + r2 * (c[0] + r2 * (c[1] + r2 * c[4]))) / (1 + r2 * (c[5] + r2 * (c[6] + r2 * c[7])));
  return {p.x() * radial + 2 * c[2] * p.x() * p.y() + c[3] * (r2 + 2 * p.x() * p.x()),
          p.y() * radial + c[2] * (r2 + 2 * p.y() * p.y()) + 2 * c[3] * p.x() * p.y()};
}

// The tangential part sees the point after the radial one.
Vector2d modified_brown(const Coefficients& c, const Vector2d& p) {
  const double r2 = p.squaredNorm();
  const Vector2d q = p * (1 + r2 * (c[0] + r2 * (c[1] + r2 * c[4])));
  return {q.x() + 2 * c[2] * q.x() * q.y() + c[3] * (r2 + 2 * q.x() * q.x()),
          q.y() + 2 * c[3] * q.x() * q.y() + c[2] * (r2 + 2 * q.y() * q.y())};
}

// A point without the lens, and where the lens shows it, both on the plane at distance 1.
struct LensPair {
  Vector2d ideal, seen;
};

std::vector<LensPair> lens_pairs(const PinholeCamera& camera, LensModel model,
                                 const Coefficients& c) {
  std::vector<LensPair> pairs;
  for (int i = 0; i <= kGridSteps; ++i) {
    for (int j = 0; j <= kGridSteps; ++j) {
      const Vector2d p((camera.width * i / double{kGridSteps} - 0.5 - camera.cx) / camera.fx,
                       (camera.height * j / double{kGridSteps} - 0.5 - camera.cy) / camera.fy);
      if (model == LensModel::kInverseBrown) {
        pairs.push_back({brown(c, p), p});
      } else {
        pairs.push_back(
            {p, model == LensModel::kModifiedBrown ? modified_brown(c, p) : brown(c, p)});
      }
    }
  }
  return pairs;
}

// Brown's model is linear in its coefficients.
LensDistortion fit_brown(const std::vector<LensPair>& pairs) {
  Eigen::MatrixXd a(2 * static_cast<Eigen::Index>(pairs.size()), 5);
  Eigen::VectorXd b(a.rows());
  Eigen::Index row = 0;
  for (const auto& [p, seen] : pairs) {
    const double x = p.x(), y = p.y(), r2 = p.squaredNorm();
    const double r4 = r2 * r2, r6 = r4 * r2;
    a.row(row) << x * r2, x * r4, 2 * x * y, r2 + 2 * x * x, x * r6;
    b[row++] = seen.x() - x;
    a.row(row) << y * r2, y * r4, r2 + 2 * y * y, 2 * x * y, y * r6;
    b[row++] = seen.y() - y;
  }
  const Eigen::VectorXd c = a.colPivHouseholderQr().solve(b);
  return {c[0], c[1], c[2], c[3], c[4]};
}

double worst_error_px(const PinholeCamera& camera, const std::vector<LensPair>& pairs) {
  const LensDistortion& lens = camera.distortion;
  double worst = 0;
  for (const auto& [ideal, seen] : pairs) {
    const Vector2d fitted = brown({lens.k1, lens.k2, lens.p1, lens.p2, lens.k3, 0, 0, 0}, ideal);
    worst = std::max(worst,
                     std::hypot(camera.fx * (fitted - seen).x(), camera.fy * (fitted - seen).y()));
  }
  return worst;
}

Expected<LensDistortion> lens_of(const CameraInfoMessage& info, PinholeCamera camera) {
  Coefficients c{};
  const auto& given = info.distortion;
  if (!std::ranges::all_of(given, [](double one) { return std::isfinite(one); })) {
    return fail("its lens has coefficients that are no numbers");
  }
  if (std::ranges::all_of(given, [](double one) { return one == 0; })) return LensDistortion{};
  const LensModel model = lens_model_named(info.distortion_model);
  const bool has_more =
      given.size() > c.size() &&
      std::ranges::any_of(std::span(given).subspan(c.size()), [](double one) { return one != 0; });
  if (model == LensModel::kOther || model == LensModel::kNone || has_more) {
    return fail(
        "its lens is described by '{}' with {} coefficients, which is not read; record the "
        "rectified images",
        info.distortion_model, given.size());
  }
  std::ranges::copy_n(given.begin(), static_cast<std::ptrdiff_t>(std::min(given.size(), c.size())),
                      c.begin());
  const bool is_plain = model == LensModel::kBrown || model == LensModel::kRational;
  if (is_plain && c[5] == 0 && c[6] == 0 && c[7] == 0)
    return LensDistortion{c[0], c[1], c[2], c[3], c[4]};
  const auto pairs = lens_pairs(camera, model, c);
  camera.distortion = fit_brown(pairs);
  const double error_px = worst_error_px(camera, pairs);
  if (!(error_px <= kMaxFitError_px)) {
    return fail(
        "its lens ('{}') differs by {:.1f} px from Brown's model; record the rectified images",
        info.distortion_model, error_px);
  }
  return camera.distortion;
}

constexpr std::uint32_t kMaxCameraSide = 65'535;

}  // namespace

Expected<PinholeCamera> camera_of(const CameraInfoMessage& info, bool is_rectified) {
  const bool has_projection = is_rectified && info.p[0] > 0;
  PinholeCamera camera;
  camera.fx = has_projection ? info.p[0] : info.k[0];
  camera.cx = has_projection ? info.p[2] : info.k[2];
  camera.fy = has_projection ? info.p[5] : info.k[4];
  camera.cy = has_projection ? info.p[6] : info.k[5];
  if (info.width > kMaxCameraSide || info.height > kMaxCameraSide) {
    return fail("the camera claims {}x{} pixels", info.width, info.height);
  }
  camera.width = static_cast<int>(info.width);
  camera.height = static_cast<int>(info.height);
  if (auto valid = camera.validate(); !valid) return Unexpected(std::move(valid).error());
  if (!is_rectified) {
    ROOMWISE_TRY(camera.distortion, lens_of(info, camera));
  }
  return camera;
}

}  // namespace roomwise::recording
