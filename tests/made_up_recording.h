#pragma once

#include <filesystem>

#include "roomwise/base/expected.h"

namespace roomwise::testing {

// Writes a recording of `frames` frames: a camera (320x240) moves along a curve, without turning,
// in front of a wall with a random pattern, 2 m away. groundtruth.txt says where it was, rooms.txt
// calls the first half "hall" and the rest "kitchen". A later one begins `first` frames on.
[[nodiscard]] Expected<void> write_made_up_recording(const std::filesystem::path& folder,
                                                     int frames, int first = 0);

}  // namespace roomwise::testing
