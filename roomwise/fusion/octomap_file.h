#pragma once

#include <filesystem>
#include <span>

#include "roomwise/base/expected.h"

#include "roomwise/fusion/occupancy.h"

namespace roomwise::fusion {

// Writes cells as a binary OctoMap (.bt; Hornung et al., "OctoMap: An Efficient Probabilistic 3D
// Mapping Framework Based on Octrees", 2013): a text header, then the tree, depth first, two bytes
// a node with two bits for each of its eight children: unknown, free, occupied, or a node of its
// own. Eight children that are all free or all occupied are one. The cells come in any
// order, each once. Fails where a cell lies more than
// 2^15 cells from the origin, which the format cannot hold. The file is whole or unchanged.
[[nodiscard]] Expected<void> write_octomap(const std::filesystem::path& path,
                                           std::span<const OccupancyCell> cells, double cell_m);

}  // namespace roomwise::fusion
