#pragma once

#include <string>
#include <vector>

#include "laboratory/simulation/home/home_model.h"

namespace roomwise::simulation {

// What is wrong with a home, one line each: a thing inside another, in a wall, before a window, in
// a curtain, in a door's swing or passage; a thing that floats or hangs over the edge of what
// carries it; rooms and furniture that a person cannot reach; names that are not unique. Empty for
// a home that is right.
[[nodiscard]] std::vector<std::string> find_faults(const HomeModel& home);

// The part of it that tells which rooms and things a person cannot walk to.
[[nodiscard]] std::vector<std::string> find_unreachable(const HomeModel& home);

}  // namespace roomwise::simulation
