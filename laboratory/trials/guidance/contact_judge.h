#pragma once

#include <Eigen/Core>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "laboratory/trials/guidance/simulated_walker.h"

namespace roomwise::trials {

// Somebody touched something with the body.
struct Contact {
  double at_s = 0;
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
  std::string thing;                       // see WalkedHome::nearest_thing
  std::optional<std::size_t> prompt = {};  // which they were doing, index into what they heard
  // Who does exactly what they hear touches it, too.
  bool is_by_prompt = false;
};

// Tells of each contact whether what was said led there, or the walker's own faults did. Where a
// prompt is heard somebody without faults stands in for the walker: same place, heading, home and
// time to react. What they touch until the walker does what the next prompt asks for, that prompt
// caused; before then no later word could help.
class ContactJudge {
 public:
  explicit ContactJudge(const WalkedHome& home) : home_(home) {}

  // The walker has just heard a prompt; one that asks for nothing changes nothing.
  void hear(const SimulatedWalker& walker, std::size_t prompt);
  // After each of the walker's steps.
  void step(double now_s, const SimulatedWalker& walker);
  // At the end of the walk, all that there were.
  [[nodiscard]] std::vector<Contact> finish();

 private:
  struct Told {
    int number = 0;  // by SimulatedWalker::times_told
    std::size_t prompt = 0;
    std::size_t steps = 0;  // until then
    SimulatedWalker exact;
  };
  // Of the contacts while that was done, which is over now.
  void judge(const Told& told);

  const WalkedHome& home_;
  std::deque<Told> told_;  // what is done now, and what is heard and not done yet
  std::size_t steps_ = 0;
  std::vector<Contact> contacts_;
  std::size_t judged_ = 0;  // of the contacts
};

}  // namespace roomwise::trials
