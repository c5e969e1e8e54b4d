#pragma once

#include <filesystem>

#include "roomwise/base/expected.h"
#include "roomwise/geometry/point_cloud.h"

namespace roomwise::mapping {

// Writes the cloud as binary little-endian PLY, 15 bytes a point: x y z (float, m), red green blue
// (uchar), as MeshLab, CloudCompare, Open3D and Blender read it. The file is whole or unchanged.
[[nodiscard]] Expected<void> write_ply(const std::filesystem::path& path,
                                       const geometry::PointCloud& cloud);

}  // namespace roomwise::mapping
