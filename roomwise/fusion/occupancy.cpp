#include "roomwise/fusion/occupancy.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <tuple>

namespace roomwise::fusion {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;
using geometry::RigidTransform;

Vector3i cell_of(const Vector3d& point_gravity, double cell_m) {
  return (point_gravity.array() / cell_m).floor().cast<int>();
}

auto order_of(const OccupancyCell& cell) {
  // Occupied before free.
  return std::tuple(cell.cell.z(), cell.cell.y(), cell.cell.x(), cell.is_occupied ? 0 : 1);
}

// In order, each cell once.
void keep_first_of_each(std::vector<OccupancyCell>& cells) {
  std::ranges::sort(cells, {}, order_of);
  const auto same = [](const OccupancyCell& a, const OccupancyCell& b) { return a.cell == b.cell; };
  cells.erase(std::unique(cells.begin(), cells.end(), same), cells.end());
  cells.shrink_to_fit();
}

// The free cells whose middle is nearest to a voxel of this block, so that every cell is asked in
// one block.
void add_free_cells(const TsdfVolume& field, const Vector3i& block,
                    const RigidTransform& gravity_from_field, double cell_m,
                    std::vector<Vector3i>& cells) {
  const RigidTransform field_from_gravity = gravity_from_field.inverse();
  const VoxelBlock& content = *field.find(block);
  const Vector3d low = (kBlockSide * block.cast<double>().array() - 0.5) * field.voxel_size_m();
  Eigen::AlignedBox3d bounds;
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3d offset(corner & 1, corner >> 1 & 1, corner >> 2 & 1);
    bounds.extend(gravity_from_field * Vector3d(low + kBlockSide * field.voxel_size_m() * offset));
  }
  const Vector3i first = cell_of(bounds.min(), cell_m), last = cell_of(bounds.max(), cell_m);
  for (int z = first.z(); z <= last.z(); ++z) {
    for (int y = first.y(); y <= last.y(); ++y) {
      for (int x = first.x(); x <= last.x(); ++x) {
        const Vector3d middle = cell_m * (Vector3d(x, y, z).array() + 0.5);
        const Vector3d point = field_from_gravity * middle;
        const Vector3i voxel = (point / field.voxel_size_m()).array().round().cast<int>();
        const Vector3i in_block = voxel - kBlockSide * block;
        if ((in_block.array() < 0).any() || (in_block.array() >= kBlockSide).any()) continue;
        const Voxel& seen = content.voxels[TsdfVolume::offset_of(in_block)];
        if (seen.weight == 0 || field.sample(seen).distance_m < 0.5 * cell_m) continue;
        cells.emplace_back(x, y, z);
      }
    }
  }
}

}  // namespace

Expected<void> visit_free_cells(TsdfVolume& field, const RigidTransform& gravity_from_world,
                                double cell_m, ThreadPool& pool,
                                const std::function<void(std::span<const Vector3i>)>& visit) {
  const std::vector<Vector3i> blocks = field.blocks();
  constexpr std::size_t kBlocksATask = 512;
  constexpr std::size_t kMostTasks = 8;  // at once: all their blocks are in memory
  const std::size_t blocks_a_round = kBlocksATask * std::min<std::size_t>(pool.size(), kMostTasks);
  for (std::size_t first = 0; first < blocks.size(); first += blocks_a_round) {
    const std::size_t count = std::min(blocks_a_round, blocks.size() - first);
    const auto round = std::span(blocks).subspan(first, count);
    ROOMWISE_RETURN_IF_ERROR(field.bring(round));
    std::vector<std::vector<Vector3i>> found((count + kBlocksATask - 1) / kBlocksATask);
    pool.parallel_for(found.size(), [&](std::size_t task) {
      const std::size_t end = std::min(count, (task + 1) * kBlocksATask);
      for (std::size_t i = task * kBlocksATask; i < end; ++i)
        add_free_cells(field, round[i], gravity_from_world, cell_m, found[task]);
    });
    for (const auto& some : found) visit(some);
  }
  return {};
}

Expected<std::vector<OccupancyCell>> occupancy_cells(TsdfVolume& field,
                                                     const PiecewiseMesh& mesh_world,
                                                     const RigidTransform& gravity_from_world,
                                                     double cell_m, ThreadPool& pool) {
  std::vector<OccupancyCell> cells;
  cells.reserve(mesh_world.vertex_count());
  ROOMWISE_RETURN_IF_ERROR(mesh_world.for_each([&](const MeshPiece& piece) {
    for (const Eigen::Vector3f& vertex : piece.own_vertices()) {
      const Vector3d point_gravity = gravity_from_world * Vector3d(vertex.cast<double>());
      cells.push_back({cell_of(point_gravity, cell_m), true});
    }
  }));
  keep_first_of_each(cells);  // many vertices lie in one cell
  ROOMWISE_RETURN_IF_ERROR(
      visit_free_cells(field, gravity_from_world, cell_m, pool, [&](const auto& some) {
        for (const Vector3i& cell : some) cells.push_back({cell, false});
      }));
  keep_first_of_each(cells);
  return cells;
}

}  // namespace roomwise::fusion
