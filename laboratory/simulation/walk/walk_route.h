#pragma once

#include <Eigen/Core>
#include <vector>

#include "laboratory/simulation/home/home_model.h"
#include "laboratory/simulation/walk/walk.h"
#include "roomwise/base/expected.h"
#include "roomwise/base/random.h"

namespace roomwise::simulation {

// Where the person looks while standing.
struct Gaze {
  double heading_rad = 0;  // of the optical axis on the floor, from x towards y
  double down_rad = 0.15;  // below the horizon
  double hold_s = 0;       // 0: goes on to the next without coming to rest
  bool is_fast = false;
};

constexpr double kWalkingDown_rad = 0.17;

// A way to walk, then gazes at its end.
struct Leg {
  std::vector<Eigen::Vector2d> way;  // close together; begins where the last one ended
  std::vector<double> floor_m = {};  // at each of its places; empty: 0
  std::vector<Gaze> gazes;
  double down_rad = kWalkingDown_rad;  // where one looks meanwhile, below the horizon
};

// In the world, also where a home is planned as several storeys.
struct Route {
  Eigen::Vector2d start = Eigen::Vector2d::Zero();
  double start_heading_rad = 0;
  std::vector<Leg> legs;  // the last one ends at the start
};

// From the front door through the rooms, to places in each that show what stands in it, and back.
[[nodiscard]] Expected<Route> plan_route(const HomeModel& home, const WalkOptions& options);

// The angle in (-pi, pi] that turns by as much.
[[nodiscard]] double wrapped(double angle_rad);

}  // namespace roomwise::simulation
