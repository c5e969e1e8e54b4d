#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "laboratory/simulation/home/free_space.h"
#include "laboratory/simulation/home/home_model.h"

namespace roomwise::simulation {

// A place to stand, and what is seen well from it.
struct Viewpoint {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
  std::vector<std::size_t> objects;  // indices into HomeModel::objects
};

// A few places in a room, of those marked in `reachable` (cells of the free space), that together
// show each object of the room from 1 to 2.4 m, from its front and with nothing tall between, where
// such a place exists; else from as near to that as can be. At least one.
[[nodiscard]] std::vector<Viewpoint> choose_viewpoints(const HomeModel& home, std::size_t room,
                                                       const FreeSpace& space,
                                                       const std::vector<bool>& reachable,
                                                       double radius_m);

}  // namespace roomwise::simulation
