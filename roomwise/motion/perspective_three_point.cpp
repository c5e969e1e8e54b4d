#include "roomwise/motion/perspective_three_point.h"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace roomwise::motion {
namespace {

// The real roots of c[4] x^4 + ... + c[0], as eigenvalues of the companion matrix, polished by
// Newton's method.
std::vector<double> real_roots(const std::array<double, 5>& c) {
  constexpr double kVanishes = 1e-12;
  if (!(std::abs(c[4]) > kVanishes)) return {};
  Eigen::Matrix4d companion = Eigen::Matrix4d::Zero();
  companion.diagonal(-1).setOnes();
  for (int i = 0; i < 4; ++i) companion(i, 3) = -c[static_cast<std::size_t>(i)] / c[4];
  const Eigen::Vector4cd eigenvalues = companion.eigenvalues();

  std::vector<double> roots;
  for (const std::complex<double>& value : eigenvalues) {
    // A double root leaves the real axis by the square root of the rounding errors.
    constexpr double kNearlyReal = 1e-4;
    if (std::abs(value.imag()) > kNearlyReal * (1 + std::abs(value.real()))) continue;
    double x = value.real();
    for (int step = 0; step < 2; ++step) {
      const double f = (((c[4] * x + c[3]) * x + c[2]) * x + c[1]) * x + c[0];
      const double slope = ((4 * c[4] * x + 3 * c[3]) * x + 2 * c[2]) * x + c[1];
      if (slope != 0) x -= f / slope;
    }
    roots.push_back(x);
  }
  return roots;
}

// An orthonormal frame spanned by three points: its origin the first, x towards the second.
Eigen::Matrix3d frame_of(const std::array<Eigen::Vector3d, 3>& points) {
  Eigen::Matrix3d frame;
  frame.col(0) = (points[1] - points[0]).normalized();
  frame.col(2) = frame.col(0).cross(points[2] - points[0]).normalized();
  frame.col(1) = frame.col(2).cross(frame.col(0));
  return frame;
}

}  // namespace

std::vector<geometry::RigidTransform> solve_p3p(const std::array<Eigen::Vector3d, 3>& points,
                                                const std::array<Eigen::Vector3d, 3>& rays) {
  const double a2 = (points[1] - points[2]).squaredNorm();
  const double b2 = (points[0] - points[2]).squaredNorm();
  const double c2 = (points[0] - points[1]).squaredNorm();
  const double area2 = (points[1] - points[0]).cross(points[2] - points[0]).squaredNorm();
  constexpr double kDegenerate = 1e-10;
  if (!(area2 > kDegenerate * b2 * c2)) return {};

  // With s1, s2 = u s1 and s3 = v s1 the distances along the rays, the three laws of cosines lead
  // to a quartic in v. Names as in Haralick et al.
  const double cos_alpha = rays[1].dot(rays[2]);
  const double cos_beta = rays[0].dot(rays[2]);
  const double cos_gamma = rays[0].dot(rays[1]);
  const double q = (a2 - c2) / b2;
  const double sum = (a2 + c2) / b2;
  const auto square = [](double x) { return x * x; };
  const std::array<double, 5> quartic{
      square(1 + q) - 4 * a2 / b2 * square(cos_gamma),
      4 * (-q * (1 + q) * cos_beta + 2 * a2 / b2 * square(cos_gamma) * cos_beta -
           (1 - sum) * cos_alpha * cos_gamma),
      2 * (square(q) - 1 + 2 * square(q) * square(cos_beta) +
           2 * (b2 - c2) / b2 * square(cos_alpha) - 4 * sum * cos_alpha * cos_beta * cos_gamma +
           2 * (b2 - a2) / b2 * square(cos_gamma)),
      4 * (q * (1 - q) * cos_beta - (1 - sum) * cos_alpha * cos_gamma +
           2 * c2 / b2 * square(cos_alpha) * cos_beta),
      square(q - 1) - 4 * c2 / b2 * square(cos_alpha)};

  std::vector<geometry::RigidTransform> solutions;
  const Eigen::Matrix3d points_frame = frame_of(points);
  for (const double v : real_roots(quartic)) {
    const double denominator = 2 * (cos_gamma - v * cos_alpha);
    const double s1_squared = b2 / (1 + v * v - 2 * v * cos_beta);
    if (denominator == 0 || !(s1_squared > 0)) continue;
    const double u = ((q - 1) * v * v - 2 * q * cos_beta * v + 1 + q) / denominator;
    if (!(u > 0) || !(v > 0)) continue;  // a point behind the camera
    const double s1 = std::sqrt(s1_squared);
    const std::array<Eigen::Vector3d, 3> points_camera{s1 * rays[0], u * s1 * rays[1],
                                                       v * s1 * rays[2]};
    const Eigen::Matrix3d rotation = frame_of(points_camera) * points_frame.transpose();
    if (!rotation.allFinite()) continue;
    solutions.push_back(
        geometry::RigidTransform::from_matrix(rotation, points_camera[0] - rotation * points[0]));
  }
  return solutions;
}

}  // namespace roomwise::motion
