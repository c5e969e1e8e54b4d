#pragma once

#include "laboratory/simulation/scene/fittings.h"

namespace roomwise::simulation {

// Of a home in the world: the rails of its stairs and of the landings above them.
void add_stair_rails(Fittings& fittings, const HomeModel& home);

// A flat piece of stairs: a tread, a riser, a side of a step, an edge of the floor above.
struct StairFace {
  Eigen::Vector3f origin, along, up, normal;
  float width_m = 0, height_m = 0;  // along `along` and `up`
  const Finish* finish = nullptr;   // of what it is covered with
};
[[nodiscard]] std::vector<StairFace> stair_faces(const HomeModel& home);

}  // namespace roomwise::simulation
