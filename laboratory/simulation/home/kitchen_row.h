#pragma once

#include "laboratory/simulation/home/room_furnisher.h"

namespace roomwise::simulation {

// Fridge, cabinets, sink and stove side by side along the wall that has most room for them,
// cabinets and a hood above. What does not fit into the row is left to the rules of the room.
void add_kitchen_row(RoomFurnisher& furnisher);

}  // namespace roomwise::simulation
