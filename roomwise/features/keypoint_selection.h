#pragma once

#include <cstddef>
#include <vector>

#include "roomwise/features/feature_extractor.h"

namespace roomwise::features {

// Chooses the strongest key-points of a picture. Keeps its memory from one picture to the next.
class KeypointSelection {
 public:
  // Leaves the strongest `most` (0: all), by falling response; equal ones by place, size and angle,
  // so that the order is always the same. With spread_cells > 0 they are taken evenly from a grid
  // of so many square cells across the picture's longer side: first the strongest of each cell,
  // then the second of each, and so on; within one such round the strongest come first.
  void select(std::vector<Keypoint>& keypoints, std::size_t most, int width, int height,
              int spread_cells);

 private:
  void select_spread(std::vector<Keypoint>& keypoints, std::size_t most, int width, int height,
                     int spread_cells);

  std::vector<std::size_t> taken_;  // of each cell
  std::vector<std::size_t> ranks_;  // of each key-point in its cell
  std::vector<std::size_t> order_;
};

}  // namespace roomwise::features
