#pragma once

#include <filesystem>

#include "roomwise/base/expected.h"
#include "roomwise/geometry/point_cloud.h"

namespace roomwise::mapping {

// Writes the cloud as binary PCD, version 0.7, as the Point Cloud Library reads it: 16 bytes a
// point, x y z (float, m) and rgb (a float whose bits are 0x00RRGGBB). Source:
// https://pointclouds.org/documentation/tutorials/pcd_file_format.html. The file is whole or
// unchanged.
[[nodiscard]] Expected<void> write_pcd(const std::filesystem::path& path,
                                       const geometry::PointCloud& cloud);

}  // namespace roomwise::mapping
