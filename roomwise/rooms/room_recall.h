#pragma once

#include <cstdint>

#include "roomwise/base/expected.h"
#include "roomwise/rooms/room_calibration.h"
#include "roomwise/rooms/room_memory.h"
#include "roomwise/rooms/stored_numbers.h"

namespace roomwise::rooms {

// The pictures that rooms were learned from, and what a likeness to them means.
struct RoomRecall {
  RoomMemory memory;
  RoomCalibration calibration;
};

// The part of a stored classifier that is new in version 2. Version 3 has
// RoomCalibration::usual_of_rooms at its end.
void write(NumberWriter& writer, const RoomRecall& recall);
// `version`: of the classifier, 2 or 3. Fails, saying what is wrong, on anything that write() of
// that version does not write. Memory is taken only for what is there.
[[nodiscard]] Expected<RoomRecall> read_recall(NumberReader& reader, std::size_t rooms,
                                               std::size_t features, std::uint32_t version);

}  // namespace roomwise::rooms
