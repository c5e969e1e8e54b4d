#pragma once

#include <cstdint>
#include <span>

#include "laboratory/simulation/home/floor_layout.h"
#include "laboratory/simulation/home/home_model.h"

namespace roomwise::simulation {

// Doors, open passages, the front door and the windows of a home whose rooms are the cells, in the
// same order.
void add_openings(std::uint64_t seed, std::span<const LayoutCell> cells, HomeModel& home);

}  // namespace roomwise::simulation
