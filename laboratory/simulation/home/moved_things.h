#pragma once

#include <cstdint>
#include <span>

#include "laboratory/simulation/furniture/furniture_catalogue.h"
#include "laboratory/simulation/home/home_model.h"

namespace roomwise::simulation {

// What people change in a home from one day to the next: small things go from one surface to
// another, chairs, bins and lamps are shifted and turned, doors stand at other angles, some things
// are gone, some are new. Everything stays reachable, nothing goes into anything. Large furniture
// stays; what remains keeps its name.
void move_things(HomeModel& home, std::uint64_t seed, std::span<const FurnitureModel> models);

}  // namespace roomwise::simulation
