#pragma once

#include <cstdint>
#include <span>

#include "laboratory/simulation/furniture/furniture_catalogue.h"
#include "laboratory/simulation/home/home_model.h"

namespace roomwise::simulation {

// A home, as generate_home() made it, at another time:
//   day          sun into a window, most lights off
//   evening      low warm sun or dusk, some lights
//   night        lamps and ceiling lights only
//   moved        by day; things moved between surfaces, chairs, bins and lamps shifted, doors at
//                other angles, some things gone and some new; large furniture stays
//   moved-night  moved, and night
// Objects keep their names; `models` are those that the home was made of.
[[nodiscard]] HomeModel apply_scenario(HomeModel by_day, Scenario scenario, std::uint64_t seed,
                                       std::span<const FurnitureModel> models);

}  // namespace roomwise::simulation
