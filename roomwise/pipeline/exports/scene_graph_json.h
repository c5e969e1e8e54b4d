#pragma once

#include <string>

#include "roomwise/pipeline/exports/home_contents.h"

namespace roomwise::pipeline {

// The home as a 3-D scene graph, as Spark-DSG 1.1.3 reads it from JSON (Hughes et al., "Foundations
// of Spatial Perception for Robotics", 2024): the building, the rooms of which it is known where
// they lie, the places of their free floor (floor_places()), and the things of the map's largest
// piece, in the gravity-aligned frame. A room's parent is the building, a place's and a thing's the
// room that it lies in; what lies in no known room has none. Rooms between which a door leads are
// joined, and places that touch. There is no mesh.
//
// What it has no field for stands in the metadata of nodes: a thing's probability, names and when
// it was seen, a door's width. Bytes of names that are no UTF-8 become U+FFFD.
[[nodiscard]] std::string scene_graph_json(const HomeContents& contents);

}  // namespace roomwise::pipeline
