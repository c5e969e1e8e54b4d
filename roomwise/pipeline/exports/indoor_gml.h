#pragma once

#include <cstddef>
#include <string>

#include "roomwise/pipeline/exports/home_contents.h"

namespace roomwise::pipeline {

// A home's plan as IndoorGML, and what is in it.
struct IndoorPlan {
  std::string gml;
  std::size_t rooms = 0, doors = 0, stairs = 0, things = 0;
  std::size_t openings = 0;  // wider than any door, between rooms that are open to each other
  std::size_t rooms_without_place = 0;   // named, but the map shows no floor of theirs
  std::size_t stairs_without_rooms = 0;  // at one end of which no named room is
};

// The home as one IndoorGML 1.0.3 document (OGC 14-005r5) in the gravity-aligned frame, which it
// defines as an engineering reference system: metres, z up.
//
// A room is a GeneralSpace, a polygon on the floor of its storey, with a State at its middle; what
// of a room lies apart is a further space of the same name without a state. Doors, stairs and
// wide openings are Transitions between states, whose weight is their length, m. Things are states
// of a second layer, of class TAGS, each within its room by an InterLayerConnection. What the
// format has no place for (storey, widths, steps) stands in gml:description as key="value": pairs.
//
// Fails where no rooms are named, where the map shows no floor, and where none of them is on it.
[[nodiscard]] Expected<IndoorPlan> indoor_gml(const HomeContents& contents);

}  // namespace roomwise::pipeline
