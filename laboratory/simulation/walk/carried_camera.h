#pragma once

#include <array>

#include "laboratory/simulation/walk/walk.h"
#include "laboratory/simulation/walk/walk_motion.h"
#include "roomwise/base/random.h"

namespace roomwise::simulation {

constexpr double kShutter_s = 0.02;  // open

// A smooth random wandering: a few sines of random pitch and phase.
class Wandering {
 public:
  Wandering(RandomStream& random, double amplitude);
  [[nodiscard]] double at(double time_s) const;

 private:
  struct Sine {
    double rate = 0, phase = 0, amplitude = 0;
  };
  std::array<Sine, 4> sines_;
};

// A camera that a walking person carries: it bobs and sways with their steps, and never quite
// rests. Of the options seed, height, walking speed and jitter count.
class CarriedCamera {
 public:
  explicit CarriedCamera(const WalkOptions& options);

  // Where it is when its bearer's body is there, so long after the walk began.
  [[nodiscard]] geometry::RigidTransform pose(const BodyState& state, double time_s) const;

 private:
  double height_m_, walking_speed_m_s_, jitter_;
  std::array<Wandering, 3> shifts_, turns_;
};

}  // namespace roomwise::simulation
