#include "laboratory/simulation/home/scenario.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "laboratory/simulation/home/home_geometry.h"
#include "laboratory/simulation/home/moved_things.h"
#include "roomwise/base/random.h"

namespace roomwise::simulation {
namespace {

Eigen::Vector2d outward_of(const Window& window) {
  const double sign = window.outside_is_positive ? 1 : -1;
  return window.opening.along_x ? Eigen::Vector2d(0, sign) : Eigen::Vector2d(sign, 0);
}

// Towards a sun that shines through one of the windows.
std::optional<Eigen::Vector3d> sun_through_a_window(const HomeModel& home, double height_rad,
                                                    RandomStream& random) {
  if (home.windows.empty()) return std::nullopt;
  const Eigen::Vector2d outward = outward_of(home.windows[random.index(home.windows.size())]);
  const double aside = (random.uniform() - 0.5) * 1.6;
  const double azimuth = std::atan2(outward.y(), outward.x()) + aside;
  return Eigen::Vector3d(std::cos(azimuth) * std::cos(height_rad),
                         std::sin(azimuth) * std::cos(height_rad), std::sin(height_rad));
}

bool has_window(const HomeModel& home, std::size_t room) {
  return std::ranges::count(home.windows, room, &Window::room) > 0;
}

// How likely a light is lit.
double chance_lit(const HomeModel& home, const Light& light, Scenario scenario) {
  switch (scenario) {
    case Scenario::kDay:
    case Scenario::kMoved:
      if (!light.is_ceiling_panel) return 0.05;
      return has_window(home, light.room) ? 0.08 : 1;
    case Scenario::kEvening:
      if (!light.is_ceiling_panel) return 0.6;
      return has_window(home, light.room) ? 0.5 : 1;
    case Scenario::kNight:
    case Scenario::kMovedNight:
      break;
  }
  return light.is_ceiling_panel ? 0.75 : 0.8;
}

// The ceiling lights of a room have one switch.
void switch_lights(HomeModel& home, Scenario scenario, std::uint64_t seed) {
  for (std::size_t room = 0; room < home.rooms.size(); ++room) {
    RandomStream random(seed, {0x737769746368, room});
    const double ceiling_draw = random.uniform();
    bool any = false;
    for (Light& light : home.lights) {
      if (light.room != room) continue;
      const double draw = light.is_ceiling_panel ? ceiling_draw : random.uniform();
      light.is_on = draw < chance_lit(home, light, scenario);
      any = any || light.is_on;
    }
    const bool is_night = scenario == Scenario::kNight || scenario == Scenario::kMovedNight;
    if (any || !is_night) continue;
    for (Light& light : home.lights) {
      if (light.room == room && light.is_ceiling_panel) light.is_on = true;
    }
  }
}

std::optional<Eigen::Vector3d> sun_at(const HomeModel& home, Scenario scenario,
                                      std::uint64_t seed) {
  RandomStream random(seed, {0x73756e});
  switch (scenario) {
    case Scenario::kDay:
    case Scenario::kMoved:
      return sun_through_a_window(home, 0.55 + 0.35 * random.uniform(), random);
    case Scenario::kEvening: {
      const bool is_dusk = random.uniform() < 0.4;
      if (is_dusk) return std::nullopt;
      return sun_through_a_window(home, 0.1 + 0.14 * random.uniform(), random);
    }
    case Scenario::kNight:
    case Scenario::kMovedNight:
      break;
  }
  return std::nullopt;
}

}  // namespace

HomeModel apply_scenario(HomeModel by_day, Scenario scenario, std::uint64_t seed,
                         std::span<const FurnitureModel> models) {
  HomeModel home = std::move(by_day);
  home.scenario = scenario;
  if (scenario == Scenario::kMoved || scenario == Scenario::kMovedNight) {
    move_things(home, seed, models);
  }
  home.sun_direction = sun_at(home, scenario, seed);
  switch_lights(home, scenario, seed);
  return home;
}

}  // namespace roomwise::simulation
