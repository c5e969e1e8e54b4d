#pragma once

#include <Eigen/Core>
#include <deque>
#include <optional>
#include <vector>

#include "laboratory/trials/guidance/guided_home.h"
#include "laboratory/trials/guidance/instruction.h"
#include "roomwise/base/random.h"

namespace roomwise::trials {

// How people err who walk without seeing. All of it is scaled by one number: 0 is somebody who does
// exactly what they hear.
struct WalkerFaults {
  double scale = 1;
  double veer_degrees_per_m = 10;  // at most, to one side for a whole walk
  double step_share = 0.15;        // a step's length, at most
  double turn_degrees = 20;        // of a quarter turn, at most; less for smaller ones
  double wrong_share = 0.03;       // of what is heard: the other side, or nothing
  double min_reaction_s = 0.3, max_reaction_s = 1.5;

  [[nodiscard]] Expected<void> validate() const;
};

// Somebody who walks through a home with a cane and does what they are told. They keep a line by
// feel alone, go around what the cane finds where that is possible, and stand where it is not.
class SimulatedWalker {
 public:
  SimulatedWalker(const WalkedHome& home, const Eigen::Vector2d& start, double heading_rad,
                  const WalkerFaults& faults, std::uint64_t seed);

  // What has just been spoken to its end; acts on it after a while.
  void hear(const Instruction& instruction);
  // Several things to do one after the other, each when the one before is done.
  void hear_list(const std::vector<Instruction>& instructions);
  void step(double dt_s);
  // Here and now, about to do what they have heard, but from now on exactly: has touched nothing.
  [[nodiscard]] SimulatedWalker without_faults() const;

  [[nodiscard]] const Eigen::Vector2d& place() const { return place_; }
  [[nodiscard]] double heading_rad() const { return heading_rad_; }
  [[nodiscard]] double walked_m() const { return walked_m_; }
  // Where the body began to touch something.
  [[nodiscard]] const std::vector<Eigen::Vector2d>& contacts() const { return contacts_; }
  // How often they were told to do something, and which of it they are doing; 0: nothing yet.
  [[nodiscard]] int times_told() const { return times_told_; }
  [[nodiscard]] int does() const { return does_; }
  // Stands, has nothing to do, since so long.
  [[nodiscard]] double idle_s() const { return idle_s_; }
  // True once where the cane finds no way on and there was more to walk.
  [[nodiscard]] bool take_is_blocked();

 private:
  enum class Mode { kStand, kTurn, kWalk, kClimb };
  struct Heard {
    Instruction instruction;
    int number = 0;  // by times_told()
    double in_s = 0;
  };
  void act(const Heard& heard);
  void turn_by(double turn_rad, double rate_rad_s);
  void walk(double dt_s);
  // Begins to walk over the stairs that are before them; stands where none are.
  void begin_stairs();
  void climb(double dt_s);
  void move(const Eigen::Vector2d& by);
  // How far the cane finds nothing, a body's width, to `reach_m`.
  [[nodiscard]] double free_ahead_m(double heading_rad, double reach_m) const;
  // Where to walk so as to keep clear; nothing where there is no way on.
  [[nodiscard]] std::optional<double> way_around(double reach_m) const;
  [[nodiscard]] double fault(double most);

  const WalkedHome& home_;
  WalkerFaults faults_;
  RandomStream random_;
  double veer_rad_per_m_ = 0, step_factor_ = 1;

  std::deque<Heard> heard_, list_;
  int times_told_ = 0, does_ = 0;
  Mode mode_ = Mode::kStand;
  Eigen::Vector2d place_;
  double heading_rad_;  // where they face
  double line_rad_;     // where they mean to walk
  double turn_left_rad_ = 0, turn_rate_rad_s_ = 0;
  double counted_m_ = 0;                 // still to walk, by their own count
  std::optional<double> turn_then_rad_;  // when that is done
  struct Climb {
    fusion::Staircase stairs;
    bool is_up = true;
    double gone_m = 0;
  };
  std::optional<Climb> climb_;
  double walked_m_ = 0;
  double idle_s_ = 0;
  std::vector<Eigen::Vector2d> contacts_;
  bool touches_ = false, is_blocked_ = false;
};

}  // namespace roomwise::trials
