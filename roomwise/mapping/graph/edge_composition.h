#pragma once

#include "roomwise/mapping/graph/pose_graph.h"

// Edges of the pose graph put together, with what they are unsure of.
namespace roomwise::mapping {

// The same measurement from the other side: from `to` to `from`.
[[nodiscard]] PoseGraphEdge reversed(const PoseGraphEdge& edge);

// Where the second edge leads from where the first begins; it must begin where the first ends. The
// covariances add, to first order. It is a loop, since either may be wrong, and by the device's
// motion where one of both is.
[[nodiscard]] PoseGraphEdge composed(const PoseGraphEdge& first, const PoseGraphEdge& second);

// How unsure an edge is: the trace of its covariance, a metre counting as a radian.
[[nodiscard]] double variance_of(const PoseGraphEdge& edge);

}  // namespace roomwise::mapping
