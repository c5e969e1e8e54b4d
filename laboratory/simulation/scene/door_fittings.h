#pragma once

#include "laboratory/simulation/scene/fittings.h"

namespace roomwise::simulation {

constexpr float kArchitrave =
    0.07F;  // the width of the board about a door, which skirting boards end at

// A door's frame and threshold, and its leaf, panelled on both sides, turned about its hinge.
// All doors of a home are of one `style`.
void add_door(Fittings& fittings, const Door& door, float wall_thickness_m, std::uint32_t style);

}  // namespace roomwise::simulation
