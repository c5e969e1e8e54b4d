#pragma once

#include "roomwise/fusion/floor_grid.h"
#include "roomwise/fusion/gravity_aligned_frame.h"
#include "roomwise/fusion/occupancy.h"
#include "roomwise/pipeline/mapping/dense_map.h"

namespace roomwise::pipeline {

// The largest component of a home's map, fused, with its surface and which way is up.
struct GravityAlignedMap {
  DenseMap dense;
  fusion::PiecewiseMesh mesh_world;
  fusion::GravityAlignedFrame frame;
};
// Fails where the home has no map, and when the user interrupts.
[[nodiscard]] Expected<GravityAlignedMap> build_gravity_aligned_map(
    const home::Home& home, const fusion::TsdfOptions& field, RunContext& run);

// Whether cells of a size can be told from a map of such voxels: smaller ones would leave gaps in
// walls, of larger ones the distance field does not say whether they are empty. To be asked before
// the map is built.
[[nodiscard]] Expected<void> validate_cell(double cell_m, double voxel_size_m);
[[nodiscard]] Expected<std::vector<fusion::OccupancyCell>> occupancy_of(GravityAlignedMap& map,
                                                                        double cell_m,
                                                                        RunContext& run);
// The floor of each storey, from the lowest on, all in the gravity-aligned frame's x and y. Fails
// where the map shows no floor.
[[nodiscard]] Expected<std::vector<fusion::FloorGrid>> floor_grids_of(
    GravityAlignedMap& map, const fusion::FloorGridOptions& options, RunContext& run);
// The same as one, of several storeys on the plan (see Storeys).
[[nodiscard]] Expected<fusion::FloorGrid> floor_grid_of(GravityAlignedMap& map,
                                                        const fusion::FloorGridOptions& options,
                                                        RunContext& run);

}  // namespace roomwise::pipeline
