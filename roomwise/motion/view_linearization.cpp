#include "roomwise/motion/view_linearization.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "roomwise/base/simd.h"

namespace roomwise::motion {
namespace {

using geometry::RigidTransform;

// Pixels next to each other err alike: so many count as one measurement.
constexpr double kPixelsPerMeasurement = 20;

// A residual costs no more than this (sigmas squared), however bad.
constexpr float kMaxCost = 9;

// The current view with its brightness and gradient ready to be read between pixels.
class BrightnessField {
 public:
  explicit BrightnessField(const image::GrayImage& gray) : gray_(gray) {}

  // At a place at least a pixel within the border: brightness, and its slopes by x and y.
  [[nodiscard]] Eigen::Vector3f at(float x, float y) const {
    const int left = static_cast<int>(x);
    const int top = static_cast<int>(y);
    const float u = x - static_cast<float>(left);
    const float v = y - static_cast<float>(top);
    const float a = gray_.at(left, top), b = gray_.at(left + 1, top);
    const float c = gray_.at(left, top + 1), d = gray_.at(left + 1, top + 1);
    return {(1 - v) * ((1 - u) * a + u * b) + v * ((1 - u) * c + u * d),
            (1 - v) * (b - a) + v * (d - c), (1 - u) * (c - a) + u * (d - b)};
  }

 private:
  const image::GrayImage& gray_;
};

float huber_weight(float sigmas) {
  constexpr float kHuber = 1.5F;
  return std::abs(sigmas) <= kHuber ? 1.0F : kHuber / std::abs(sigmas);
}

// The sum of w j j^T over rows j = (derivatives by a twist, error, 0): hessian, gradient and
// squares in one. Eight numbers are as many registers as the instructions need.
template <Simd simd>
class RowSums {
 public:
  [[gnu::always_inline]] void add(float weight, const Eigen::Vector3f& by_turning,
                                  const Eigen::Vector3f& by_moving, float error) {
    Row row, weighted;
    fill(row, by_turning, by_moving, error);
    for (std::size_t k = 0; k < kParts; ++k) weighted[k] = weight * row[k];
#pragma GCC unroll 7
    for (std::size_t i = 0; i < sums_.size(); ++i) {
      const float factor = weighted[i / kCount][i % kCount];
      for (std::size_t k = 0; k < kParts; ++k) sums_[i][k] += factor * row[k];
    }
  }
  void add_to(NormalEquations& equations) const {
    for (std::size_t i = 0; i < 6; ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      const auto sum = [&](std::size_t k) {
        return static_cast<double>(sums_[i][k / kCount][k % kCount]);
      };
      for (std::size_t k = 0; k < 6; ++k)
        equations.hessian(row, static_cast<Eigen::Index>(k)) += sum(k);
      equations.gradient[row] += sum(6);
    }
  }

 private:
  static constexpr std::size_t kCount = Lanes<simd>::kCount, kParts = 8 / kCount;
  using Row = std::array<typename Lanes<simd>::Float, kParts>;
  [[gnu::always_inline]] static void fill(Row& row, const Eigen::Vector3f& a,
                                          const Eigen::Vector3f& b, float error) {
    if constexpr (kParts == 1) {
      row[0] = Float8{a.x(), a.y(), a.z(), b.x(), b.y(), b.z(), error, 0};
    } else {
      row[0] = Float4{a.x(), a.y(), a.z(), b.x()};
      row[1] = Float4{b.y(), b.z(), error, 0};
    }
  }

