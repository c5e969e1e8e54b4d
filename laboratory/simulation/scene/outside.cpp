#include "laboratory/simulation/scene/outside.h"

#include <cmath>

#include "laboratory/simulation/scene/color_math.h"
#include "laboratory/simulation/scene/noise.h"

namespace roomwise::simulation {
namespace {

WindowHole hole_of(const Window& window, double wall_thickness_m) {
  const WallOpening& opening = window.opening;
  const double side = (window.outside_is_positive ? 1 : -1) * wall_thickness_m / 2;
  WindowHole hole;
  hole.along = opening.along_x ? Eigen::Vector3f::UnitX() : Eigen::Vector3f::UnitY();
  const Eigen::Vector3f across =
      opening.along_x ? Eigen::Vector3f::UnitY() : Eigen::Vector3f::UnitX();
  hole.inwards = window.outside_is_positive ? Eigen::Vector3f(-across) : across;
  hole.center = Eigen::Vector3f(
                    static_cast<float>(opening.center.x()), static_cast<float>(opening.center.y()),
                    static_cast<float>(opening.floor_m + (opening.bottom_m + opening.top_m) / 2)) +
                static_cast<float>(side) * across;
  hole.half_width_m = static_cast<float>(opening.width_m / 2);
  hole.half_height_m = static_cast<float>((opening.top_m - opening.bottom_m) / 2);
  hole.room = window.room;
  return hole;
}

bool is_night(Scenario scenario) {
  return scenario == Scenario::kNight || scenario == Scenario::kMovedNight;
}

}  // namespace

bool WindowHole::passes(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction) const {
  const float closing = -inwards.dot(direction);
  if (closing <= 1e-6F) return false;
  const float distance = inwards.dot(origin - center) / closing;
  if (distance < 0) return false;
  const Eigen::Vector3f offset = origin + distance * direction - center;
  return std::abs(offset.z()) <= half_height_m && std::abs(along.dot(offset)) <= half_width_m;
}

Outside::Outside(const HomeModel& home) : seed_(static_cast<std::uint32_t>(home.seed)) {
  for (const Window& window : home.windows) {
    windows_.push_back(hole_of(window, home.wall_thickness_m));
  }
  const bool evening = home.scenario == Scenario::kEvening;
  if (is_night(home.scenario)) {
    zenith_ = {0.05F, 0.08F, 0.18F};
    horizon_ = {0.35F, 0.30F, 0.32F};
    green_light_ = {0.4F, 0.35F, 0.3F};
    lit_windows_ = 12;
    return;
  }
  if (evening) {
    zenith_ = {60, 95, 190};
    horizon_ = {340, 230, 160};
    green_light_ = {150, 130, 120};
    lit_windows_ = 120;
  } else {
    zenith_ = {900, 1350, 2100};
    horizon_ = {2300, 2500, 2700};
    green_light_ = {1500, 1450, 1300};
  }
  if (!home.sun_direction || home.sun_direction->z() <= 0) return;
  sun_direction_ = home.sun_direction->cast<float>().normalized();
  // Light of a low sun is weaker and redder: it crosses more air.
  const double air = 1 / std::max(0.05, home.sun_direction->z());
  const Eigen::Vector3f loss(static_cast<float>(std::exp(-0.08 * air)),
                             static_cast<float>(std::exp(-0.13 * air)),
                             static_cast<float>(std::exp(-0.23 * air)));
  sun_illuminance_ = (evening ? 2500.0F : 9000.0F) * loss;
}

bool Outside::seen_through_a_window(const Eigen::Vector3f& origin,
                                    const Eigen::Vector3f& direction) const {
  for (const WindowHole& window : windows_) {
    if (window.passes(origin, direction)) return true;
  }
  return false;
}

Eigen::Vector3f Outside::mean_radiance(const Eigen::Vector3f& direction) const {
  const Eigen::Vector3f sky = mix(horizon_, zenith_, smooth_step(-0.05F, 0.85F, direction.z()));
  const Eigen::Vector3f green = Eigen::Vector3f(0.16F, 0.19F, 0.13F).cwiseProduct(green_light_);
  return mix(green, sky, smooth_step(0.06F, 0.16F, direction.z()));
}

Eigen::Vector3f Outside::radiance(const Eigen::Vector3f& direction) const {
  const Eigen::Vector3f d = direction.normalized();
  const float turn = std::atan2(d.y(), d.x());
  const float height = std::asin(std::min(1.0F, std::max(-1.0F, d.z())));
  const Eigen::Vector3f sky = mix(horizon_, zenith_, smooth_step(-0.05F, 1.0F, height));
  const float cloud = smooth_step(0.0F, 0.5F, layered_noise(4 * turn, 9 * height, seed_ + 1, 3));
  const Eigen::Vector3f clouded = mix(sky, horizon_, 0.5F * cloud);

  // Trees, out of focus: a soft skyline and soft patches of leaves and shade.
  const float skyline = 0.11F + 0.12F * layered_noise(3 * turn, 0.5F, seed_ + 2, 3);
  const float leaves = 0.5F + 0.5F * layered_noise(14 * turn, 14 * height, seed_ + 3, 3);
  const Eigen::Vector3f tree =
      mix(Eigen::Vector3f(0.05F, 0.08F, 0.045F), Eigen::Vector3f(0.17F, 0.23F, 0.12F), leaves);
  const Eigen::Vector3f lawn = Eigen::Vector3f(0.15F, 0.2F, 0.11F) *
                               (1 + 0.3F * layered_noise(9 * turn, 20 * height, seed_ + 4, 2));
  const Eigen::Vector3f green = mix(lawn, tree, smooth_step(-0.16F, -0.08F, height));
  const float cover = smooth_step(-0.02F, 0.02F, skyline - height);
  Eigen::Vector3f light = mix(clouded, green.cwiseProduct(green_light_), cover);
  if (lit_windows_ > 0 && height < skyline && height > -0.1F) {
    const float x = 26 * turn, y = 30 * height;
    if (unit_hash(floor_to_int(x), floor_to_int(y), seed_ + 5) > 0.93F) {
      const float fx = std::abs(fraction(x) - 0.5F), fy = std::abs(fraction(y) - 0.5F);
      const float pane = (1 - smooth_step(0.12F, 0.3F, fx)) * (1 - smooth_step(0.15F, 0.35F, fy));
      light += lit_windows_ * pane * Eigen::Vector3f(1.0F, 0.66F, 0.3F);
    }
  }
  return light;
}

}  // namespace roomwise::simulation
