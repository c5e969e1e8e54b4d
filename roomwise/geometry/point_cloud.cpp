#include "roomwise/geometry/point_cloud.h"

#include <algorithm>
#include <cmath>

namespace roomwise::geometry {
namespace {

constexpr int kBitsPerAxis = 21;
constexpr double kHalfRange = 1 << (kBitsPerAxis - 1);

}  // namespace

void VoxelGrid::add(const Eigen::Vector3d& point, Rgb8 color) {
  const Eigen::Array3d index = (point.array() / voxel_size_m_).floor() + kHalfRange;
  if (!(index >= 0).all() || !(index < 2 * kHalfRange).all()) return;  // also refuses NaN
  const auto x = static_cast<std::uint64_t>(index.x());
  const auto y = static_cast<std::uint64_t>(index.y());
  const auto z = static_cast<std::uint64_t>(index.z());
  Cell& cell = cells_[(z << (2 * kBitsPerAxis)) | (y << kBitsPerAxis) | x];
  cell.point_sum += point;
  cell.color_sum += Eigen::Array3d(color.r, color.g, color.b);
  ++cell.count;
}

void VoxelGrid::add(const RigidTransform& grid_from_cloud, const PointCloud& cloud) {
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    add(grid_from_cloud * Eigen::Vector3d(cloud.points[i].cast<double>()), cloud.colors[i]);
  }
}

PointCloud VoxelGrid::cloud() const {
  std::vector<std::uint64_t> keys;
  keys.reserve(cells_.size());
  for (const auto& [key, cell] : cells_) keys.push_back(key);
  std::ranges::sort(keys);
  PointCloud cloud;
  cloud.points.reserve(keys.size());
  cloud.colors.reserve(keys.size());
  for (const std::uint64_t key : keys) {
    const Cell& cell = cells_.at(key);
    const double share = 1.0 / cell.count;
    const Eigen::Array3d color = (cell.color_sum * share).round();
    cloud.add((cell.point_sum * share).cast<float>(),
              {static_cast<std::uint8_t>(color.x()), static_cast<std::uint8_t>(color.y()),
               static_cast<std::uint8_t>(color.z())});
  }
  return cloud;
}

}  // namespace roomwise::geometry
