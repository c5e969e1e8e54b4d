#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "laboratory/simulation/scene/noise.h"

namespace roomwise::simulation {

constexpr float kPi = std::numbers::pi_v<float>;
constexpr float kGap = 1e-3F;  // m: rays that gather light start and end this far from surfaces

// Points that fill the unit square evenly from the first on (an additive recurrence on the plastic
// number), shifted by a seed so that neighbours do not err alike.
class EvenPoints {
 public:
  explicit EvenPoints(std::uint32_t seed)
      : x_(unit_from_bits(scramble(seed))), y_(unit_from_bits(scramble(seed ^ 0x5bd1e995U))) {}

  [[nodiscard]] Eigen::Vector2f at(int index) const {
    const auto i = static_cast<double>(index);
    return {static_cast<float>(wrap(x_ + i * 0.7548776662466927)),
            static_cast<float>(wrap(y_ + i * 0.5698402909980532))};
  }

 private:
  static double wrap(double value) { return value - static_cast<double>(static_cast<int>(value)); }
  double x_, y_;
};

// Two unit vectors at right angles to a third.
struct TangentAxes {
  Eigen::Vector3f u, v;

  explicit TangentAxes(const Eigen::Vector3f& n) {
    const float sign = n.z() >= 0 ? 1.0F : -1.0F;
    const float a = -1 / (sign + n.z());
    const float b = n.x() * n.y() * a;
    u = {1 + sign * n.x() * n.x() * a, sign * b, -sign * n.x()};
    v = {b, sign + n.y() * n.y() * a, -n.y()};
  }
};

// A direction about `normal` with density cosine / pi.
inline Eigen::Vector3f cosine_direction(const Eigen::Vector3f& normal, const TangentAxes& axes,
                                        const Eigen::Vector2f& point) {
  const float radius = std::sqrt(point.x());
  const float angle = 2 * kPi * point.y();
  const float height = std::sqrt(std::max(0.0F, 1 - point.x()));
  return radius * std::cos(angle) * axes.u + radius * std::sin(angle) * axes.v + height * normal;
}

}  // namespace roomwise::simulation
