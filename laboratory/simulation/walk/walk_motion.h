#pragma once

#include <Eigen/Core>
#include <vector>

#include "laboratory/simulation/walk/walk.h"
#include "laboratory/simulation/walk/walk_route.h"

namespace roomwise::simulation {

// Where a person is and looks at a moment, without the shaking of the hand.
struct BodyState {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
  double heading_rad = 0;  // not wrapped
  double down_rad = 0;
  double speed_m_s = 0;
  double floor_m = 0;  // height of the feet
};

constexpr double kMotionStep = 0.01;  // seconds from one state to the next

// Walks a route at human speed: smooth starts and stops, turns within limits but for fast ones.
[[nodiscard]] std::vector<BodyState> walk_along(const Route& route, const WalkOptions& options);

}  // namespace roomwise::simulation
