#pragma once

#include <cstdint>

#include "roomwise/base/expected.h"
#include "roomwise/rooms/recognition/room_calibration.h"
#include "roomwise/rooms/recognition/room_gallery.h"
#include "roomwise/rooms/recognition/stored_numbers.h"

namespace roomwise::rooms {

// The pictures that rooms were learned from, and what a similarity to them means.
struct RoomRetrieval {
  RoomGallery memory;
  RoomCalibration calibration;
};

// The part of a stored classifier that is new in version 2. Version 3 has
// RoomCalibration::room_score_means at its end.
void write(NumberWriter& writer, const RoomRetrieval& retrieval);
// `version`: of the classifier, 2 or 3. Fails, saying what is wrong, on anything that write() of
// that version does not write. Memory is taken only for what is there.
[[nodiscard]] Expected<RoomRetrieval> read_retrieval(NumberReader& reader, std::size_t rooms,
                                                     std::size_t features, std::uint32_t version);

}  // namespace roomwise::rooms
