#include "roomwise/live/device/led_walk.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "roomwise/guide/answers/thing_prompts.h"

namespace roomwise::live {
namespace {

using guide::Goal;
using guide::Noun;

// Of several the one that costs the least way, where a whole way is known; else the surest.
std::optional<Goal> nearest(std::vector<Goal> goals, const guide::HomeMap& map,
                            const guide::UserLocation& location) {
  if (goals.empty()) return std::nullopt;
  std::size_t best = 0;
  double min_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; goals.size() > 1 && i < goals.size(); ++i) {
    const guide::Plan plan = guide::plan_way(map, location, goals[i]);
    if (plan.status != guide::PlanStatus::kComplete) continue;
    const auto stairs = map.storeys != nullptr ? std::span(map.storeys->stairs())
                                               : std::span<const fusion::Staircase>();
    const double way_m = guide::length_m(plan.route, stairs);
    if (way_m >= min_m) continue;
    min_m = way_m;
    best = i;
  }
  return goals[best];
}

std::optional<Goal> room_called(const std::string& asked, const HomeView& home,
                                const guide::Phrasebook& phrases) {
  if (!home.layout) return std::nullopt;
  std::vector<std::string> names = phrases.words_for(Noun::Kind::kRoom, asked);
  names.insert(names.begin(), asked);
  for (const std::string& name : names) {
    for (const rooms::RoomExtent& room : home.layout->rooms()) {
      if (room.name == name) return Goal::of(room);
    }
  }
  return std::nullopt;
}

guide::HomeMap map_on(const std::optional<CalendarTime>& today, const HomeView& home,
                      std::span<const rooms::Doorway> doorways) {
  guide::HomeMap map = map_of(home, doorways);
  map.today = today;
  return map;
}

Goal goal_of(const ViewedSpot& spot) {
  Goal goal;
  goal.kind = Goal::Kind::kSpot;
  goal.noun = {Noun::Kind::kThing, spot.thing.name};
  goal.room = spot.thing.room;
  if (spot.thing.position_plan) {
    goal.outline.emplace();
    goal.outline->middle_plan = spot.thing.position_plan->head<2>();
  }
  return goal;
}

// Of the doors of a room those to where somebody is; else all.
std::vector<Goal> door_goals(const service::Ask& asked, std::vector<rooms::Doorway> doors,
                             const guide::UserLocation& location) {
  const auto leads_here = [&](const rooms::Doorway& door) {
    return location.room && door.joins(*location.room);
  };
  if (!asked.in_room.empty() && std::ranges::any_of(doors, leads_here)) {
    std::erase_if(doors, std::not_fn(leads_here));
  }
  std::vector<Goal> goals;
  for (const rooms::Doorway& door : doors) {
    goals.push_back(Goal::of(door));
    if (leads_here(door)) goals.back().room = location.room;
  }
  return goals;
}

// The things of the name that is asked for.
std::vector<guide::KnownThing> things_meant(const service::Ask& asked, const HomeView& home,
                                            const guide::Phrasebook& phrases) {
  auto things = things_asked_for(asked, home, phrases);
  const auto meant =
      guide::thing_meant(name_asked_for(asked), things, home.concepts.vocabulary, phrases);
  std::erase_if(things, [&](const auto& one) { return !meant || one.name != *meant; });
  return things;
}

// A spot, the way out, things of the home, a room, or doors: each is what is asked for.
std::vector<Goal> goals_of(const service::Ask& asked, const HomeView& home,
                           const guide::UserLocation& location,
                           const service::SpeakingSettings& settings,
                           const std::optional<CalendarTime>& today) {
  const guide::Wording wording = wording_of(settings);
  const guide::Phrasebook& phrases = wording.phrases();
  const auto doors = doors_asked_for(asked, home, phrases);
  if (!asked.is_room && (!doors || asked.to_room.empty())) {
    if (const ViewedSpot* const spot = spot_asked_for(asked, home, phrases)) {
      return {goal_of(*spot)};
    }
    std::vector<Goal> goals;
    for (const guide::KnownThing& thing : things_meant(asked, home, phrases)) {
      goals.push_back(Goal::of(thing, today, home.things));
      if (thing.name == guide::kNameOfWayOut) goals.back().kind = Goal::Kind::kWayOut;
    }
    if (!goals.empty()) return goals;
  }
  if (auto room = room_called(asked.subject, home, phrases)) return {*std::move(room)};
  return doors ? door_goals(asked, *doors, location) : std::vector<Goal>();
}

// What is nearer than that is still in reach where the way ends.
bool is_same_place(const Goal& one, const Goal& other) {
  if (one.outline.has_value() != other.outline.has_value()) return false;
  if (!one.outline) return one.room == other.room;
  const double apart_m = (one.outline->middle_plan - other.outline->middle_plan).norm();
  return apart_m <= kMaxSpotSigma_m;
}

}  // namespace

