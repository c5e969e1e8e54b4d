#pragma once

#include "laboratory/simulation/scene/fittings.h"

namespace roomwise::simulation {

// A window's frame, sashes, pane, reveal and sill, and its curtains, drawn aside.
void add_window(Fittings& fittings, const Window& window, float wall_thickness_m,
                std::uint32_t seed);

}  // namespace roomwise::simulation
