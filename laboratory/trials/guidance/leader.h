#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "laboratory/trials/guidance/simulated_walker.h"
#include "roomwise/base/expected.h"
#include "roomwise/guide/led/guidance.h"

namespace roomwise::trials {

constexpr double kWalkerStep_s = 0.05;

// The clock of a trial, s since somebody set out, as others read it. Not from 0, which no clock
// shows.
[[nodiscard]] inline TimestampNs trial_ns(double seconds) {
  return std::llround((1 + seconds) * 1e9);
}

// The pictures that were taken while somebody was led, and how far their places are from the truth.
struct Sightings {
  std::size_t pictures = 0;
  // Of those that were placed: over the floor, m, and of where the camera looked, rad; at least 0.
  std::vector<double> position_errors_m, heading_errors_rad;

  void add(const Eigen::Vector2d& by_m, double turned_rad) {
    position_errors_m.push_back(by_m.norm());
    heading_errors_rad.push_back(std::abs(turned_rad));
  }
};

// Whoever leads somebody to a goal. Nothing of a walker but where they are reaches it.
class Leader {
 public:
  virtual ~Leader() = default;

  // After each step of the walker: what they begin to be told now. Fails where nobody leads any
  // more.
  [[nodiscard]] virtual Expected<std::vector<guide::Prompt>> after_step(
      double now_s, const SimulatedWalker& walker) = 0;
  // The answer to what the walker asks for.
  [[nodiscard]] virtual Expected<std::vector<guide::Prompt>> request(guide::GuidanceRequest request,
                                                                     double now_s) = 0;

  // ---- for who judges ----
  [[nodiscard]] virtual bool knows_goal() const = 0;
  [[nodiscard]] virtual bool is_over() const = 0;
  [[nodiscard]] virtual bool says_there() const = 0;
  // Where the leg ends that is to be walked, in the home's true frame.
  [[nodiscard]] virtual std::optional<Eigen::Vector2d> next_place(
      const SimulatedWalker& walker) const = 0;
  [[nodiscard]] virtual const Sightings& sightings() const = 0;
};

}  // namespace roomwise::trials
