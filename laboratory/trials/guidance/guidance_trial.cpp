#include "laboratory/trials/guidance/guidance_trial.h"

#include <algorithm>
#include <cmath>

#include "laboratory/trials/guidance/modelled_leader.h"
#include "roomwise/base/random.h"
#include "roomwise/evaluation/statistics/quantile.h"
#include "roomwise/guide/answers/route_prompts.h"
#include "roomwise/guide/words/prompt_queue.h"

namespace roomwise::trials {
namespace {

using Eigen::Vector2d;
using guide::kDegree_rad;
using guide::Prompt;

constexpr double kNote_s = 0.2;  // between the places of a path

const guide::MessageCatalogue& catalogue() {
  static const guide::MessageCatalogue built_in = guide::MessageCatalogue::built_in();
  return built_in;
}

// The voice: speaks what the queue gives, one after the other, as long as it takes.
class Voice {
 public:
  void say(Prompt prompt, double now_s) {
    made_s_[prompt.text] = now_s;
    queue_.add(std::move(prompt), trial_ns(now_s));
  }
  struct Events {
    std::optional<Prompt> begun, ended;
    double waited_s = 0;  // what was begun
  };
  [[nodiscard]] Events step(double now_s) {
    Events events;
    if (speaking_ && now_s >= until_s_) {
      events.ended = speaking_->prompt;
      queue_.finished(speaking_->id, trial_ns(now_s));
      speaking_.reset();
    }
    if (auto next = queue_.next(trial_ns(now_s))) {
      events.begun = next->prompt;
      events.waited_s = now_s - made_s_[next->prompt.text];
      until_s_ = now_s + guide::speaking_s(next->prompt.text);
      speaking_ = std::move(next);
    }
    return events;
  }
  [[nodiscard]] bool is_silent() const { return !speaking_; }
  [[nodiscard]] int take_expired() { return queue_.take_expired_answers(); }

 private:
  guide::PromptQueue queue_;
  std::optional<guide::Utterance> speaking_;
  double until_s_ = 0;
  std::map<std::string, double> made_s_;
};

// Whether what a prompt asks for is far from what the true place needs.
bool asks_wrongly(const Instruction& asked, const SimulatedWalker& walker, const Vector2d& next) {
  using Kind = Instruction::Kind;
  const bool is_direction =
      asked.kind == Kind::kTurn || asked.kind == Kind::kLittle || asked.kind == Kind::kWalk;
  const Vector2d towards = next - walker.place();
  constexpr double kUnderfoot_m = 0.7;
  if (!is_direction || towards.norm() < kUnderfoot_m) return false;
  const double needed = guide::turn_rad(walker.heading_rad(), std::atan2(towards.y(), towards.x()));
  return std::abs(guide::turn_rad(asked.turn_rad, needed)) > 45 * kDegree_rad;
}

// One person, one goal.
class Walk {
 public:
  Walk(const WalkedHome& home, const GuidedGoal& goal, const TrialOptions& options,
       std::uint64_t walk)
      : home_(home),
        options_(options),
        wording_{&catalogue(), options.style},
        walker_(home, goal.start, goal.start_heading_rad, options.faults,
                seed_of_walk(options, walk)),
        judge_(home),
        walk_(walk) {
    record_.goal = goal;
  }

  // Somebody out of the way, who is in `home` until then.
  void let_go(const Leaving& leaving, WalkedHome& home) {
    leaving_ = &leaving;
    changes_ = &home;
  }

  [[nodiscard]] GuidedWalk led_by(Leader& leader) {
    double said_s = 0, note_s = 0;
    const auto say = [&](Expected<std::vector<Prompt>> prompts, double now_s) {
      if (!prompts) record_.broken_off = std::move(prompts).error().message;
      if (!prompts) return false;
      for (Prompt& prompt : *prompts) voice_.say(std::move(prompt), now_s);
      return true;
    };
    for (double now_s = 0; now_s < options_.max_s; now_s += kWalkerStep_s) {
      step(now_s);
      bool is_led = say(leader.after_step(now_s, walker_), now_s);
      if (now_s >= note_s) {
        note_s = now_s + kNote_s;
        record_.path.push_back(walker_.place());
        for (const auto request : wishes(now_s - said_s)) {
          is_led = is_led && say(leader.request(request, now_s), now_s);
          said_s = now_s;
        }
      }
      if (!is_led) break;
      const Voice::Events events = voice_.step(now_s);
      if (events.ended) {
        walker_.hear(understand(*events.ended, wording_));
        judge_.hear(walker_, record_.heard.size() - 1);
      }
      if (events.begun) {
        // What stands ahead is told again and again to who stands before it, and leads nowhere.
        if (events.begun->priority != guide::Priority::kHazard) said_s = now_s;
        begin(events, now_s, leader.next_place(walker_));
      }
      if (leader.is_over() && voice_.is_silent() && now_s - said_s > 6) {
        record_.has_ended = true;
        break;
      }
    }
    record_.is_offered = leader.knows_goal();
    record_.says_there = leader.says_there();
    record_.sightings = leader.sightings();
    return finished();
  }