LedWalk::LedWalk(service::Ask asked, std::shared_ptr<const HomeView> home, Goal goal,
                 const Situation& situation, std::vector<guide::BarredPlace> barred)
    : asked_(std::move(asked)),
      asked_by_(situation.settings),
      settings_(situation.settings),
      today_(situation.today),
      home_(std::move(home)),
      newest_home_(home_),
      doorways_(doorways_of(*home_)),
      guidance_(std::make_unique<guide::Guidance>(map_on(today_, *home_, doorways_),
                                                  std::move(goal), wording_of(settings_),
                                                  guide::GuidanceOptions{}, std::move(barred))) {}

std::unique_ptr<LedWalk> LedWalk::to(const service::Ask& goal,
                                     const std::shared_ptr<const HomeView>& home,
                                     const Situation& situation, const LedWalk* before) {
  const std::vector<rooms::Doorway> doorways = doorways_of(*home);
  const guide::UserLocation location = standing_of(situation.result);
  auto found = nearest(goals_of(goal, *home, location, situation.settings, situation.today),
                       map_of(*home, doorways), location);
  if (!found) return nullptr;
  std::vector<guide::BarredPlace> barred;
  if (before != nullptr && before->is_same_map(*home)) barred = before->guidance_->floor().places();
  return std::unique_ptr<LedWalk>(
      new LedWalk(goal, home, *std::move(found), situation, std::move(barred)));
}

// What helpers look at may be fused later: the floor and the places stay what they are.
bool LedWalk::is_same_map(const HomeView& home) const {
  return home.map == home_->map || (home.map && home_->map && home.map->localizer &&
                                    home.map->localizer == home_->map->localizer);
}

bool LedWalk::is_goal_there(const HomeView& home) const {
  // Where a taught thing was seen last changes with every look at it: it is known by its name.
  const guide::Wording wording = wording_of(asked_by_);
  const auto meant = things_meant(asked_, home, wording.phrases());
  if (std::ranges::any_of(meant, &guide::KnownThing::is_taught)) return true;
  const auto goals =
      goals_of(asked_, home, {}, asked_by_, today_);  // from wherever they are by now
  return std::ranges::any_of(
      goals, [&](const Goal& goal) { return is_same_place(goal, guidance_->goal()); });
}

TimestampNs LedWalk::at(double t_ms) {
  now_ns_ = std::max(now_ns_, static_cast<TimestampNs>(std::llround(t_ms * 1e6)));
  return now_ns_;
}

guide::Prompt LedWalk::begin(const Situation& situation) {
  const guide::UserLocation location = standing_of(situation.result);
  guide::Walker walker;
  walker.now_ns = at(situation.now_t_ms);
  walker.pose = location.pose;
  walker.pose_ns =
      situation.result != nullptr ? std::llround(situation.result->t_ms * 1e6) : walker.now_ns;
  walker.room = location.room;
  if (auto prompt = guidance_->update(walker)) return *std::move(prompt);
  return guidance_->request(guide::GuidanceRequest::kRepeat, walker.now_ns);
}

std::vector<guide::Prompt> LedWalk::after(const FrameResult& result,
                                          const std::shared_ptr<const HomeView>& home) {
  // Until a new map is ready no picture tells of a place.
  const bool is_ready = home->map || !home_->map;
  // On stairs nothing else is said.
  const bool is_on_stairs = guidance_->state() == guide::Guidance::State::kStairs;
  if (is_ready && !is_over() && !is_on_stairs && home != newest_home_) {
    if (!is_same_map(*home) || !is_goal_there(*home)) return begin_anew(result, home);
    newest_home_ = home;
  }
  const guide::UserLocation location = standing_of(&result);
  guide::Walker walker;
  walker.now_ns = at(result.t_ms);
  walker.pose = location.pose;
  walker.pose_ns = std::llround(result.t_ms * 1e6);
  walker.room = location.room;
  walker.obstacle_m = result.seen_ahead_m;
  walker.has_depth = result.has_depth;
  walker.obstacles = result.obstacles;
  auto prompt = guidance_->update(walker);
  if (!prompt) return {};
  return {*std::move(prompt)};
}

