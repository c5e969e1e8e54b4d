#pragma once

#include "laboratory/simulation/home/home_model.h"

namespace roomwise::simulation {

// The home with its halls emptied: nothing stands or hangs in them, and floor, walls and ceiling
// are painted plainly. Lamps that stand there are gone, lights at the ceiling stay.
[[nodiscard]] HomeModel with_bare_halls(HomeModel home);

}  // namespace roomwise::simulation
