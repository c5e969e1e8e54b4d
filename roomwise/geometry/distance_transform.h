#pragma once

#include <vector>

namespace roomwise::geometry {

// What a cell holds that is nothing to measure the distance to.
constexpr double kFarFromAll = 1e9;

// The exact squared distance, in cells, from the middle of each cell of a grid (index = row *
// columns + column) to the middle of the nearest cell that holds 0; the others hold kFarFromAll.
// (Felzenszwalb and Huttenlocher, "Distance Transforms of Sampled Functions", 2012.)
[[nodiscard]] std::vector<double> squared_distances(std::vector<double> cells, int columns,
                                                    int rows);

}  // namespace roomwise::geometry
