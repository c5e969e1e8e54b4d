#pragma once

#include <cstdint>
#include <vector>

#include "laboratory/simulation/home/home_model.h"
#include "roomwise/base/expected.h"

namespace roomwise::simulation {

// A flat without its furniture: rooms on both sides of a hall (or on one side of it, or around a
// living room at its end), doors, passages, windows and finishes. Every room can be reached.
//
// `rooms` are the kinds asked for, at most 8 and at most three of a kind; a hall is added where
// none is named. Empty: chosen by the seed. Fails where the rooms do not make a flat.
[[nodiscard]] Expected<HomeModel> plan_floor(std::uint64_t seed, std::vector<RoomKind> rooms);

}  // namespace roomwise::simulation
