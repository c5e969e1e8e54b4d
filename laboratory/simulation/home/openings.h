#pragma once

#include <Eigen/Core>
#include <vector>

#include "laboratory/simulation/home/home_model.h"

namespace roomwise::simulation {

// A frame of axes in the middle of an opening: along the wall, across it, up from the floor.
struct OpeningAxes {
  Eigen::Vector3f center, along, across;

  explicit OpeningAxes(const WallOpening& opening);
  [[nodiscard]] Eigen::Vector3f at(float along_m, float across_m, float height_m) const {
    return center + along_m * along + across_m * across + height_m * Eigen::Vector3f::UnitZ();
  }
};

// One of a room's four walls, seen from the room.
struct WallFace {
  Eigen::Vector3f origin;  // at its lower end of x or y, on the floor
  Eigen::Vector3f along;   // x or y
  Eigen::Vector3f normal;  // into the room
  float length_m = 0;

  // A hole in the face: from and to along it and above the floor.
  struct Hole {
    float from_m, to_m, bottom_m, top_m;
    bool is_door;
  };
  std::vector<Hole> holes;
};

[[nodiscard]] std::vector<WallFace> wall_faces(const HomeModel& home, std::size_t room);

}  // namespace roomwise::simulation
