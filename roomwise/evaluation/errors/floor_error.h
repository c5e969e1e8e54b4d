#pragma once

#include <cstdint>

#include "roomwise/base/expected.h"
#include "roomwise/image/image.h"

namespace roomwise::evaluation {

// Where a person may stand: not 0 where they may; one pixel a cell.
using StandingRoom = image::Image<std::uint8_t>;

struct FloorError {
  double true_m2 = 0;   // free in truth
  double found_m2 = 0;  // free by the map
  double both_m2 = 0;
  // Shares of what is found that is true, and of what is true that is found; 0 of nothing.
  double precision = 0, recall = 0;
  // The same, where a neighbouring cell of the other, also across the corner, counts as well.
  double precision_within_cell = 0, recall_within_cell = 0;
};

// Fails where the two are not of one size.
[[nodiscard]] Expected<FloorError> floor_error(const StandingRoom& truth, const StandingRoom& found,
                                               double cell_m);

}  // namespace roomwise::evaluation