  std::array<Row, 7> sums_{};
};

// With `only_exposure` the rows of errors are left out, and with them most of the work.
template <Simd simd, bool only_exposure>
[[gnu::always_inline]] inline NormalEquations sum_rows(const std::vector<SurfacePoint>& points,
                                                       const PyramidLevel& current,
                                                       const RigidTransform& current_from_reference,
                                                       const Exposure& exposure,
                                                       double max_correspondence_m,
                                                       const ViewAlignmentOptions& options) {
  const geometry::PinholeCamera& camera = current.camera;
  const Eigen::Matrix3f rotation = current_from_reference.rotation_matrix().cast<float>();
  const Eigen::Vector3f translation = current_from_reference.translation.cast<float>();
  const auto fx = static_cast<float>(camera.fx), fy = static_cast<float>(camera.fy);
  const auto cx = static_cast<float>(camera.cx), cy = static_cast<float>(camera.cy);
  const float inverse_fx = 1 / fx, inverse_fy = 1 / fy;
  const auto right = static_cast<float>(camera.width - 2);
  const auto bottom = static_cast<float>(camera.height - 2);
  const auto unit_m = static_cast<float>(1 / camera.depth_units_per_metre);
  const auto gray_variance = static_cast<float>(options.gray_sigma * options.gray_sigma);
  const auto place_variance = static_cast<float>(options.place_sigma_px * options.place_sigma_px);
  const auto sigma_at_1m = static_cast<float>(options.depth_sigma_m);
  const auto min_slope2 = static_cast<float>(options.min_gray_slope * options.min_gray_slope);
  const auto max_apart_m = static_cast<float>(max_correspondence_m);
  const BrightnessField brightness(current.gray);
  NormalEquations equations;
  double sum_r = 0, sum_c = 0, sum_rr = 0, sum_rc = 0;
  double cost = 0, squares = 0;
  std::size_t pairs = 0, others = 0, measured = 0;
  constexpr std::size_t kBlock = 512;  // summed in float, then in double
  for (std::size_t first = 0; first < points.size(); first += kBlock) {
    RowSums<simd> sums;
    float r = 0, c = 0, rr = 0, rc = 0, block_cost = 0, block_squares = 0;
    const std::size_t end = std::min(points.size(), first + kBlock);
    for (std::size_t i = first; i < end; ++i) {
      const SurfacePoint& surface = points[i];
      const Eigen::Vector3f p = rotation * surface.point + translation;
      if (!(p.z() > 0.1F)) continue;
      const float inverse_z = 1 / p.z();
      const float u = fx * p.x() * inverse_z + cx;
      const float v = fy * p.y() * inverse_z + cy;
      if (!(u >= 1 && v >= 1 && u < right && v < bottom)) continue;
      const int column = static_cast<int>(u + 0.5F), row = static_cast<int>(v + 0.5F);
      const float depth = static_cast<float>(current.depth.at(column, row)) * unit_m;
      if (!(depth > 0)) continue;
      const float sigma = sigma_at_1m * std::max(0.5F, depth * depth);
      const Eigen::Vector3f q((static_cast<float>(column) - cx) * inverse_fx * depth,
                              (static_cast<float>(row) - cy) * inverse_fy * depth, depth);
      const Eigen::Vector3f normal = rotation * surface.normal;
      const float distance = normal.dot(p - q);
      // Another surface: nothing to compare.
      const float most = max_apart_m + 3 * sigma;
      if (std::abs(p.z() - depth) > 3 * most || std::abs(distance) > most) {
        ++others;
        continue;
      }
      const auto add = [&](const Eigen::Vector3f& by_point, float error)
          __attribute__((always_inline)) {
        const float weight = huber_weight(error);
        sums.add(weight,
                 {p.y() * by_point.z() - p.z() * by_point.y(),
                  p.z() * by_point.x() - p.x() * by_point.z(),
                  p.x() * by_point.y() - p.y() * by_point.x()},
                 by_point, error);
        block_cost += std::min(weight * error * error, kMaxCost);
        block_squares += error * error;
        ++measured;
      };
      if (!only_exposure && surface.has_normal) {
        // The error along the ray counts as far as the surface faces it.
        const float facing = std::abs(normal.dot(q)) / q.norm();
        const float scale = 1 / (sigma * std::max(facing, 0.3F));
        add(scale * normal, scale * distance);
      }
      const Eigen::Vector3f seen = brightness.at(u, v);
      r += surface.gray;
      c += seen[0];
      rr += surface.gray * surface.gray;
      rc += surface.gray * seen[0];
      ++pairs;
      if constexpr (only_exposure) continue;
      // On a plain surface noise would pass for something seen.
      const float slope2 = seen[1] * seen[1] + seen[2] * seen[2];
      if (slope2 < min_slope2) continue;
      const float gray_weight = 1 / std::sqrt(gray_variance + place_variance * slope2);
      const float by_u = seen[1] * fx * inverse_z;
      const float by_v = seen[2] * fy * inverse_z;
      add(gray_weight * Eigen::Vector3f(by_u, by_v, -(by_u * p.x() + by_v * p.y()) * inverse_z),
          gray_weight * (seen[0] - exposure.gain * surface.gray - exposure.offset));
    }
    sums.add_to(equations);
    sum_r += static_cast<double>(r);
    sum_c += static_cast<double>(c);
    sum_rr += static_cast<double>(rr);
    sum_rc += static_cast<double>(rc);
    cost += static_cast<double>(block_cost);
    squares += static_cast<double>(block_squares);
  }
  equations.hessian /= kPixelsPerMeasurement;
  equations.gradient /= kPixelsPerMeasurement;
  equations.squares = squares;
  equations.measured = measured;
  const auto compared = static_cast<double>(pairs + others);
  equations.cost =
      compared > 0
          ? (cost + 2.0 * static_cast<double>(kMaxCost) * static_cast<double>(others)) / compared
          : std::numeric_limits<double>::infinity();
  if (pairs > 0) {
    // Regression of the current brightness on the reference's, drawn towards no change where the
    // brightness hardly varies.
    const auto count = static_cast<double>(pairs);
    const double mean_r = sum_r / count, mean_c = sum_c / count;
    const double variance = sum_rr / count - mean_r * mean_r;
    const double covariance = sum_rc / count - mean_r * mean_c;
    constexpr double kPull = 400;  // grey levels squared
    const double gain = std::clamp((covariance + kPull) / (variance + kPull), 0.4, 2.5);
    equations.exposure = {static_cast<float>(gain), static_cast<float>(mean_c - gain * mean_r)};
  }
  return equations;
}

#if defined(__x86_64__)
// The same code, eight numbers at a time: the same bits.
template <bool only_exposure>
__attribute__((target("avx2"))) NormalEquations sum_rows_avx2(
    const std::vector<SurfacePoint>& points, const PyramidLevel& current,
    const RigidTransform& current_from_reference, const Exposure& exposure,
    double max_correspondence_m, const ViewAlignmentOptions& options) {
  return sum_rows<Simd::kAvx2, only_exposure>(points, current, current_from_reference, exposure,
                                              max_correspondence_m, options);
}
#endif

template <bool only_exposure>
NormalEquations sum_rows_quickly(const std::vector<SurfacePoint>& points,
                                 const PyramidLevel& current,
                                 const RigidTransform& current_from_reference,
                                 const Exposure& exposure, double max_correspondence_m,
                                 const ViewAlignmentOptions& options) {
#if defined(__x86_64__)
  if (process_simd() == Simd::kAvx2) {
    return sum_rows_avx2<only_exposure>(points, current, current_from_reference, exposure,
                                        max_correspondence_m, options);
  }
#elif defined(__aarch64__)
  if (process_simd() == Simd::kNeon) {
    return sum_rows<Simd::kNeon, only_exposure>(points, current, current_from_reference, exposure,
                                                max_correspondence_m, options);
  }
#endif
  return sum_rows<Simd::kPortable, only_exposure>(points, current, current_from_reference, exposure,
                                                  max_correspondence_m, options);
}

}  // namespace

std::vector<SurfacePoint> surface_points(const PyramidLevel& view, int stride) {
  const geometry::PinholeCamera& camera = view.camera;
  const auto point_at = [&](int x, int y) {
    return camera.unproject_undistorted({x, y}, view.depth.at(x, y) / camera.depth_units_per_metre);
  };
  std::vector<SurfacePoint> points;
  points.reserve(view.depth.pixels().size());
  for (int y = 1; y + 1 < view.depth.height(); ++y) {
    for (int x = 1; x + 1 < view.depth.width(); ++x) {
      if ((x + (y % 2) * (stride / 2)) % stride != 0 || view.depth.at(x, y) == 0) continue;
      SurfacePoint& point = points.emplace_back();
      const Eigen::Vector3d here = point_at(x, y);
      point.point = here.cast<float>();
      point.gray = view.gray.at(x, y);
      point.normal.setZero();
      const auto same_surface = [&](int u, int v) {
        constexpr double kStep = 0.05;  // of the distance, from one pixel to the next
        return view.depth.at(u, v) != 0 &&
               std::abs(view.depth.at(u, v) - view.depth.at(x, y)) <= kStep * view.depth.at(x, y);
      };
      if (!same_surface(x - 1, y) || !same_surface(x + 1, y) || !same_surface(x, y - 1) ||
          !same_surface(x, y + 1)) {
        continue;
      }
      const Eigen::Vector3d normal =
          (point_at(x + 1, y) - point_at(x - 1, y)).cross(point_at(x, y + 1) - point_at(x, y - 1));
      // Seen at a glance, a surface's depth says little.
      constexpr double kMinCosine = 0.15;
      if (std::abs(normal.dot(here)) > kMinCosine * normal.norm() * here.norm()) {
        point.normal = normal.normalized().cast<float>();
        point.has_normal = true;
      }
    }
  }
  return points;
}

NormalEquations linearize(const std::vector<SurfacePoint>& points, const PyramidLevel& current,
                          const RigidTransform& current_from_reference, const Exposure& exposure,
                          double max_correspondence_m, const ViewAlignmentOptions& options) {
  return sum_rows_quickly<false>(points, current, current_from_reference, exposure,
                                 max_correspondence_m, options);
}

Exposure find_exposure(const std::vector<SurfacePoint>& points, const PyramidLevel& current,
                       const RigidTransform& current_from_reference, double max_correspondence_m,
                       const ViewAlignmentOptions& options) {
  return sum_rows_quickly<true>(points, current, current_from_reference, {}, max_correspondence_m,
                                options)
      .exposure;
}

}  // namespace roomwise::motion
