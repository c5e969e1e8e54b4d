#pragma once

#include "roomwise/mapping/graph/pose_graph.h"

namespace roomwise::python {

// A pose graph as Python holds it.
struct PoseGraph {
  mapping::PoseGraph graph;
};

}  // namespace roomwise::python
