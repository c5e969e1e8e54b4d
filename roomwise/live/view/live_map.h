#pragma once

#include <memory>
#include <optional>

#include "roomwise/fusion/floor_grid.h"
#include "roomwise/fusion/gravity_aligned_frame.h"
#include "roomwise/fusion/piecewise_mesh.h"
#include "roomwise/geometry/point_cloud.h"
#include "roomwise/pipeline/mapping/home_localizer.h"

namespace roomwise::live {

// The map's surface for looking at, in the gravity-aligned frame: at most kMaxFine points, and at
// most kMaxCoarse to begin with.
struct MapClouds {
  geometry::PointCloud fine, coarse;

  static constexpr std::size_t kMaxFine = 200'000;
  static constexpr std::size_t kMaxCoarse = 40'000;
};

// A home's map made ready for questions, and only read afterwards.
struct LiveMap {
  fusion::GravityAlignedFrame frame;
  std::optional<fusion::FloorGrid> floor;  // where the map shows one
  double right_rad = 0;  // how its plan is turned: pipeline::drawing_direction_rad() of the floor
  std::shared_ptr<const MapClouds> clouds;                   // null: not fused yet
  std::shared_ptr<const pipeline::HomeLocalizer> localizer;  // null: pictures are not placed
};

// The surface's vertices, one a voxel, in voxels large enough that there are at most so many
// points. Fails where the surface cannot be read.
[[nodiscard]] Expected<geometry::PointCloud> thinned(const fusion::PiecewiseMesh& mesh,
                                                     std::size_t most);

// Without its clouds: some seconds, where the home keeps its floor. Fails where the home has no
// map, and when the user interrupts.
[[nodiscard]] Expected<std::shared_ptr<const LiveMap>> make_live_map(const home::Home& home,
                                                                     pipeline::RunContext& run);
// The same with clouds, for which the map is fused: up to a minute.
[[nodiscard]] Expected<std::shared_ptr<const LiveMap>> with_clouds(const LiveMap& map,
                                                                   const home::Home& home,
                                                                   pipeline::RunContext& run);

}  // namespace roomwise::live
