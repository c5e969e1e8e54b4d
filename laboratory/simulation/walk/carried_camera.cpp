#include "laboratory/simulation/walk/carried_camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace roomwise::simulation {
namespace {

constexpr double kStepRate = 1.8;      // steps a second at walking speed
constexpr double kBob = 0.015;         // m, up and down with each step
constexpr double kSway = 0.012;        // m, to either side with every other
constexpr double kHandShift = 0.0025;  // m, one sigma of each sine
constexpr double kHandTurn = 0.003;    // rad

// Drawn in this order.
std::array<Wandering, 3> three(RandomStream& random, double amplitude) {
  return {Wandering(random, amplitude), Wandering(random, amplitude), Wandering(random, amplitude)};
}

}  // namespace

Wandering::Wandering(RandomStream& random, double amplitude) {
  for (Sine& sine : sines_) {
    sine.rate = 2 * std::numbers::pi * (0.2 + 2.3 * random.uniform());
    sine.phase = 2 * std::numbers::pi * random.uniform();
    // The quicker, the smaller.
    sine.amplitude = amplitude * random.normal() / std::max(1.0, sine.rate / 4);
  }
}

double Wandering::at(double time_s) const {
  double sum = 0;
  for (const Sine& sine : sines_) {
    sum += sine.amplitude * std::sin(sine.rate * time_s + sine.phase);
  }
  return sum;
}

CarriedCamera::CarriedCamera(const WalkOptions& options)
    : height_m_(options.camera_height_m),
      walking_speed_m_s_(options.walking_speed_m_s),
      jitter_(options.jitter),
      shifts_([&] {
        RandomStream random(options.seed, {0x68616e64});
        return three(random, kHandShift);
      }()),
      turns_([&] {
        RandomStream random(options.seed, {0x68616e64});
        static_cast<void>(three(random, kHandShift));
        return three(random, kHandTurn);
      }()) {}

geometry::RigidTransform CarriedCamera::pose(const BodyState& state, double time_s) const {
  const double gait = std::min(1.0, state.speed_m_s / walking_speed_m_s_);
  const double phase = 2 * std::numbers::pi * kStepRate * time_s;
  const Eigen::Vector2d ahead(std::cos(state.heading_rad), std::sin(state.heading_rad));
  const Eigen::Vector2d aside(-ahead.y(), ahead.x());
  const Eigen::Vector2d place =
      state.place +
      jitter_ * (aside * (kSway * gait * std::sin(phase / 2) + shifts_[0].at(time_s)) +
                 ahead * shifts_[1].at(time_s));
  const double height =
      state.floor_m + height_m_ + jitter_ * (kBob * gait * std::sin(phase) + shifts_[2].at(time_s));
  const double heading = state.heading_rad + jitter_ * turns_[0].at(time_s);
  const double down = state.down_rad + jitter_ * turns_[1].at(time_s);
  const double roll = jitter_ * turns_[2].at(time_s);

  const Eigen::Vector3d forward(std::cos(heading) * std::cos(down),
                                std::sin(heading) * std::cos(down), -std::sin(down));
  const Eigen::Vector3d right(std::sin(heading), -std::cos(heading), 0);
  Eigen::Matrix3d level;
  level << right, forward.cross(right), forward;
  const Eigen::Matrix3d rolled =
      Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return geometry::RigidTransform::from_matrix(level * rolled, {place.x(), place.y(), height});
}

}  // namespace roomwise::simulation