  // Asks, hears all legs, does them; asks again where `again`.
  [[nodiscard]] GuidedWalk by_list(const GuidedMap& map, bool again) {
    ModelledSight sight(home_, options_.position, seed_of_walk(options_, walk_));
    const guide::Goal& goal = record_.goal.goal;
    record_.is_offered = goal.kind == guide::Goal::Kind::kThing && goal.outline.has_value();
    constexpr int kMaxAsked = 15;
    int asked = 0;
    double free_s = 0, note_s = 0;
    std::vector<Instruction> legs;
    for (double now_s = 0; record_.is_offered && now_s < options_.max_s; now_s += kWalkerStep_s) {
      step(now_s);
      sight.look(now_s, walker_);
      if (now_s >= note_s) {
        note_s = now_s + kNote_s;
        record_.path.push_back(walker_.place());
      }
      const Voice::Events events = voice_.step(now_s);
      if (events.begun) begin(events, now_s, std::nullopt);
      if (events.ended) {
        for (const Instruction& each : understand_leg(*events.ended, wording_))
          legs.push_back(each);
        record_.says_there = events.ended->message_id == "route.arrived";
        free_s = now_s + 0.5;
      }
      if (!voice_.is_silent() || walker_.idle_s() < 0.5 || now_s < free_s) continue;
      if (!legs.empty()) {
        walker_.hear_list(std::exchange(legs, {}));
        judge_.hear(walker_, record_.heard.size() - 1);
        free_s = now_s + 1;
        continue;
      }
      record_.has_ended = record_.says_there || asked > (again ? kMaxAsked : 0);
      if (record_.has_ended) break;
      const bool is_fresh = sight.pose() && sight.pose_age_s(now_s) < 0.8;
      if (!is_fresh) continue;
      ++asked;
      for (Prompt& prompt : list(map, *sight.pose(), now_s)) voice_.say(std::move(prompt), now_s);
      free_s = now_s + 0.2;
    }
    // Who is not told so, but did all that the list said, takes it for the end.
    if (!again && record_.has_ended) record_.says_there = true;
    record_.sightings = sight.sightings();
    return finished();
  }

 private:
  void step(double now_s) {
    if (leaving_ != nullptr) go_away(now_s);
    walker_.step(kWalkerStep_s);
    judge_.step(now_s, walker_);
  }

  void go_away(double now_s) {
    constexpr double kCameUp_m = 1.5;
    if (!came_up_s_ && (walker_.place() - leaving_->place).norm() < kCameUp_m) came_up_s_ = now_s;
    if (!came_up_s_ || now_s - *came_up_s_ < leaving_->after_s) return;
    *changes_ = *leaving_->then;
    leaving_ = nullptr;
  }

  [[nodiscard]] std::vector<Prompt> list(const GuidedMap& map, const guide::Pose& pose,
                                         double now_s) const {
    const guide::Goal& goal = record_.goal.goal;
    const auto route = guide::find_route(map.floor, pose.position_plan, goal.outline->middle_plan,
                                         {}, &map.layout, goal.room, map.storeys.stairs());
    const TimestampNs now_ns = trial_ns(now_s);
    if (!route) return {guide::no_route_prompt(true, route.error().message, wording_, now_ns)};
    return guide::route_prompts(*route, pose, goal.noun, map.layout.doorways(), wording_, now_ns,
                                map.storeys.stairs());
  }

  // What somebody asks for who hears nothing or does not get on.
  [[nodiscard]] std::vector<guide::GuidanceRequest> wishes(double silent_s) {
    if (walker_.idle_s() > 2 && silent_s > 2 && walker_.take_is_blocked()) {
      ++record_.blocked;
      return {guide::GuidanceRequest::kBlocked};
    }
    if (walker_.idle_s() > options_.patience_s && silent_s > options_.patience_s) {
      ++record_.repeats;
      return {guide::GuidanceRequest::kRepeat};
    }
    return {};
  }

