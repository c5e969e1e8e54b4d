#pragma once

#include <cstdint>

#include "laboratory/simulation/home/home_model.h"

namespace roomwise::simulation {

// Chooses what floor, walls and ceiling of a room are covered with.
void finish_room(std::uint64_t seed, std::size_t room_index, Room& room);

}  // namespace roomwise::simulation
