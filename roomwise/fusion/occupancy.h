#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/base/thread_pool.h"
#include "roomwise/fusion/piecewise_mesh.h"
#include "roomwise/fusion/tsdf_volume.h"
#include "roomwise/geometry/rigid_transform.h"

namespace roomwise::fusion {

// Cell (i, j, k) is the cube from cell_m * (i, j, k) to cell_m * (i + 1, j + 1, k + 1).
struct OccupancyCell {
  Eigen::Vector3i cell = Eigen::Vector3i::Zero();
  bool is_occupied = false;  // else free
};

// The cells, along the axes of the gravity-aligned frame, whose middle lies in the open, at least
// half a cell from any surface; each once, some at a time. Fails where the field cannot be read.
[[nodiscard]] Expected<void> visit_free_cells(
    TsdfVolume& field, const geometry::RigidTransform& gravity_from_world, double cell_m,
    ThreadPool& pool, const std::function<void(std::span<const Eigen::Vector3i>)>& visit);

// What of space is free and what is not: a cell that the surface passes is occupied, others are
// free as above, the rest is unknown and left out. By z, then y, then x; all in memory.
[[nodiscard]] Expected<std::vector<OccupancyCell>> occupancy_cells(
    TsdfVolume& field, const PiecewiseMesh& mesh_world,
    const geometry::RigidTransform& gravity_from_world, double cell_m, ThreadPool& pool);

}  // namespace roomwise::fusion