// The picture may have been looked at on the map before.
std::vector<guide::Prompt> LedWalk::begin_anew(const FrameResult& result,
                                               const std::shared_ptr<const HomeView>& home) {
  const TimestampNs now_ns = at(result.t_ms);
  const Situation now{*home, &result, asked_by_, result.t_ms, today_};
  auto anew = to(asked_, home, now, this);
  if (!anew) return {guidance_->end_without_goal(now_ns)};
  anew->speak_by(settings_);
  anew->now_ns_ = now_ns;
  if (guidance_->state() == guide::Guidance::State::kPaused) {
    (void)anew->guidance_->request(guide::GuidanceRequest::kPause, now_ns);
  }
  const auto stop = guidance_->stop_who_walks(now_ns);
  *this = std::move(*anew);
  if (!stop) return {};
  return {*stop};
}

void LedWalk::speak_by(const service::SpeakingSettings& settings) {
  settings_ = settings;
  guidance_->speak_by(wording_of(settings));
}

bool LedWalk::follows_way() const {
  using State = guide::Guidance::State;
  const State state = guidance_->state();
  return state == State::kBeginning || state == State::kTurning || state == State::kWalking ||
         state == State::kCorner || state == State::kStopped;
}

std::optional<service::GoalBearing> LedWalk::goal_bearing(double taken_t_ms) const {
  constexpr double kValid_ms = 1000;  // who turns has turned away by then
  const auto bearing = guidance_->goal_bearing();
  if (!bearing) return std::nullopt;
  return service::GoalBearing{taken_t_ms, bearing->bearing_rad / guide::kDegree_rad,
                              bearing->distance_m, taken_t_ms + kValid_ms};
}

service::WatchedWalk LedWalk::watched() const {
  service::WatchedWalk walk;
  const guide::Wording wording = wording_of(settings_);
  walk.language = wording.phrases().language();
  walk.goal = wording.phrases().called(guidance_->goal().noun);
  walk.state = guide::to_string(guidance_->course());
  walk.left_m = guidance_->left_m();
  if (!is_over()) walk.way = guidance_->plan().route;
  return walk;
}

guide::Prompt LedWalk::hear(service::GuideWish wish, double now_t_ms) {
  using service::GuideWish;
  const auto request = [&] {
    switch (wish) {
      case GuideWish::kPause:
        return guide::GuidanceRequest::kPause;
      case GuideWish::kResume:
        return guide::GuidanceRequest::kResume;
      case GuideWish::kHowFar:
        return guide::GuidanceRequest::kHowFar;
      case GuideWish::kNext:
        return guide::GuidanceRequest::kNext;
      case GuideWish::kBlocked:
        return guide::GuidanceRequest::kBlocked;
      case GuideWish::kEnd:
        break;
    }
    return guide::GuidanceRequest::kEnd;
  };
  return guidance_->request(request(), at(now_t_ms));
}

guide::Plan LedWalk::plan_from(const Situation& situation) const {
  guide::HomeMap map = map_on(today_, *home_, doorways_);
  map.floor = guidance_->floor().grid();
  return guide::plan_way(map, standing_of(situation.result), guidance_->goal());
}

guide::Prompt LedWalk::repeat(double now_t_ms) {
  return guidance_->request(guide::GuidanceRequest::kRepeat, at(now_t_ms));
}

std::vector<std::optional<guide::ChoicePlace>> places_of(std::span<const guide::Understood> choices,
                                                         const service::Ask& in_words,
                                                         const HomeView& home,
                                                         const guide::UserLocation& location,
                                                         const service::SpeakingSettings& settings,
                                                         const std::optional<CalendarTime>& today) {
  const guide::Pose* const pose = location.sure_pose();
  if (pose == nullptr) return {};
  const std::vector<rooms::Doorway> doorways = doorways_of(home);
  const guide::HomeMap map = map_on(today, home, doorways);
  const auto place_of = [&](const guide::Understood& choice) -> std::optional<guide::ChoicePlace> {
    const auto ask = ask_of(choice, in_words);
    if (!ask) return std::nullopt;
    const auto goal = nearest(goals_of(*ask, home, location, settings, today), map, location);
    if (!goal || !goal->outline) return std::nullopt;
    const Eigen::Vector2d place_plan = goal->outline->middle_plan;
    if (!map.are_on_one_storey(pose->position_plan, place_plan)) return std::nullopt;
    const guide::Plan plan = guide::plan_way(map, location, *goal);
    if (plan.status != guide::PlanStatus::kComplete) return std::nullopt;
    return guide::ChoicePlace{pose->ahead_left_of(place_plan), guide::length_m(plan.route)};
  };
  std::vector<std::optional<guide::ChoicePlace>> places;
  for (const guide::Understood& choice : choices) places.push_back(place_of(choice));
  return places;
}

}  // namespace roomwise::live
