#pragma once

#include <memory>
#include <optional>

#include "roomwise/fusion/floor_grid.h"
#include "roomwise/fusion/level_frame.h"
#include "roomwise/geometry/point_cloud.h"
#include "roomwise/pipeline/home_localizer.h"

namespace roomwise::live {

// A home's map made ready for questions: made once, which takes up to a minute, and only read
// afterwards.
struct LiveMap {
  fusion::LevelFrame frame;
  std::optional<fusion::FloorGrid> floor;                    // where the map shows one
  geometry::PointCloud cloud_level;                          // at most kMostPoints, for looking at
  std::unique_ptr<const pipeline::HomeLocalizer> localizer;  // null: pictures are not placed

  static constexpr std::size_t kMostPoints = 200'000;
};

// Fails where the home has no map, and when the user interrupts.
[[nodiscard]] Expected<std::shared_ptr<const LiveMap>> make_live_map(const home::Home& home,
                                                                     pipeline::RunContext& run);

}  // namespace roomwise::live
