#include "laboratory/trials/guidance/guidance_trial.h"

#include <algorithm>
#include <cmath>

#include "laboratory/simulation/home/home_geometry.h"
#include "roomwise/evaluation/quantile.h"
#include "roomwise/guide/prompt_queue.h"
#include "roomwise/guide/route_prompts.h"

namespace roomwise::trials {
namespace {

using Eigen::Vector2d;
using guide::Guidance;
using guide::kDegree_rad;
using guide::Prompt;

constexpr double kStep_s = 0.05;
constexpr double kUpdate_s = 0.2;

TimestampNs nanoseconds(double seconds) {
  // Not from 0, which no clock shows.
  return std::llround((1 + seconds) * 1e9);
}

const guide::MessageCatalogue& catalogue() {
  static const guide::MessageCatalogue built_in = guide::MessageCatalogue::built_in();
  return built_in;
}

// The voice: speaks what the queue gives, one after the other, as long as it takes.
class Voice {
 public:
  void say(Prompt prompt, double now_s) {
    made_s_[prompt.text] = now_s;
    queue_.add(std::move(prompt), nanoseconds(now_s));
  }
  struct Events {
    std::optional<Prompt> begun, ended;
    double waited_s = 0;  // what was begun
  };
  [[nodiscard]] Events step(double now_s) {
    Events events;
    if (speaking_ && now_s >= until_s_) {
      events.ended = speaking_->prompt;
      queue_.finished(speaking_->id, nanoseconds(now_s));
      speaking_.reset();
    }
    if (auto next = queue_.next(nanoseconds(now_s))) {
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
  Walk(const GuidedMap& map, const WalkedHome& home, const GuidedGoal& goal,
       const TrialOptions& options, std::uint64_t walk)
      : map_(map),
        home_(home),
        options_(options),
        wording_{&catalogue(), options.style},
        walker_(home, goal.start, goal.start_heading_rad, options.faults,
                options.seed * 1000 + walk),
        position_(options.position, options.seed * 1000 + walk) {
    record_.goal = goal;
  }

  [[nodiscard]] GuidedWalk by_session() {
    Guidance guidance(map_.view(), record_.goal.goal, wording_, options_.guidance);
    record_.is_offered = true;
    double said_s = 0, update_s = 0;
    for (double now_s = 0; now_s < options_.max_s; now_s += kStep_s) {
      walker_.step(kStep_s);
      look(now_s);
      if (now_s >= update_s) {
        update_s = now_s + kUpdate_s;
        record_.path.push_back(walker_.place());
        if (auto prompt = guidance.update(state_at(now_s))) voice_.say(*std::move(prompt), now_s);
        for (const auto request : wishes(now_s - said_s)) {
          voice_.say(guidance.request(request, nanoseconds(now_s)), now_s);
          said_s = now_s;
        }
      }
      const Voice::Events events = voice_.step(now_s);
      if (events.begun) {
        said_s = now_s;
        begin(events, now_s, guidance.next_place());
      }
      if (events.ended) walker_.hear(understand(*events.ended, wording_));
      if (guidance.is_over() && voice_.is_silent() && now_s - said_s > 6) {
        record_.has_ended = true;
        break;
      }
    }
    record_.says_there = guidance.state() == Guidance::State::kArrived;
    return finished();
  }

  // Asks, hears all legs, does them; asks again where `again`.
  [[nodiscard]] GuidedWalk by_list(bool again) {
    const guide::Goal& goal = record_.goal.goal;
    record_.is_offered = goal.kind == guide::Goal::Kind::kThing && goal.outline.has_value();
    constexpr int kMaxAsked = 15;
    int asked = 0;
    double free_s = 0, update_s = 0;
    std::vector<Instruction> legs;
    for (double now_s = 0; record_.is_offered && now_s < options_.max_s; now_s += kStep_s) {
      walker_.step(kStep_s);
      look(now_s);
      if (now_s >= update_s) {
        update_s = now_s + kUpdate_s;
        record_.path.push_back(walker_.place());
      }
      const Voice::Events events = voice_.step(now_s);
      if (events.begun) begin(events, now_s, std::nullopt);
      if (events.ended) {
        for (const Instruction& each : understand_leg(*events.ended, wording_))
          legs.push_back(each);
        record_.says_there = events.ended->message == "route.arrived";
        free_s = now_s + 0.5;
      }
      if (!voice_.is_silent() || walker_.idle_s() < 0.5 || now_s < free_s) continue;
      if (!legs.empty()) {
        walker_.hear_list(std::exchange(legs, {}));
        free_s = now_s + 1;
        continue;
      }
      record_.has_ended = record_.says_there || asked > (again ? kMaxAsked : 0);
      if (record_.has_ended) break;
      const bool is_fresh = state_.pose && now_s - pose_s_ < 0.8;
      if (!is_fresh) continue;
      ++asked;
      for (Prompt& prompt : list(now_s)) voice_.say(std::move(prompt), now_s);
      free_s = now_s + 0.2;
    }
    // Who is not told so, but did all that the list said, takes it for the end.
    if (!again && record_.has_ended) record_.says_there = true;
    return finished();
  }

 private:
  [[nodiscard]] std::vector<Prompt> list(double now_s) const {
    const guide::Goal& goal = record_.goal.goal;
    const auto route =
        guide::find_route(map_.floor, state_.pose->position_gravity, goal.outline->middle_gravity,
                          {}, &map_.layout, goal.room, map_.storeys.stairs());
    const TimestampNs now_ns = nanoseconds(now_s);
    if (!route) return {guide::no_route_prompt(true, route.error().message, wording_, now_ns)};
    return guide::route_prompts(*route, *state_.pose, goal.noun, map_.layout.doorways(), wording_,
                                now_ns, map_.storeys.stairs());
  }

  void look(double now_s) {
    const auto answer = position_.look(now_s, walker_.place(), walker_.heading_rad());
    if (!answer) return;
    state_.room.reset();
    if (answer->knows_room) {
      state_.room = home_.model.rooms[simulation::room_at(home_.model, walker_.place())].name;
    }
    if (!answer->pose) return;
    state_.pose = answer->pose;
    pose_s_ = answer->at_s;
  }
  [[nodiscard]] guide::Walker state_at(double now_s) const {
    guide::Walker walker = state_;
    walker.now_ns = nanoseconds(now_s);
    walker.pose_ns = nanoseconds(pose_s_);
    return walker;
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
    HeardPrompt heard{now_s, events.begun->message, events.begun->text, walker_.place()};
    heard.is_late = events.waited_s > 1;
    if (next) heard.is_wrong = asks_wrongly(understand(*events.begun, wording_), walker_, *next);
    if (heard.message == "guide.off") ++record_.deviations;
    if (heard.message == "guide.lost") ++record_.lost;
    record_.heard.push_back(std::move(heard));
  }

  [[nodiscard]] GuidedWalk finished() {
    record_.walked_m = walker_.walked_m();
    record_.seconds =
        record_.heard.empty() ? 0 : static_cast<double>(record_.path.size()) * kUpdate_s;
    record_.contacts = walker_.contacts();
    record_.expired = voice_.take_expired();
    record_.is_there = is_there(home_.model, record_.goal, walker_.place(), options_.goals);
    if (record_.goal.outline) {
      record_.to_goal_m = std::max(
          0.0, record_.goal.outline->distance_m(walker_.place()) - options_.goals.body_radius_m);
    }
    return std::move(record_);
  }

  const GuidedMap& map_;
  const WalkedHome& home_;
  const TrialOptions& options_;
  guide::Wording wording_;
  SimulatedWalker walker_;
  ModelledPosition position_;
  Voice voice_;
  guide::Walker state_;
  double pose_s_ = 0;
  GuidedWalk record_;
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

Expected<void> TrialOptions::validate() const {
  ROOMWISE_CHECK_OK(goals.validate());
  ROOMWISE_CHECK_OK(faults.validate());
  ROOMWISE_CHECK_OK(position.validate());
  ROOMWISE_CHECK_OK(guidance.validate());
  ROOMWISE_CHECK_OK(style.validate(catalogue()));
  if (!(max_s > 0 && patience_s > 0)) {
    return fail("max_s is {} and patience_s {}; expected more than 0", max_s, patience_s);
  }
  return {};
}

int GuidedWalk::late() const {
  return static_cast<int>(std::ranges::count_if(heard, &HeardPrompt::is_late));
}
int GuidedWalk::wrong() const {
  return static_cast<int>(std::ranges::count_if(heard, &HeardPrompt::is_wrong));
}

GuidedWalk lead(const GuidedMap& map, const WalkedHome& home, const GuidedGoal& goal,
                const TrialOptions& options, std::uint64_t walk) {
  Walk led(map, home, goal, options, walk);
  if (options.guide == Guide::kSession) return led.by_session();
  return led.by_list(options.guide == Guide::kList);
}

TrialSummary summarise(std::span<const GuidedWalk> walks) {
  TrialSummary summary;
  summary.goals = walks.size();
  std::vector<double> ratios, to_goal_m;
  double seconds = 0;
  int contacts = 0, deviations = 0, lost = 0;
  for (const GuidedWalk& walk : walks) {
    summary.offered += walk.is_offered ? 1 : 0;
    summary.over_stairs += walk.goal.is_over_stairs ? 1 : 0;
    summary.arrived_over_stairs += walk.goal.is_over_stairs && walk.arrived() ? 1 : 0;
    summary.says_there_wrongly += walk.says_there && !walk.is_there ? 1 : 0;
    summary.walked_m += walk.walked_m;
    summary.prompts += walk.heard.size();
    summary.late += static_cast<std::size_t>(walk.late());
    summary.wrong += static_cast<std::size_t>(walk.wrong());
    summary.expired += static_cast<std::size_t>(walk.expired);
    contacts += walk.contacts;
    deviations += walk.deviations;
    lost += walk.lost;
    if (!walk.arrived()) continue;
    ++summary.arrived;
    const double ratio = std::max(1.0, walk.walked_m / walk.goal.shortest_m);
    ratios.push_back(ratio);
    summary.spl += 1 / ratio;
    seconds += walk.seconds;
    if (walk.goal.outline) to_goal_m.push_back(walk.to_goal_m);
  }
  const auto count = static_cast<double>(std::max<std::size_t>(1, walks.size()));
  const auto arrived = static_cast<double>(std::max<std::size_t>(1, summary.arrived));
  summary.spl /= count;
  summary.mean_s = seconds / arrived;
  for (const double ratio : ratios) summary.path_ratio += ratio / arrived;
  for (const double ratio : ratios) {
    summary.path_ratio_deviation += std::pow(ratio - summary.path_ratio, 2) / arrived;
  }
  summary.path_ratio_deviation = std::sqrt(summary.path_ratio_deviation);
  summary.contacts_per_walk = contacts / count;
  summary.deviations_per_walk = deviations / count;
  summary.lost_per_walk = lost / count;
  if (summary.walked_m > 0) {
    summary.prompts_per_m = static_cast<double>(summary.prompts) / summary.walked_m;
  }
  if (!to_goal_m.empty()) summary.median_to_goal_m = evaluation::quantile(to_goal_m, 0.5);
  return summary;
}

}  // namespace roomwise::trials
