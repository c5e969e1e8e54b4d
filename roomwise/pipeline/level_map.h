#pragma once

#include "roomwise/fusion/floor_grid.h"
#include "roomwise/fusion/level_frame.h"
#include "roomwise/fusion/occupancy.h"
#include "roomwise/pipeline/dense_map.h"

namespace roomwise::pipeline {

// The largest piece of a home's map, fused, with its surface and which way is up.
struct LevelMap {
  DenseMap dense;
  fusion::TriangleMesh mesh_world;
  fusion::LevelFrame frame;
};
// Fails where the home has no map, and when the user interrupts.
[[nodiscard]] Expected<LevelMap> build_level_map(const home::Home& home, double voxel_size_m,
                                                 RunContext& run);

// Whether cells of a size can be told from a map of such voxels: smaller ones would leave gaps in
// walls, of larger ones the distance field does not say whether they are empty. To be asked before
// the map is built.
[[nodiscard]] Expected<void> validate_cell(double cell_m, double voxel_size_m);
[[nodiscard]] Expected<std::vector<fusion::OccupancyCell>> occupancy_of(const LevelMap& map,
                                                                        double cell_m,
                                                                        RunContext& run);
// Fails where the map shows no floor.
[[nodiscard]] Expected<fusion::FloorGrid> floor_grid_of(const LevelMap& map,
                                                        const fusion::FloorGridOptions& options,
                                                        RunContext& run);

}  // namespace roomwise::pipeline
