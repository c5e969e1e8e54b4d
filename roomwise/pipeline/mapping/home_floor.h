#pragma once

#include <optional>

#include "roomwise/fusion/floor_grid.h"
#include "roomwise/fusion/gravity_aligned_frame.h"
#include "roomwise/home/home.h"
#include "roomwise/pipeline/mapping/gravity_aligned_map.h"
#include "roomwise/pipeline/run_context.h"

namespace roomwise::pipeline {

// Which way is up in a home's map, and where its floor is free: what questions about places need of
// the fused map.
struct HomeFloor {
  fusion::GravityAlignedFrame frame;
  std::optional<fusion::FloorGrid> grid;  // where the map shows a floor
};

// That of a fused map.
[[nodiscard]] Expected<HomeFloor> floor_of(GravityAlignedMap& map, RunContext& run);

// With what was walked over (with_walked_ways()). As the home keeps it, or, where that is not
// there, cannot be read, or the map has changed since, from the map, which is fused for it: up to a
// minute. Fails where the home has no map, and when the user interrupts.
[[nodiscard]] Expected<HomeFloor> find_home_floor(const home::Home& home, RunContext& run);

// Keeps it in the home, unless it is there, whole and fresh. The same failures. Or keeps one that
// was found already, of the map as it is.
[[nodiscard]] Expected<void> keep_home_floor(home::Home& home, RunContext& run);
[[nodiscard]] Expected<void> keep_home_floor(home::Home& home, const HomeFloor& floor);

}  // namespace roomwise::pipeline
