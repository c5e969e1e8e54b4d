#pragma once

#include <cstddef>
#include <vector>

#include "roomwise/features/feature_extractor.h"

namespace roomwise::features {

// By falling response; equal ones by place, size and angle, so that the order is always the same.
void sort_strongest_first(std::vector<Keypoint>& keypoints);

// The strongest `most` key-points of a picture, strongest first. With spread_cells > 0 they are
// taken evenly from a grid of so many square cells across the picture's longer side: first the
// strongest of each cell, then the second of each, and so on; within one such round the strongest
// come first.
[[nodiscard]] std::vector<Keypoint> select_keypoints(std::vector<Keypoint> keypoints,
                                                     std::size_t most, int width, int height,
                                                     int spread_cells);

}  // namespace roomwise::features
