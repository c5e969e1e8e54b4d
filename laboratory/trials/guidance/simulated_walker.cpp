#include "laboratory/trials/guidance/simulated_walker.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "roomwise/guide/way/legs.h"

namespace roomwise::trials {
namespace {

using Eigen::Vector2d;
using guide::kDegree_rad;
using Kind = Instruction::Kind;

constexpr double kSpeed_m_s = 0.6;          // of a person who walks with a cane at home
constexpr double kCarefulSpeed_m_s = 0.35;  // while the cane finds something
constexpr double kTurning_rad_s = 60 * kDegree_rad;
constexpr double kLooking_rad_s = 30 * kDegree_rad;
constexpr double kCane_m = 0.9;
// Half of a person's width with the shoulders turned a little, and how near things come to it.
constexpr double kHalfWidth_m = 0.2;
constexpr double kTouch_m = 0.17;
constexpr double kInside_m = 0.1;
constexpr double kBlocked_m = 0.15;    // so much more was to be walked
constexpr double kNoseToWall_m = 0.3;  // with the cane at it they stand so near

Vector2d direction(double heading_rad) {
  return {std::cos(heading_rad), std::sin(heading_rad)};
}

double clearance_m(const fusion::FloorGrid& floor, const Vector2d& place) {
  const Vector2d cell = (place - floor.origin_m()) / floor.cell_m();
  const bool is_inside =
      cell.x() >= 0 && cell.y() >= 0 && cell.x() < floor.columns() && cell.y() < floor.rows();
  return is_inside ? floor.clearance_m(static_cast<int>(cell.x()), static_cast<int>(cell.y())) : 0;
}

}  // namespace

Expected<void> WalkerFaults::validate() const {
  if (!(scale >= 0 && scale <= 3)) return fail("scale is {}; expected 0 to 3", scale);
  if (!(step_share >= 0 && step_share * scale < 0.9)) {
    return fail("step_share is {}; expected 0 to less than 0.9, times scale", step_share);
  }
  if (!(min_reaction_s >= 0 && max_reaction_s >= min_reaction_s)) {
    return fail("min_reaction_s is {} and max_reaction_s {}; expected 0 or more, the second larger",
                min_reaction_s, max_reaction_s);
  }
  return {};
}

SimulatedWalker::SimulatedWalker(const WalkedHome& home, const Vector2d& start, double heading_rad,
                                 const WalkerFaults& faults, std::uint64_t seed)
    : home_(home),
      faults_(faults),
      random_(seed, {0x77616c6b6572}),
      place_(start),
      heading_rad_(heading_rad),
      line_rad_(heading_rad) {
  veer_rad_per_m_ = fault(faults_.veer_degrees_per_m) * kDegree_rad;
  step_factor_ = 1 + fault(faults_.step_share);
}

double SimulatedWalker::fault(double most) {
  return faults_.scale * random_.between(-most, most);
}

void SimulatedWalker::hear(const Instruction& instruction) {
  if (instruction.kind == Kind::kNothing) return;
  const double reaction_s =
      faults_.min_reaction_s +
      faults_.scale * random_.uniform() * (faults_.max_reaction_s - faults_.min_reaction_s);
  list_.clear();
  heard_.push_back({instruction, ++times_told_, reaction_s});
}

void SimulatedWalker::hear_list(const std::vector<Instruction>& instructions) {
  ++times_told_;
  for (const Instruction& instruction : instructions) list_.push_back({instruction, times_told_});
}

SimulatedWalker SimulatedWalker::without_faults() const {
  SimulatedWalker exact = *this;
  exact.faults_.scale = 0;
  exact.veer_rad_per_m_ = 0;
  exact.step_factor_ = 1;
  exact.contacts_.clear();
  return exact;
}

bool SimulatedWalker::take_is_blocked() {
  return std::exchange(is_blocked_, false);
}

void SimulatedWalker::turn_by(double turn_rad, double rate_rad_s) {
  mode_ = Mode::kTurn;
  const double share = std::min(1.0, std::abs(turn_rad) / (std::numbers::pi / 2));
  turn_left_rad_ = turn_rad + share * fault(faults_.turn_degrees) * kDegree_rad;
  turn_rate_rad_s_ = rate_rad_s;
}

void SimulatedWalker::act(const Heard& heard) {
  does_ = heard.number;
  Instruction instruction = heard.instruction;
  if (random_.uniform() < faults_.scale * faults_.wrong_share) {
    if (instruction.turn_rad == 0) return;  // did not hear it
    instruction.turn_rad = -instruction.turn_rad;
  }
  is_blocked_ = false;
  // Who is on stairs goes on to their end: there nobody turns.
  if (climb_ && instruction.kind != Kind::kStop) return;
  switch (instruction.kind) {
    case Kind::kNothing:
      return;
    case Kind::kStop:
      if (climb_) return;  // told of the end, which a foot finds by itself
      mode_ = Mode::kStand;
      turn_then_rad_.reset();
      return;
    case Kind::kStairs:
      if (!climb_) begin_stairs();
      return;
    case Kind::kTurn:
      turn_then_rad_.reset();
      return turn_by(instruction.turn_rad, kTurning_rad_s);
    case Kind::kLookAround:
      turn_then_rad_.reset();
      return turn_by(2 * std::numbers::pi, kLooking_rad_s);
    case Kind::kLittle:
      if (mode_ != Mode::kWalk) return turn_by(instruction.turn_rad, kTurning_rad_s);
      line_rad_ += instruction.turn_rad * (1 + fault(faults_.turn_degrees / 90));
      return;
    case Kind::kWalk:
    case Kind::kSoon:
      // Who is told while turning by themselves finishes that first.
      if (mode_ != Mode::kWalk) line_rad_ = heading_rad_;
      mode_ = Mode::kWalk;
      counted_m_ = instruction.distance_m * step_factor_;
      turn_then_rad_.reset();
      if (instruction.kind == Kind::kSoon) turn_then_rad_ = instruction.turn_rad;
      return;
  }
}

void SimulatedWalker::step(double dt_s) {
  for (Heard& heard : heard_) heard.in_s -= dt_s;
  while (!heard_.empty() && heard_.front().in_s <= 0) {
    const Heard heard = heard_.front();
    heard_.pop_front();
    act(heard);
  }
  if (mode_ == Mode::kStand && heard_.empty() && !list_.empty()) {
    const Heard next = list_.front();
    list_.pop_front();
    act(next);
  }
  idle_s_ = mode_ == Mode::kStand && heard_.empty() ? idle_s_ + dt_s : 0;
  if (mode_ == Mode::kTurn) {
    const double turned =
        std::clamp(turn_left_rad_, -turn_rate_rad_s_ * dt_s, turn_rate_rad_s_ * dt_s);
    heading_rad_ += turned;
    line_rad_ = heading_rad_;
    turn_left_rad_ -= turned;
    if (std::abs(turn_left_rad_) < 1e-9) mode_ = Mode::kStand;
  } else if (mode_ == Mode::kWalk) {
    walk(dt_s);
  } else if (mode_ == Mode::kClimb) {
    climb(dt_s);
  }
}

void SimulatedWalker::begin_stairs() {
  constexpr double kBefore_m = 1.0;  // a cane finds the first step
  constexpr double kFacing_rad = 45 * kDegree_rad;
  for (const fusion::Staircase& stairs : home_.storeys.stairs()) {
    for (const bool is_up : {true, false}) {
      const Vector2d& begin = is_up ? stairs.below_plan : stairs.above_plan;
      const double heading = is_up ? stairs.up_rad : stairs.end_rad + std::numbers::pi;
      if ((begin - place_).norm() > kBefore_m) continue;
      if (std::abs(guide::turn_rad(heading_rad_, heading)) > kFacing_rad) continue;
      climb_ = Climb{stairs, is_up, 0};
      mode_ = Mode::kClimb;
      heading_rad_ = line_rad_ = heading;  // along the rail
      return;
    }
  }
}

// From where one stands before them to where one stands behind them: on the plan the storey changes
// where a camera at the chest comes over the upper floor.
void SimulatedWalker::climb(double dt_s) {
  constexpr double kCamera_m = 1.3;
  const fusion::Storeys& storeys = home_.storeys;
  const fusion::Staircase& stairs = climb_->stairs;
  const Vector2d up = (stairs.top_gravity - stairs.foot_gravity) / stairs.run_m;
  const double stand_m =
      (stairs.below_plan - storeys.all()[stairs.lower].plan_from_gravity - stairs.foot_gravity)
          .norm();
  const double length_m = stairs.run_m + 2 * stand_m;
  const double step_m = kCarefulSpeed_m_s * dt_s;
  climb_->gone_m = std::min(length_m, climb_->gone_m + step_m);
  walked_m_ += step_m;
  const double along_m = (climb_->is_up ? climb_->gone_m : length_m - climb_->gone_m) - stand_m;
  const double share = std::clamp(along_m / stairs.run_m, 0.0, 1.0);
  Eigen::Vector3d camera;
  camera << stairs.foot_gravity + along_m * up,
      storeys.floor_m(stairs.lower) + share * stairs.height_m + kCamera_m;
  place_ = storeys.plan_from_gravity(camera).head<2>();
  if (climb_->gone_m < length_m) return;
  climb_.reset();
  mode_ = Mode::kStand;
}

void SimulatedWalker::walk(double dt_s) {
  const double reach_m = std::min(kCane_m, counted_m_ + kNoseToWall_m);
  const auto around = way_around(reach_m);
  const bool finds = !around || *around != line_rad_ || free_ahead_m(line_rad_, kCane_m) < kCane_m;
  const double heading = around.value_or(line_rad_);
  // Faces where they walk, turning as fast as people do.
  const double turn = guide::turn_rad(heading_rad_, heading);
  heading_rad_ += std::clamp(turn, -kTurning_rad_s * dt_s, kTurning_rad_s * dt_s);
  if (!around && free_ahead_m(line_rad_, kCane_m) <= kNoseToWall_m) {
    is_blocked_ = counted_m_ > kBlocked_m;
    mode_ = Mode::kStand;
    return;
  }
  const double step_m = (finds ? kCarefulSpeed_m_s : kSpeed_m_s) * dt_s;
  line_rad_ += veer_rad_per_m_ * step_m;
  move(step_m * direction(heading_rad_));
  counted_m_ -= step_m;
  if (counted_m_ > 0) return;
  mode_ = Mode::kStand;
  if (turn_then_rad_) turn_by(*std::exchange(turn_then_rad_, std::nullopt), kTurning_rad_s);
}

void SimulatedWalker::move(const Vector2d& by) {
  const double near_m = clearance_m(home_.floor, place_ + by);
  const bool touches = near_m < kTouch_m;
  if (touches && !touches_) contacts_.push_back(place_ + by);
  touches_ = touches;
  // Does not go through things; away from what they touch they may.
  if (near_m < kInside_m && near_m <= clearance_m(home_.floor, place_)) {
    is_blocked_ = counted_m_ > kBlocked_m;
    mode_ = Mode::kStand;
    return;
  }
  place_ += by;
  walked_m_ += by.norm();
}

double SimulatedWalker::free_ahead_m(double heading_rad, double reach_m) const {
  constexpr double kStep_m = 0.05;
  const Vector2d ahead = direction(heading_rad);
  const double here_m = clearance_m(home_.cane, place_);
  for (double distance_m = kStep_m; distance_m < reach_m; distance_m += kStep_m) {
    // Along what they stand at already they may go, not nearer.
    const double needed_m = std::min(kHalfWidth_m, here_m);
    if (clearance_m(home_.cane, place_ + distance_m * ahead) < needed_m) return distance_m;
  }
  return reach_m;
}

std::optional<double> SimulatedWalker::way_around(double reach_m) const {
  // As far as the cane reaches, or else into a gap that a hand finds.
  constexpr double kGap_m = 0.5;
  for (const double free_m : {reach_m, std::min(reach_m, kGap_m)}) {
    for (const int degrees : {0, 15, 30, 45, 60, 75}) {
      for (const double side : {1.0, -1.0}) {
        const double heading = line_rad_ + side * degrees * kDegree_rad;
        if (free_ahead_m(heading, free_m) >= free_m) return heading;
      }
    }
  }
  return std::nullopt;
}

}  // namespace roomwise::trials
