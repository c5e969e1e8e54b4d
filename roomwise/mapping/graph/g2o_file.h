#pragma once

#include <filesystem>

#include "roomwise/mapping/graph/pose_graph.h"

namespace roomwise::mapping {

// g2o's text format: VERTEX_SE3:QUAT, EDGE_SE3:QUAT and FIX lines (FIX must name the lowest node or
// be absent, since that one is held still anyway). Fails, naming the line, on other vertex or edge
// types, missing or not-finite numbers, a node given twice, an edge to a node that is not there.
// The format does not tell loop closures from odometry: an edge counts as odometry when it leads
// from a node to the next one that the file holds, and as a loop closure otherwise.
[[nodiscard]] Expected<PoseGraph> read_g2o(const std::filesystem::path& path);

// Numbers are written so that reading gives the same bits. Of the information the upper triangle is
// written.
[[nodiscard]] Expected<void> write_g2o(const std::filesystem::path& path, const PoseGraph& graph);

}  // namespace roomwise::mapping
