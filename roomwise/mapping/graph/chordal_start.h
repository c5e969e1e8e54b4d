#pragma once

#include <optional>
#include <vector>

#include "roomwise/base/progress.h"
#include "roomwise/geometry/rigid_transform.h"
#include "roomwise/mapping/graph/pose_graph_solver.h"

namespace roomwise::mapping {

// Poses from which the graph can be minimised, whatever those that it holds, in two steps of linear
// least squares: first turns, as matrices of any kind that are then made rotations (chordal
// relaxation: Martinec and Pajdla, "Robust rotation and translation estimation in multiview
// reconstruction", 2007), then places for these turns. Fixed poses stay. Nothing where the edges do
// not determine all turns and places, nor where it was interrupted, which it asks for before each
// step.
[[nodiscard]] std::optional<std::vector<geometry::RigidTransform>> chordal_start(
    const IndexedGraph& graph, const Interruption& interruption = {});

}  // namespace roomwise::mapping
