#pragma once

#include <Eigen/Core>
#include <vector>

#include "laboratory/simulation/home/home_model.h"

namespace roomwise::simulation {

// The bright hole of a window: its rectangle on the outer face of the wall.
struct WindowHole {
  Eigen::Vector3f center;
  Eigen::Vector3f along;    // unit length, level
  Eigen::Vector3f inwards;  // unit length, into the room
  float half_width_m = 0, half_height_m = 0;
  std::size_t room = 0;

  // Whether a ray from inside leaves the home through the hole.
  [[nodiscard]] bool passes(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction) const;
};

// What lies outside the windows, infinitely far: the sky and blurred greenery below it, by
// scenario. Radiance in cd/m^2, illuminance in lux.
class Outside {
 public:
  explicit Outside(const HomeModel& home);

  [[nodiscard]] Eigen::Vector3f radiance(const Eigen::Vector3f& direction) const;
  // The same without clouds, leaves and houses, for the light that falls into the rooms; the
  // direction must have unit length.
  [[nodiscard]] Eigen::Vector3f mean_radiance(const Eigen::Vector3f& direction) const;
  // The sun's illuminance on a surface that faces it; zero when it is down.
  [[nodiscard]] const Eigen::Vector3f& sun_illuminance() const { return sun_illuminance_; }
  // Towards the sun; only meaningful where sun_illuminance() is not zero.
  [[nodiscard]] const Eigen::Vector3f& sun_direction() const { return sun_direction_; }
  [[nodiscard]] bool has_sun() const { return sun_illuminance_.maxCoeff() > 0; }

  [[nodiscard]] const std::vector<WindowHole>& windows() const { return windows_; }
  [[nodiscard]] bool seen_through_a_window(const Eigen::Vector3f& origin,
                                           const Eigen::Vector3f& direction) const;

 private:
  std::vector<WindowHole> windows_;
  Eigen::Vector3f sun_direction_ = Eigen::Vector3f::UnitZ();
  Eigen::Vector3f sun_illuminance_ = Eigen::Vector3f::Zero();
  Eigen::Vector3f zenith_, horizon_;
  Eigen::Vector3f green_light_;  // what falls on the greenery, as seen from it: times its albedo
  float lit_windows_ = 0;        // radiance of lit windows of other houses
  std::uint32_t seed_;
};

}  // namespace roomwise::simulation
