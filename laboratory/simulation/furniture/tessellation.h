#pragma once

#include "laboratory/simulation/furniture/furniture_catalogue.h"

namespace roomwise::simulation {

// Splits triangles until no edge is longer than `longest_edge_m` (or `longest_level_edge_m`, where
// the surface faces up: things stand there and throw shadows), since light is kept at corners. An
// edge is split at its middle or not at all by its own length, so neighbours keep fitting.
[[nodiscard]] TriangleMesh tessellate(TriangleMesh mesh, float longest_edge_m,
                                      float longest_level_edge_m);

}  // namespace roomwise::simulation
