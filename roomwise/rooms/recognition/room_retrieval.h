#pragma once

#include <cstdint>

#include "roomwise/base/expected.h"
#include "roomwise/base/plain_bytes.h"
#include "roomwise/rooms/recognition/room_calibration.h"
#include "roomwise/rooms/recognition/room_gallery.h"

namespace roomwise::rooms {

// The pictures that rooms were learned from, and what a similarity to them means.
struct RoomRetrieval {
  RoomGallery gallery;
  RoomCalibration calibration;
};

// Writes it as the end of a stored classifier.
void write(PlainWriter& writer, const RoomRetrieval& retrieval);
// Fails, saying what is wrong, on anything that write() does not write. Memory is taken only for
// what is there.
[[nodiscard]] Expected<RoomRetrieval> read_retrieval(PlainReader& reader, std::size_t rooms,
                                                     std::size_t features);

}  // namespace roomwise::rooms
