#pragma once

#include <span>
#include <string>

#include "roomwise/evaluation/drawing/svg.h"
#include "roomwise/evaluation/drawing/top_view.h"

namespace roomwise::evaluation {

struct MapKeyFrame {
  Eigen::Vector3d place_world = Eigen::Vector3d::Zero();  // of the camera, m
  std::string room;                                       // empty: not named
  bool begins_walk = false;                               // no line leads to it from the one before
};

struct MapObject {
  std::string name;
  Eigen::Vector3d place_world = Eigen::Vector3d::Zero();  // m
};

// The map from above: the walks through the key-frames, each a line, its colour and its dashes
// those of the room, the rooms' names at the centre of their key-frames, objects by their number
// (from 1, in their order) and name, a ruler of 1 m and a legend of the rooms. The picture stands
// inside the drawing.
[[nodiscard]] SvgDrawing draw_map(const TopView& view, std::span<const MapKeyFrame> key_frames,
                                  std::span<const MapObject> objects);

}  // namespace roomwise::evaluation
