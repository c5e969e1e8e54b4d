#include "laboratory/simulation/walk/walk_motion.h"

#include <algorithm>
#include <cmath>

namespace roomwise::simulation {
namespace {

constexpr double kAcceleration = 0.8;         // m/s^2
constexpr double kTurningAcceleration = 2.5;  // rad/s^2
constexpr double kFastTurning = 2.6;          // rad/s
constexpr double kFastTurningAcceleration = 10;
constexpr double kMaxNodding = 0.5;  // rad/s
constexpr double kNoddingAcceleration = 1.5;
constexpr double kLookAhead = 0.7;  // m along the way

// One angle that is steered to a goal with limited rate and acceleration.
class Steering {
 public:
  explicit Steering(double value) : value_(value) {}

  void step(double goal, double max_rate, double acceleration) {
    const double to_go = goal - value_;
    const double braking = std::sqrt(2 * 0.8 * acceleration * std::abs(to_go));
    const double wish = std::copysign(std::min(max_rate, braking), to_go);
    const double max_change = acceleration * kMotionStep;
    rate_ += std::clamp(wish - rate_, -max_change, max_change);
    value_ += rate_ * kMotionStep;
  }
  [[nodiscard]] double value() const { return value_; }
  [[nodiscard]] bool is_at(double goal) const {
    return std::abs(goal - value_) < 0.03 && std::abs(rate_) < 0.12;
  }

 private:
  double value_;
  double rate_ = 0;
};

class Walker {
 public:
  Walker(const Route& route, const WalkOptions& options)
      : options_(options),
        place_(route.start),
        heading_(route.start_heading_rad),
        down_(kWalkingDown_rad) {
    note();
    for (const Leg& leg : route.legs) {
      walk(leg);
      for (const Gaze& gaze : leg.gazes) look(gaze);
    }
  }

  std::vector<BodyState> states() { return std::move(states_); }

 private:
  void note() { states_.push_back({place_, heading_.value(), down_.value(), speed_, floor_m_}); }

  void walk(const Leg& leg) {
    const std::vector<Eigen::Vector2d>& way = leg.way;
    std::vector<double> along(way.size());
    for (std::size_t i = 1; i < way.size(); ++i) {
      along[i] = along[i - 1] + (way[i] - way[i - 1]).norm();
    }
    const auto at = [&](double distance) -> Eigen::Vector2d {
      const auto next = std::ranges::upper_bound(along, distance);
      if (next == along.end()) return way.back();
      const auto i = static_cast<std::size_t>(next - along.begin());
      if (i == 0) return way.front();
      return way[i - 1] +
             (way[i] - way[i - 1]) * (distance - along[i - 1]) / (along[i] - along[i - 1]);
    };
    const auto floor_at = [&](double distance) {
      if (leg.floor_m.empty()) return 0.0;
      const auto next = std::ranges::upper_bound(along, distance);
      if (next == along.end()) return leg.floor_m.back();
      const auto i = static_cast<std::size_t>(next - along.begin());
      if (i == 0) return leg.floor_m.front();
      return std::lerp(leg.floor_m[i - 1], leg.floor_m[i],
                       (distance - along[i - 1]) / (along[i] - along[i - 1]));
    };
    constexpr double kThere = 0.005;
    double walked = 0;
    while (!along.empty() && walked < along.back() - kThere) {
      const Eigen::Vector2d ahead = at(std::min(along.back(), walked + kLookAhead)) - place_;
      // Near the end the eyes stay where they are.
      const double turn =
          ahead.norm() > 0.2 ? wrapped(std::atan2(ahead.y(), ahead.x()) - heading_.value()) : 0;
      heading_.step(heading_.value() + turn, options_.max_turning_rad_s, kTurningAcceleration);
      down_.step(leg.down_rad, kMaxNodding, kNoddingAcceleration);
      // Turns before setting off, slows down for corners and for the end.
      const double willing = std::max(0.05, std::cos(std::min(std::abs(turn) * 1.3, 1.55)));
      const double braking = std::sqrt(2 * kAcceleration * (along.back() - walked));
      const double wish = std::min(options_.walking_speed_m_s * willing, std::max(braking, 0.05));
      speed_ +=
          std::clamp(wish - speed_, -2 * kAcceleration * kMotionStep, kAcceleration * kMotionStep);
      walked = std::min(along.back(), walked + speed_ * kMotionStep);
      place_ = at(walked);
      floor_m_ = floor_at(walked);
      note();
    }
    speed_ = 0;
  }

  void look(const Gaze& gaze) {
    const double goal = heading_.value() + wrapped(gaze.heading_rad - heading_.value());
    const double rate = gaze.is_fast ? kFastTurning : options_.max_turning_rad_s;
    const double acceleration = gaze.is_fast ? kFastTurningAcceleration : kTurningAcceleration;
    const bool passes = gaze.hold_s <= 0;
    constexpr double kNearEnough = 0.3;
    constexpr int kMaxSteps = 3000;
    for (int i = 0; i < kMaxSteps; ++i) {
      if (passes ? std::abs(goal - heading_.value()) < kNearEnough : heading_.is_at(goal)) break;
      heading_.step(goal, rate, acceleration);
      down_.step(gaze.down_rad, kMaxNodding, kNoddingAcceleration);
      note();
    }
    const int held = static_cast<int>(gaze.hold_s / kMotionStep);
    for (int i = 0; i < held; ++i) {
      heading_.step(goal, rate, acceleration);
      down_.step(gaze.down_rad, kMaxNodding, kNoddingAcceleration);
      note();
    }
  }

  const WalkOptions& options_;
  Eigen::Vector2d place_;
  Steering heading_, down_;
  double speed_ = 0;
  double floor_m_ = 0;
  std::vector<BodyState> states_;
};

}  // namespace

std::vector<BodyState> walk_along(const Route& route, const WalkOptions& options) {
  return Walker(route, options).states();
}

}  // namespace roomwise::simulation
