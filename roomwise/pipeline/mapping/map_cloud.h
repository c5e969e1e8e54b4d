#pragma once

#include <span>

#include "roomwise/geometry/point_cloud.h"
#include "roomwise/home/home.h"
#include "roomwise/mapping/graph/up_direction.h"
#include "roomwise/pipeline/run_context.h"

namespace roomwise::pipeline {

// The map as points: the clouds of all key-frames of the largest component, down-sampled on a voxel
// grid into the map's world frame, and the direction up in it.
struct MapCloud {
  geometry::PointCloud cloud;
  mapping::UpDirection up;
};
[[nodiscard]] Expected<MapCloud> build_map_cloud(const home::Home& home, double voxel_size_m,
                                                 RunContext& run);
// Of these key-frames, at the poses given with them.
[[nodiscard]] Expected<MapCloud> build_map_cloud(const home::Home& home,
                                                 std::span<const home::Keyframe> keyframes,
                                                 double voxel_size_m, RunContext& run);

}  // namespace roomwise::pipeline
