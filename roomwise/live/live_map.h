#pragma once

#include <memory>
#include <optional>

#include "roomwise/fusion/floor_grid.h"
#include "roomwise/fusion/gravity_aligned_frame.h"
#include "roomwise/fusion/triangle_mesh.h"
#include "roomwise/geometry/point_cloud.h"
#include "roomwise/pipeline/mapping/home_localizer.h"

namespace roomwise::live {

// A home's map made ready for questions: made once, which takes up to a minute, and only read
// afterwards.
struct LiveMap {
  fusion::GravityAlignedFrame frame;
  std::optional<fusion::FloorGrid> floor;  // where the map shows one
  // For looking at: at most kMaxPoints, and at most kMaxCoarsePoints to begin with.
  geometry::PointCloud cloud_gravity, coarse_cloud_gravity;
  std::unique_ptr<const pipeline::HomeLocalizer> localizer;  // null: pictures are not placed

  static constexpr std::size_t kMaxPoints = 200'000;
  static constexpr std::size_t kMaxCoarsePoints = 40'000;
};

// The surface's vertices, one a voxel, in voxels large enough that there are at most so many
// points.
[[nodiscard]] geometry::PointCloud thinned(const fusion::TriangleMesh& mesh, std::size_t most);

// Fails where the home has no map, and when the user interrupts.
[[nodiscard]] Expected<std::shared_ptr<const LiveMap>> make_live_map(const home::Home& home,
                                                                     pipeline::RunContext& run);

}  // namespace roomwise::live
