#pragma once

#include <memory>
#include <optional>

#include "roomwise/fusion/floor_grid.h"
#include "roomwise/fusion/level_frame.h"
#include "roomwise/fusion/triangle_mesh.h"
#include "roomwise/geometry/point_cloud.h"
#include "roomwise/pipeline/home_localizer.h"

namespace roomwise::live {

// A home's map made ready for questions: made once, which takes up to a minute, and only read
// afterwards.
struct LiveMap {
  fusion::LevelFrame frame;
  std::optional<fusion::FloorGrid> floor;  // where the map shows one
  // For looking at: at most kMostPoints, and at most kMostCoarsePoints to begin with.
  geometry::PointCloud cloud_level, coarse_cloud_level;
  std::unique_ptr<const pipeline::HomeLocalizer> localizer;  // null: pictures are not placed

  static constexpr std::size_t kMostPoints = 200'000;
  static constexpr std::size_t kMostCoarsePoints = 40'000;
};

// The surface's vertices, one a voxel, in voxels large enough that there are at most so many
// points.
[[nodiscard]] geometry::PointCloud thinned(const fusion::TriangleMesh& mesh, std::size_t most);

// Fails where the home has no map, and when the user interrupts.
[[nodiscard]] Expected<std::shared_ptr<const LiveMap>> make_live_map(const home::Home& home,
                                                                     pipeline::RunContext& run);

}  // namespace roomwise::live