  void begin(const Voice::Events& events, double now_s, const std::optional<Vector2d>& next) {
    HeardPrompt heard{now_s, events.begun->message_id, events.begun->text, walker_.place()};
    heard.is_late = events.waited_s > 1;
    if (next) heard.is_wrong = asks_wrongly(understand(*events.begun, wording_), walker_, *next);
    if (heard.message_id == "guide.off") ++record_.deviations;
    if (heard.message_id.starts_with("guide.lost")) ++record_.lost;
    record_.heard.push_back(std::move(heard));
  }

  [[nodiscard]] GuidedWalk finished() {
    record_.walked_m = walker_.walked_m();
    record_.seconds =
        record_.heard.empty() ? 0 : static_cast<double>(record_.path.size()) * kNote_s;
    record_.contacts = judge_.finish();
    record_.expired = voice_.take_expired();
    record_.is_there = is_there(home_.model, record_.goal, walker_.place(), options_.goals);
    if (record_.goal.outline) {
      record_.to_goal_m = std::max(
          0.0, record_.goal.outline->distance_m(walker_.place()) - options_.goals.body_radius_m);
    }
    return std::move(record_);
  }

  const WalkedHome& home_;
  const TrialOptions& options_;
  guide::Wording wording_;
  SimulatedWalker walker_;
  ContactJudge judge_;
  std::uint64_t walk_;
  Voice voice_;
  GuidedWalk record_;
  const Leaving* leaving_ = nullptr;
  WalkedHome* changes_ = nullptr;
  std::optional<double> came_up_s_;
};

}  // namespace

std::string_view to_string(Guide guide) {
  switch (guide) {
    case Guide::kSession:
      return "session";
    case Guide::kListOnce:
      return "list-once";
    case Guide::kList:
      return "list";
  }
  return "unknown";
}

std::string_view to_string(guide::Goal::Kind kind) {
  switch (kind) {
    case guide::Goal::Kind::kThing:
      return "thing";
    case guide::Goal::Kind::kRoom:
      return "room";
    case guide::Goal::Kind::kDoor:
      return "door";
    case guide::Goal::Kind::kWayOut:
      return "way out";
    case guide::Goal::Kind::kSpot:
      return "spot";
  }
  return "unknown";
}

std::uint64_t seed_of_walk(const TrialOptions& options, std::uint64_t walk) {
  return RandomStream(options.seed, {options.home_seed, walk}).next();
}

Expected<void> TrialOptions::validate() const {
  ROOMWISE_RETURN_IF_ERROR(goals.validate());
  ROOMWISE_RETURN_IF_ERROR(faults.validate());
  ROOMWISE_RETURN_IF_ERROR(position.validate());
  ROOMWISE_RETURN_IF_ERROR(guidance.validate());
  ROOMWISE_RETURN_IF_ERROR(style.validate(catalogue()));
  if (!(max_s > 0 && patience_s > 0)) {
    return fail("max_s is {} and patience_s {}; expected more than 0", max_s, patience_s);
  }
  return {};
}

int GuidedWalk::turns() const {
  return static_cast<int>(std::ranges::count_if(heard, [](const HeardPrompt& prompt) {
    return prompt.message_id.starts_with("guide.turn_");
  }));
}
int GuidedWalk::late() const {
  return static_cast<int>(std::ranges::count_if(heard, &HeardPrompt::is_late));
}
int GuidedWalk::wrong() const {
  return static_cast<int>(std::ranges::count_if(heard, &HeardPrompt::is_wrong));
}
int GuidedWalk::contacts_by_prompt() const {
  return static_cast<int>(std::ranges::count_if(contacts, &Contact::is_by_prompt));
}

GuidedWalk lead(const GuidedMap& map, const WalkedHome& at_first, const GuidedGoal& goal,
                const TrialOptions& options, std::uint64_t walk,
                const std::optional<Leaving>& leaving) {
  WalkedHome home = at_first;  // as it is now
  if (options.guide != Guide::kSession) {
    return Walk(home, goal, options, walk).by_list(map, options.guide == Guide::kList);
  }
  ModelledSight sight(home, options.position, seed_of_walk(options, walk));
  ModelledLeader leader(map.view(), goal.goal, {&catalogue(), options.style}, options.guidance,
                        sight);
  Walk led(home, goal, options, walk);
  if (leaving) led.let_go(*leaving, home);
  return led.led_by(leader);
}

GuidedWalk lead_by(Leader& leader, const WalkedHome& home, const GuidedGoal& goal,
                   const TrialOptions& options, std::uint64_t walk) {
  return Walk(home, goal, options, walk).led_by(leader);
}

TrialSummary summarise(std::span<const GuidedWalk> walks) {
  TrialSummary summary;
  summary.goals = walks.size();
  std::vector<double> ratios, to_goal_m, position_errors_m, heading_errors_rad;
  double seconds = 0;
  int deviations = 0, lost = 0;
  for (const GuidedWalk& walk : walks) {
    summary.offered += walk.is_offered ? 1 : 0;
    KindSummary& of_kind = summary.by_kind[std::string(to_string(walk.goal.goal.kind))];
    ++of_kind.goals;
    of_kind.arrived += walk.arrived() ? 1 : 0;
    summary.hindered += walk.goal.is_hindered ? 1 : 0;
    const bool has_other_way = walk.goal.is_hindered && walk.goal.is_reachable;
    summary.arrived_hindered += has_other_way && walk.arrived() ? 1 : 0;
    summary.without_way += walk.goal.is_reachable ? 0 : 1;
    summary.not_reachable += walk.is_told_not_reachable() ? 1 : 0;
    summary.over_stairs += walk.goal.is_over_stairs ? 1 : 0;
    summary.arrived_over_stairs += walk.goal.is_over_stairs && walk.arrived() ? 1 : 0;
    summary.says_there_wrongly += walk.says_there && !walk.is_there ? 1 : 0;
    summary.walked_m += walk.walked_m;
    summary.prompts += walk.heard.size();
    summary.late += static_cast<std::size_t>(walk.late());
    summary.wrong += static_cast<std::size_t>(walk.wrong());
    summary.expired += static_cast<std::size_t>(walk.expired);
    summary.contacts += walk.contacts.size();
    summary.contacts_by_prompt += static_cast<std::size_t>(walk.contacts_by_prompt());
    deviations += walk.deviations;
    lost += walk.lost;
    summary.turns_per_walk += walk.turns();
    summary.broken_off += walk.broken_off ? 1 : 0;
    summary.pictures += walk.sightings.pictures;
    std::ranges::copy(walk.sightings.position_errors_m, std::back_inserter(position_errors_m));
    std::ranges::copy(walk.sightings.heading_errors_rad, std::back_inserter(heading_errors_rad));
    if (!walk.arrived()) continue;
    ++summary.arrived;
    const double ratio = std::max(1.0, walk.walked_m / walk.goal.shortest_m);
    ratios.push_back(ratio);
    summary.spl += 1 / ratio;
    seconds += walk.seconds;
    if (walk.goal.outline) to_goal_m.push_back(walk.to_goal_m);
  }
  const auto count = static_cast<double>(std::max<std::size_t>(1, walks.size()));
  summary.spl /= count;
  if (summary.arrived > 0) {
    const auto arrived = static_cast<double>(summary.arrived);
    summary.mean_s = seconds / arrived;
    double mean = 0, variance = 0;
    for (const double ratio : ratios) mean += ratio / arrived;
    for (const double ratio : ratios) variance += std::pow(ratio - mean, 2) / arrived;
    summary.path_ratio = mean;
    summary.path_ratio_deviation = std::sqrt(variance);
  }
  summary.contacts_per_walk = static_cast<double>(summary.contacts) / count;
  summary.deviations_per_walk = deviations / count;
  summary.lost_per_walk = lost / count;
  summary.turns_per_walk /= count;
  if (summary.walked_m > 0) {
    summary.prompts_per_m = static_cast<double>(summary.prompts) / summary.walked_m;
  }
  summary.placed = position_errors_m.size();
  if (summary.placed > 0) {
    constexpr double kFarOff_m = 1;
    summary.median_position_error_m = evaluation::quantile(position_errors_m, 0.5);
    summary.p95_position_error_m = evaluation::quantile(position_errors_m, 0.95);
    summary.beyond_1m = static_cast<std::size_t>(std::ranges::count_if(
        position_errors_m, [](double error_m) { return error_m > kFarOff_m; }));
    summary.median_heading_error_rad = evaluation::quantile(heading_errors_rad, 0.5);
    summary.p95_heading_error_rad = evaluation::quantile(heading_errors_rad, 0.95);
  }
  if (!to_goal_m.empty()) summary.median_to_goal_m = evaluation::quantile(to_goal_m, 0.5);
  return summary;
}

}  // namespace roomwise::trials
