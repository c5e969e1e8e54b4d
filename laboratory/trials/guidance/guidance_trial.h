#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "laboratory/trials/guidance/contact_judge.h"
#include "laboratory/trials/guidance/guided_home.h"
#include "laboratory/trials/guidance/leader.h"
#include "laboratory/trials/guidance/modelled_position.h"
#include "laboratory/trials/guidance/simulated_walker.h"
#include "roomwise/guide/led/guidance.h"

// Made-up people are led through made-up homes by what they hear.
namespace roomwise::trials {

// By what somebody is led.
enum class Guide {
  kSession,   // guide::Guidance
  kListOnce,  // the list of legs that "way to" answers with, asked for once
  kList,      // the same, asked for again at each list's end
};
[[nodiscard]] std::string_view to_string(Guide guide);

struct TrialOptions {
  std::uint64_t seed = 0;
  std::uint64_t home_seed = 0;  // each home has people of its own; guides lead the same ones
  Guide guide = Guide::kSession;
  GoalOptions goals = {};
  WalkerFaults faults = {};
  PositionModel position = {};
  guide::SpeakingStyle style = {};
  guide::GuidanceOptions guidance = {};
  double max_s = 300;      // then they give up
  double patience_s = 12;  // who hears nothing so long asks for the last word again

  [[nodiscard]] Expected<void> validate() const;
};

// Of all that is drawn by chance on it.
[[nodiscard]] std::uint64_t seed_of_walk(const TrialOptions& options, std::uint64_t walk);

struct HeardPrompt {
  double at_s = 0;  // began to be spoken
  std::string message_id, text;
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
  bool is_late = false;   // for more than a second it could not be begun
  bool is_wrong = false;  // asked for a way that the true place does not need, by 45 degrees
};

struct GuidedWalk {
  GuidedGoal goal;
  bool is_offered = false;  // the guide knew of the goal
  bool has_ended = false;   // by the guide's word, and not by giving up
  bool says_there = false;
  bool is_there = false;  // in truth, at the end
  double walked_m = 0;
  double seconds = 0;
  std::vector<Contact> contacts;  // of the body with things and walls
  int deviations = 0;             // off the way
  int lost = 0;
  int expired = 0;               // prompts that came too late to be begun
  int repeats = 0, blocked = 0;  // asked for by the person
  double to_goal_m = 0;          // from their edge, at the end
  Sightings sightings;
  std::optional<std::string> broken_off = {};  // why nobody led them to the end
  std::vector<HeardPrompt> heard;
  std::vector<Eigen::Vector2d> path;  // five times a second

  // Was led there and told so.
  [[nodiscard]] bool arrived() const { return says_there && is_there; }
  // There is no way as things are, and the guide said that it knows none.
  [[nodiscard]] bool is_told_not_reachable() const {
    return !goal.is_reachable && has_ended && !says_there;
  }
  [[nodiscard]] int turns() const;  // that were asked for
  [[nodiscard]] int late() const;
  [[nodiscard]] int wrong() const;
  [[nodiscard]] int contacts_by_prompt() const;
};

[[nodiscard]] GuidedWalk lead(const GuidedMap& map, const WalkedHome& home, const GuidedGoal& goal,
                              const TrialOptions& options, std::uint64_t walk,
                              const std::optional<Leaving>& leaving = {});
// The same person, judged alike, led by anybody.
[[nodiscard]] GuidedWalk lead_by(Leader& leader, const WalkedHome& home, const GuidedGoal& goal,
                                 const TrialOptions& options, std::uint64_t walk);

// What is led to: "thing", "room", "door", "way out" or "spot".
[[nodiscard]] std::string_view to_string(guide::Goal::Kind kind);

struct KindSummary {
  std::size_t goals = 0, arrived = 0;
};

struct TrialSummary {
  std::size_t goals = 0, offered = 0, arrived = 0;
  std::map<std::string, KindSummary, std::less<>> by_kind;  // of goal; those there are
  std::size_t over_stairs = 0, arrived_over_stairs = 0;     // of goals on another storey
  std::size_t hindered = 0;                                 // something was in the way
  std::size_t arrived_hindered = 0;                         // where there is another way
  std::size_t without_way = 0, not_reachable = 0;           // no other way; and the guide said so
  std::size_t says_there_wrongly = 0;                       // told so, and is not
  double spl = 0;  // success weighted by path length: mean of arrived * shortest / max(both)
  // Of those who arrived; absent of none: the path over the shortest one, its mean and standard
  // deviation, and the time.
  std::optional<double> path_ratio, path_ratio_deviation, mean_s;
  double walked_m = 0;
  double contacts_per_walk = 0, turns_per_walk = 0;
  std::optional<double> prompts_per_m;  // absent where nobody went anywhere
  std::size_t contacts = 0, contacts_by_prompt = 0;
  std::size_t prompts = 0, late = 0, wrong = 0, expired = 0;
  double deviations_per_walk = 0, lost_per_walk = 0;
  std::optional<double> median_to_goal_m;               // of things that were reached
  std::size_t broken_off = 0;                           // walks that nobody led to the end
  std::size_t pictures = 0, placed = 0, beyond_1m = 0;  // of all walks; placed a metre or more off
  std::optional<double> median_position_error_m, p95_position_error_m;  // of those placed
  std::optional<double> median_heading_error_rad, p95_heading_error_rad;
};
[[nodiscard]] TrialSummary summarise(std::span<const GuidedWalk> walks);

}  // namespace roomwise::trials
