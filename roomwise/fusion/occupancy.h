#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "roomwise/base/thread_pool.h"
#include "roomwise/fusion/triangle_mesh.h"
#include "roomwise/fusion/tsdf_volume.h"
#include "roomwise/geometry/rigid_transform.h"

namespace roomwise::fusion {

// Cell (i, j, k) is the cube from cell_m * (i, j, k) to cell_m * (i + 1, j + 1, k + 1).
struct OccupancyCell {
  Eigen::Vector3i cell = Eigen::Vector3i::Zero();
  bool is_occupied = false;  // else free
};

// What of space is free and what is not, in cells along the axes of the gravity-aligned frame: a
// cell that the surface passes is occupied, one whose middle lies in the open, at least half a cell
// from any surface, is free; the others are unknown and left out. By z, then y, then x.
[[nodiscard]] std::vector<OccupancyCell> occupancy_cells(
    const TsdfVolume& field, const TriangleMesh& mesh_world,
    const geometry::RigidTransform& gravity_from_world, double cell_m, ThreadPool& pool);

}  // namespace roomwise::fusion
