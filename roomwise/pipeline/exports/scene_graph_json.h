#pragma once

#include <string>

#include "roomwise/pipeline/exports/home_contents.h"

namespace roomwise::pipeline {

// The home as a 3-D scene graph, as Spark-DSG 1.1.3 reads it from JSON (Hughes et al., "Foundations
// of Spatial Perception for Robotics", 2024): the building, the rooms of which it is known where
// they lie, and the things of the map's largest piece, in the gravity-aligned frame. A room's
// parent is the building, a thing's the room that it stands in; a thing of no known room has none.
// Rooms between which a door leads are joined. There are no places and no mesh.
//
// What it has no field for stands in the metadata of nodes: a thing's probability, names and when
// it was seen, a door's width. Bytes of names that are no UTF-8 become U+FFFD.
[[nodiscard]] std::string scene_graph_json(const HomeContents& contents);

}  // namespace roomwise::pipeline
