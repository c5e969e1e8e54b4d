#pragma once

#include <cstdint>

#include "laboratory/simulation/home/home_model.h"

// Other homes of one floor plan, as there are in blocks of flats. A plan is a home without its
// furniture (plan_floor()).
namespace roomwise::simulation {

// The plan with other floors, walls and ceilings.
[[nodiscard]] HomeModel with_other_finishes(HomeModel plan, std::uint64_t seed);

// The plan with left and right exchanged, as the flat across the stairwell has it; it stands where
// the other stood.
[[nodiscard]] HomeModel mirrored(HomeModel plan);

}  // namespace roomwise::simulation
