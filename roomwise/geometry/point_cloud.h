#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "roomwise/base/color.h"
#include "roomwise/geometry/rigid_transform.h"

namespace roomwise::geometry {

// Coloured points of one frame, metres. points[i] has colors[i].
struct PointCloud {
  std::vector<Eigen::Vector3f> points;
  std::vector<Rgb8> colors;

  [[nodiscard]] std::size_t size() const { return points.size(); }
  void add(const Eigen::Vector3f& point, Rgb8 color) {
    points.push_back(point);
    colors.push_back(color);
  }
};

// Joins clouds and keeps one point a voxel: the mean of the points (and colours) that fall into it.
// Memory grows with the voxels that are occupied, not with the points that are added. Not-finite
// points and points more than 2^20 voxels from the origin are left out.
class VoxelGrid {
 public:
  explicit VoxelGrid(double voxel_size_m) : voxel_size_m_(voxel_size_m) {}

  void add(const Eigen::Vector3d& point, Rgb8 color);
  void add(const RigidTransform& grid_from_cloud, const PointCloud& cloud);

  // The points in the order of their voxels (z, then y, then x): the same whatever the order of
  // adding, up to the rounding of the sums.
  [[nodiscard]] PointCloud cloud() const;
  [[nodiscard]] std::size_t size() const { return cells_.size(); }

 private:
  struct Cell {
    Eigen::Vector3d point_sum = Eigen::Vector3d::Zero();
    Eigen::Array3d color_sum = Eigen::Array3d::Zero();
    std::uint32_t count = 0;
  };
  double voxel_size_m_;
  std::unordered_map<std::uint64_t, Cell> cells_;
};

}  // namespace roomwise::geometry
