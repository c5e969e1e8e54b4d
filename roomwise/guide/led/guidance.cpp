#include "roomwise/guide/led/guidance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "roomwise/guide/led/led_phrases.h"
#include "roomwise/guide/places/surfaces.h"
#include "roomwise/guide/way/way_phrases.h"

namespace roomwise::guide {
namespace {

using Eigen::Vector2d;

constexpr double kSmallStep_m = 0.45;  // a whole one would lead past it
constexpr int kMaxTries = 4;
constexpr double kPrecise_rad = 10 * kDegree_rad;  // where it was barred: a door's frame, mostly
constexpr double kAhead_rad = 25 * kDegree_rad;    // what they face
constexpr double kStandsAfter_s = 1.5;

}  // namespace

std::string_view to_string(Course course) {
  constexpr std::array<std::string_view, 9> kNames{
      "on_way", "off_way", "lost", "by_rooms", "paused", "waiting", "arrived", "nearest", "ended"};
  return kNames.at(static_cast<std::size_t>(course));
}

Course Guidance::course() const {
  switch (state_) {
    case State::kLost:
      return Course::kLost;
    case State::kByRooms:
      return Course::kByRooms;
    case State::kPaused:
      return Course::kPaused;
    case State::kArrived:
      return Course::kArrived;
    case State::kNearest:
      return Course::kNearest;
    case State::kEnded:
      return Course::kEnded;
    case State::kStopped:
      if (barred_.waits_since_ns) return Course::kWaits;
      break;
    default:
      break;
  }
  return line_.is_off ? Course::kOffWay : Course::kOnWay;
}

std::optional<double> Guidance::left_m() const {
  const Pose* const pose = track_.newest();
  const bool is_led = !is_over() && state_ != State::kLost && state_ != State::kByRooms;
  if (!is_led || pose == nullptr || !way_.has_legs()) return std::nullopt;
  return way_.left_m(*pose);
}

std::optional<Vector2d> Guidance::next_place() const {
  return way_.has_legs() ? std::optional(way_.next_place()) : std::nullopt;
}

std::optional<GoalBearing> Guidance::goal_bearing() const {
  const bool acts = state_ == State::kWalking || state_ == State::kTurning;
  return acts && walker_.pose ? way_.goal_bearing(*walker_.pose, floor_) : std::nullopt;
}

bool Guidance::judges_obstacles(TimestampNs now_ns) const {
  if (state_ == State::kStairs) return true;
  const bool is_told_to_turn =
      state_ == State::kLost || (state_ == State::kTurning && !track_.is_walking());
  if (is_told_to_turn && now_ns < said_.turns_until_ns) return true;
  const bool leads =
      !is_over() && state_ != State::kPaused && state_ != State::kByRooms && state_ != State::kLost;
  // What fills the picture takes the place away, too: then whoever sees it must tell at once.
  if (!leads || !walker_.pose) return false;
  return state_ == State::kWalking || track_.is_standing();
}

bool Guidance::walks_past_end(const Pose& pose) const {
  return !track_.is_standing() && way_.left_on_leg_m(pose) - track_.walked_since_m() < -kLegEnd_m;
}

// ---- saying ----

Prompt Guidance::say(const Phrase& phrase, Confidence confidence, double valid_s) {
  Prompt prompt = make_prompt(wording_, "guide", phrase.message_id, phrase.values, confidence,
                              after(now_ns(), valid_s),
                              fmt::format("guidance, {:.1f} m planned", way_.planned_m()));
  if (confidence == Confidence::kSure) prompt.sound = Sound::kNone;
  said_.until_ns = after(now_ns(), speaking_s(prompt.text));
  said_.at_walked_m = track_.walked_m();
  return prompt;
}

// What is ahead of who turns on the spot is in nobody's way for a while.
Prompt Guidance::say_to_turn(const Phrase& phrase, Confidence confidence, double valid_s) {
  Prompt prompt = say(phrase, confidence, valid_s);
  said_.turns_until_ns = after(said_.until_ns, way_.options().remind_s);
  return prompt;
}

std::string Guidance::left_on_leg(const Pose& pose, double spoken_s) const {
  return wording_.distance_to_walk(track_.left_when_heard_m(way_.to_end_m(pose), spoken_s));
}

std::optional<Phrase> Guidance::what_comes_next(const Pose& pose, double spoken_s) const {
  if (!way_.has_legs()) return std::nullopt;
  return next_phrase(way_, left_on_leg(pose, spoken_s), wording_.phrases());
}

Prompt Guidance::stop(const Phrase& phrase) {
  state_ = State::kStopped;
  Prompt prompt = say(phrase);
  prompt.sound = Sound::kAlert;
  return prompt;
}

Prompt Guidance::turn(const Pose& pose, const Phrase& phrase) {
  state_ = State::kTurning;
  turn_from_rad_ = pose.heading_rad;
  return say_to_turn(phrase);
}

// ---- what happens ----

void Guidance::see(const Walker& walker) {
  if (walker.pose && walker.pose->sigma_m <= UserLocation::kMaxSigma_m) {
    track_.add(*walker.pose, walker.pose_ns);
  }
  track_.keep_pace(walker.now_ns);
  floor_.forget_old(walker.now_ns);
  walker_ = walker;
  // Where a place is not believed, nothing is that was seen from there.
  const bool is_believed = walker.pose && track_.age_s(walker.pose_ns) == 0;
  walker_.pose = is_believed ? std::optional(*track_.newest()) : std::nullopt;
  if (!is_believed) walker_.obstacles.clear();
  const Pose* const pose = track_.pose(now_ns());
  if (!walker_.room && pose != nullptr) {
    walker_.room = way_.map().room_at(pose->position_plan);
  }
}

std::optional<Prompt> Guidance::update(const Walker& walker) {
  see(walker);
  if (state_ == State::kPaused || state_ == State::kEnded) return std::nullopt;
  if (is_over()) return is_speaking() ? std::nullopt : finish();
  if (unseen_.led_since_ns == 0) unseen_.led_since_ns = now_ns();
  const Pose* const pose = track_.pose(now_ns());
  if (pose != nullptr) {
    // Whether they are there, or what to do instead, is told as soon as they stand.
    if (std::exchange(unseen_.should_be_there, false)) {
      said_.of_end = 0;
      state_ = State::kStopped;
    }
    unseen_.steps_until_ns = 0;
    if (auto warning = hazard(*pose)) return warning;
    if (auto warning = off_the_way(*pose)) return warning;
  }
  if (is_speaking()) return std::nullopt;
  if (state_ == State::kByRooms) {
    return pose != nullptr && finds_way(*pose) ? begin(*pose) : by_rooms();
  }
  if (state_ == State::kLost) return lost();
  if (pose == nullptr) return unseen();
  switch (state_) {
    case State::kBeginning:
      return begin(*pose);
    case State::kTurning:
      return turning(*pose);
    case State::kWalking:
      return walking(*pose);
    case State::kCorner:
      return corner(*pose);
    case State::kStopped:
      return stopped(*pose);
    case State::kStairs:
      return on_stairs(*pose);
    default:
      return std::nullopt;
  }
}

void Guidance::plan_from(const Pose& pose) {
  way_.plan_from({.pose = pose, .room = walker_.room}, floor_);
  planned_ns_ = now_ns();
  said_.what_comes_next = said_.reminder = false;
  line_.off_since_ns.reset();
  line_.is_off = false;
}

// Now and then: one wrong place, or what has gone since, must not take the way away for good.
bool Guidance::finds_way(const Pose& pose) {
  constexpr double kAgain_s = 5;
  if (seconds_between(planned_ns_, now_ns()) < kAgain_s) return false;
  plan_from(pose);
  if (!way_.leads_to_goal()) return false;
  state_ = State::kBeginning;
  said_.of_beginning = 0;
  return true;
}

// What is ahead of the way, how far, and where somebody stands: a prompt each.
std::optional<Prompt> Guidance::begin(const Pose& pose) {
  const int said = said_.of_beginning++;
  if (said == 0) {
    plan_from(pose);
    if (!way_.leads_over_floor()) state_ = goal().room ? State::kByRooms : State::kEnded;
    if (!way_.leads_to_goal()) return say({"route.none"}, Confidence::kUnsure);
    if (has_arrived(pose)) return arrive(pose);
    return say({"guide.begin",
                {{"goal", Nouns{goal().noun}}, {"distance", wording_.distance(way_.left_m(pose))}}},
               goal().is_sure ? Confidence::kSure : Confidence::kProbable);
  }
  if (said == 1 && plan().status == PlanStatus::kPartial) {
    return length_m(plan().route) < kHand_m ? end_of_way() : say({"guide.near"});
  }
  if (said <= 2 && plan().is_narrow) {
    said_.of_beginning = 3;
    return say({"guide.narrow"});
  }
  if (said <= 3) {
    said_.of_beginning = 4;
    if (const auto standing = standing_phrase(way_, pose)) return say(*standing);
  }
  return act(pose);
}

Prompt Guidance::act(const Pose& pose) {
  barred_.waits_since_ns.reset();
  plan_from(pose);
  return act_on_plan(pose);
}

Prompt Guidance::act_on_plan(const Pose& pose) {
  if (!way_.leads_over_floor()) {
    state_ = State::kByRooms;
    unseen_.room.reset();
    return say({"route.none"}, Confidence::kUnsure);
  }
  if (has_arrived(pose)) return arrive_or_stop(pose);
  if (!way_.has_legs() || (way_.is_last_leg() && way_.left_m(pose) < kAtEnd_m)) {
    // Who found the way barred in its door stands before the room, however near its end is now.
    const bool is_before_room = goal().kind == Goal::Kind::kRoom && !way_.is_in_goal_room(pose);
    return way_.leads_to_goal() && !is_before_room ? arrive(pose) : end_of_way();
  }
  const Leg& leg = way_.leg();
  const double length_m = leg.stairs ? leg.length_m : way_.to_end_m(pose);
  const auto side_to_try = std::exchange(barred_.side_to_try, std::nullopt);
  const double turn_rad = way_.bearing_error_rad(pose);
  const double enough_rad = side_to_try ? kPrecise_rad : straight_enough_rad(length_m);
  if (std::abs(turn_rad) > enough_rad) return turn(pose, turn_phrase(turn_rad));
  // As it should be, and barred: there may be more room to one side.
  if (side_to_try) return turn(pose, {*side_to_try > 0 ? "guide.try_left" : "guide.try_right"});
  if (leg.stairs) {
    stairs_ = leg.stairs;
    state_ = State::kStairs;
    return say_stairs();
  }
  state_ = State::kWalking;
  // Nobody is sent into what stands before them already.
  if (auto warning = hazard(pose)) return *std::move(warning);
  if (length_m < kSmallStep_m) return say({"guide.small_step"});
  // Who is told how far the goal is from so near needs no second word of it.
  if (way_.is_last_leg() && length_m <= way_.options().announce_from_m) {
    said_.what_comes_next = true;
  }
  // A door's width is told where it is announced: here, where it is too near for that.
  const bool is_too_near = length_m < way_.options().announce_to_m && !way_.is_last_leg();
  const auto place =
      is_too_near && leg.ends_at_door() ? door_noun(*leg.doorway) : way_.place_at_end();
  return say(walk_phrase(wording_.distance_to_walk(length_m), place, way_.side_at_end()));
}

std::optional<Prompt> Guidance::turning(const Pose& pose) {
  const bool has_turned = std::abs(turn_rad(turn_from_rad_, pose.heading_rad)) > 8 * kDegree_rad;
  // Who has turned and does not wait for what comes next knows neither how far nor past what.
  if (track_.is_walking() && silent_for_s() > kReaction_s) return stop({"guide.stop"});
  // Sooner they may be at the end of the turn before.
  const bool is_done = has_turned && !track_.may_turn() && track_.is_standing();
  if (is_done && silent_for_s() > kReaction_s) {
    // A plan from a hand's breadth beside the last one may lead the other way around something.
    if (!way_.may_keep_leg(pose, floor_)) return act(pose);
    said_.reminder = false;
    return act_on_plan(pose);
  }
  // Waits while one stands; a word that was not heard is said again once.
  if (has_turned || said_.reminder || silent_for_s() <= way_.options().remind_s) {
    return std::nullopt;
  }
  Prompt prompt = act(pose);
  said_.reminder = true;
  return prompt;
}

std::optional<Prompt> Guidance::walking(const Pose& pose) {
  // Who stands may be about to do what they have just heard.
  const bool rests = track_.is_standing() && silent_for_s() > kStandsAfter_s;
  if (has_arrived(pose) && (rests || way_.comes_to_rest(pose))) return arrive(pose);
  if (way_.is_at_leg_end(pose)) {
    if (auto prompt = at_leg_end(pose)) return prompt;
    if (state_ != State::kWalking) return std::nullopt;
  }
  const double walked_m = track_.walked_m() - said_.at_walked_m;
  if (track_.is_standing()) {
    // Who stands short of the end counted differently, and is told what is left.
    const bool has_walked = walked_m > kLegEnd_m;
    const double wait_s = has_walked ? kStandsAfter_s : way_.options().remind_s;
    if (silent_for_s() < wait_s || said_.reminder) return std::nullopt;
    Prompt prompt = act(pose);
    said_.reminder = !has_walked;
    return prompt;
  }
  said_.reminder = false;
  if (auto prompt = keep_on_way(pose)) return prompt;
  if (auto prompt = announce(pose)) return prompt;
  if (silent_for_s() > way_.options().reassure_s || walked_m > way_.options().reassure_m) {
    return say(more_phrase(left_on_leg(pose), way_.place_at_end(), way_.side_at_end()));
  }
  return std::nullopt;
}

std::optional<Prompt> Guidance::at_leg_end(const Pose& pose) {
  // The steps that were told end here: who takes more of them is stopped.
  if (way_.is_last_leg())
    return walks_past_end(pose) ? std::optional(stop({"guide.stop"})) : std::nullopt;
  // Nobody walks into stairs that they have not been told of.
  if (way_.goes_over_stairs_next()) return stop({"guide.stop"});
  if (!way_.goes_straight_on()) {
    state_ = State::kCorner;
    return std::nullopt;
  }
  const bool was_door = way_.leg().ends_at_door();
  const auto into = way_.room_beyond();
  way_.take_next_leg();
  said_.what_comes_next = false;
  if (into) {
    return say({"guide.into", {{"room", room(*into)}, {"distance", left_on_leg(pose)}}});
  }
  if (!was_door) return std::nullopt;
  return say({"guide.through", {{"place", thing("door")}, {"distance", left_on_leg(pose)}}});
}

std::optional<Prompt> Guidance::corner(const Pose& pose) {
  if (has_arrived(pose)) return arrive_or_stop(pose);
  if (way_.is_last_leg()) return act(pose);
  const double next_rad = way_.next_leg().heading_rad();
  const bool has_turned = std::abs(turn_rad(pose.heading_rad, next_rad)) < kAhead_rad;
  if (has_turned && !track_.may_turn()) return act(pose);
  if (walks_past_end(pose)) return stop({"guide.stop"});
  // Who was told of the turn before makes it by themselves; who stands still is told.
  const bool waits = track_.is_standing() && !track_.may_turn();
  return waits && silent_for_s() > kStandsAfter_s ? std::optional(act(pose)) : std::nullopt;
}

std::optional<Prompt> Guidance::keep_on_way(const Pose& pose) {
  // A person keeps a line to about so much: from there on a word helps more than it disturbs.
  constexpr double kMissed_m = 0.35;
  constexpr double kCorrection_s = 3;  // between two of them: the first must be heard and done
  const double error_rad = way_.bearing_error_rad(pose);
  const double off_rad = std::abs(error_rad);
  const bool misses = off_rad > 12 * kDegree_rad && off_rad < 45 * kDegree_rad &&
                      way_.to_end_m(pose) * std::sin(off_rad) > kMissed_m;
  const bool is_settled =
      !line_.corrected_ns || seconds_between(*line_.corrected_ns, now_ns()) > kCorrection_s;
  if (!misses || !is_settled || silent_for_s() < kReaction_s) return std::nullopt;
  line_.corrected_ns = now_ns();
  return say({error_rad > 0 ? "guide.little_left" : "guide.little_right"});
}

std::optional<Prompt> Guidance::announce(const Pose& pose) {
  const GuidanceOptions& options = way_.options();
  const double left_m = way_.to_end_m(pose);
  if (said_.what_comes_next || left_m < options.announce_to_m) return std::nullopt;
  const auto phrase = what_comes_next(pose);
  if (!phrase) return std::nullopt;
  const double spoken_s = speaking_s(wording_.phrases().text(phrase->message_id, phrase->values));
  // Who walks fast hears of it from farther away: so that as much is left when it has been heard.
  const double goes_on_m = left_m - track_.left_when_heard_m(left_m, spoken_s);
  if (left_m > std::max(options.announce_from_m, kSmallStep_m + goes_on_m)) return std::nullopt;
  // A turn that is too near to be acted on is not announced: they know how many steps it is to
  // there, and are told of it then. Who hears of it while walking counts those steps anew.
  const bool may_wait = !way_.is_last_leg() && !way_.goes_over_stairs_next();
  if (may_wait && left_m - goes_on_m < kSmallStep_m) return std::nullopt;
  said_.what_comes_next = true;
  return say(*what_comes_next(pose, spoken_s));
}

// Also while something is spoken: it goes before all but obstacles.
std::optional<Prompt> Guidance::off_the_way(const Pose& pose) {
  const bool walks = state_ == State::kWalking && !track_.is_standing();
  if (!walks || !way_.is_off(pose)) {
    line_.off_since_ns.reset();
    return std::nullopt;
  }
  if (!line_.off_since_ns) line_.off_since_ns = now_ns();
  if (seconds_between(*line_.off_since_ns, now_ns()) < way_.options().off_way_s) {
    return std::nullopt;
  }
  line_.off_since_ns.reset();
  line_.is_off = true;
  Prompt prompt = stop({"guide.off"});
  prompt.priority = Priority::kHazard;
  return prompt;
}

// ---- what is in the way ----

std::optional<Prompt> Guidance::hazard(const Pose& pose) {
  const bool walks = state_ == State::kWalking && way_.has_legs() && floor_.grid() != nullptr;
  if (!walks) return std::nullopt;
  const auto obstacle = hazards_.look(way_, pose, walker_.obstacles, floor_, now_ns());
  if (!obstacle) return std::nullopt;
  const bool is_at_door = !obstacle->is_on_map && way_.leg().ends_at_door() &&
                          std::abs(obstacle->ahead_m() - way_.to_end_m(pose)) < kLegEnd_m;
  // Who was told that a door is closed has opened it, or it was open: what is ahead of them then is
  // its frame or its leaf, beside which they go on.
  const bool is_closed = is_at_door && !floor_.was_barred_at(pose);
  const KnownThing* const thing =
      obstacle->is_on_map ? sure_thing_of(obstacle->seen, obstacle->from, way_.map()) : nullptr;
  Prompt prompt = stop(is_closed ? Phrase{"guide.stop_door"}
                                 : obstacle_phrase("guide.stop_", obstacle->side_by(pose), thing));
  prompt.priority = Priority::kHazard;
  if (is_at_door) {
    floor_.count_try(pose);
    if (!is_closed) barred_.side_to_try = floor_.freer_side(pose);
  } else if (!obstacle->is_on_map) {
    barred_.by_hazard = way_.leads_to_goal();
    floor_.bar_seen(walker_.obstacles, now_ns());
  }
  return prompt;
}

// Has been told to stop: hears what to do as soon as they stand.
std::optional<Prompt> Guidance::stopped(const Pose& pose) {
  const bool is_late = silent_for_s() > 2 * kReaction_s;  // then it is told while they walk
  if (!is_late && (!track_.is_standing() || track_.may_turn())) return std::nullopt;
  if (barred_.waits_since_ns) {
    if (auto prompt = waiting(); prompt || barred_.waits_since_ns) return prompt;
  }
  // Who comes no further after some tries is led another way, past what is seen there, or told what
  // is left; they are not sent again.
  if (floor_.was_barred_at(pose) && floor_.tries() > kMaxTries) {
    floor_.bar_seen(walker_.obstacles, now_ns());
    Prompt other_way = act(pose);
    return way_.leads_to_goal() ? other_way : end_barred();
  }
  const bool was_hazard = std::exchange(barred_.by_hazard, false);
  Prompt prompt = act(pose);
  if (!was_hazard || way_.leads_to_goal()) return prompt;
  // Not around it, and it may go, as people do: the way of before holds again after a while.
  // What does not go is passed to the freer side, if at all.
  floor_.clear();
  plan_from(pose);
  barred_.may_be_somebody = !floor_.was_barred_at(pose);
  if (!barred_.may_be_somebody) barred_.side_to_try = floor_.freer_side(pose);
  floor_.count_try(pose);
  barred_.waits_since_ns = now_ns();
  said_.wait = false;
  state_ = State::kStopped;
  return say({"guide.no_way_around"}, Confidence::kUnsure);
}

// For what is in the way and may go. Who stands there may do so when they are asked: it goes on as
// soon as a picture shows that the way is free, and for a while is not tried before. Only depth of
// what is ahead of who stands and faces it shows that.
std::optional<Prompt> Guidance::waiting() {
  constexpr double kMayGo_s = 20;
  const double waited_s = seconds_between(*barred_.waits_since_ns, now_ns());
  if (waited_s < kSameHazard_s) return std::nullopt;
  const bool sees_way = walker_.pose && walker_.has_depth && track_.is_standing() &&
                        way_.has_legs() &&
                        std::abs(way_.bearing_error_rad(*walker_.pose)) < kAhead_rad;
  const bool is_free = sees_way && !is_newly_barred(way_, *walker_.pose, walker_.obstacles, floor_);
  if (is_free || !barred_.may_be_somebody || waited_s > kMayGo_s) {
    barred_.waits_since_ns.reset();
    return std::nullopt;
  }
  if (said_.wait) return std::nullopt;
  said_.wait = true;
  return say({"guide.wait_or_ask"});
}

// Who says so stands before what a cane found. It is as broad as a body, or, where no way were left
// then, as a hand: no more of it is known.
Prompt Guidance::blocked(const Pose& pose) {
  if (floor_.grid() == nullptr) return act(pose);  // by rooms: there is no way to go around on
  // What is in the way at the end of the way is the goal, or what it stands on; before its room it
  // is the door.
  const bool is_near = way_.leads_to_goal() && way_.is_last_leg() && way_.is_in_goal_room(pose) &&
                       way_.left_m(pose) < 2 * kLegEnd_m;
  // Unless they are farther from it than they could be, and have not tried yet.
  if (is_near && (way_.is_in_reach(pose) || floor_.was_barred_at(pose))) return arrive(pose);
  floor_.count_try(pose);
  const bool may_try = floor_.tries() <= kMaxTries;
  constexpr double kHandsBreadth_m = 0.1;
  const BarredFloor known = floor_;
  for (const double radius_m : {way_.options().body_radius_m, kHandsBreadth_m}) {
    floor_ = known;
    floor_.bar_ahead(pose, radius_m, now_ns());
    Prompt prompt = act(pose);
    if (prompt.priority == Priority::kHazard || (may_try && way_.leads_to_goal())) return prompt;
  }
  // Who comes no further after some tries is told what is left, and is not sent again.
  if (!may_try) return end_barred();
  // Not around it: the map holds again, and they try beside it.
  floor_.clear();
  barred_.side_to_try = floor_.freer_side(pose);
  return act(pose);
}

// ---- stairs ----

Prompt Guidance::say_stairs() {
  Prompt prompt = say(stairs_phrase(*stairs_, wording_.phrases()));
  prompt.sound = Sound::kAlert;
  return prompt;
}

// Nothing is said on the steps. Who is beyond the last one hears it, stands, and is led on from
// there; who turned back and left them is led anew.
std::optional<Prompt> Guidance::on_stairs(const Pose& pose) {
  constexpr double kBehind_m = 0.1;  // both feet on the floor
  constexpr double kLeft_m = 1.5;    // two strides from where one stood before them
  const fusion::Storeys& storeys = *way_.map().storeys;
  const fusion::Staircase& stairs = stairs_->stairs;
  const bool is_up = stairs_->is_up;
  const Vector2d& here = pose.position_plan;
  const bool is_at_goal = storeys.at_plan(here) == (is_up ? stairs.lower + 1 : stairs.lower);
  if (is_at_goal && storeys.beyond_m(stairs, is_up, here) > kBehind_m) {
    stairs_.reset();
    state_ = State::kStopped;
    return say({is_up ? "stairs.upstairs" : "stairs.downstairs"});
  }
  const Vector2d& begin = is_up ? stairs.below_plan : stairs.above_plan;
  // Who rests on the steps needs no reminder of them.
  const bool is_before = !is_at_goal && storeys.stairs_at(here) == nullptr;
  if (is_before && (here - begin).norm() > kLeft_m) {
    stairs_.reset();
    return act(pose);
  }
  const bool waits = track_.is_standing() && silent_for_s() > way_.options().remind_s;
  if (said_.reminder || !is_before || !waits) return std::nullopt;
  said_.reminder = true;
  return say_stairs();
}

// ---- without a place ----

// While somebody walks most pictures that tell of no place are a moment's; a slow turn costs more
// than standing until the next one, and they face anywhere after it.
std::optional<Prompt> Guidance::unseen() {
  constexpr double kOldest_s = 20;  // a turn, and waiting for pictures
  const GuidanceOptions& options = way_.options();
  const double age_s = track_.age_s(now_ns());
  const bool is_new = said_.of_beginning == 0;
  const bool stands = state_ != State::kWalking && track_.is_standing();
  const double max_s = is_new ? 2 * kReaction_s : stands ? options.lost_standing_s : options.lost_s;
  if (std::min(age_s, seconds_between(unseen_.led_since_ns, now_ns())) < max_s) return std::nullopt;
  if (now_ns() < unseen_.steps_until_ns) return std::nullopt;
  if (const Pose* const last = track_.newest(); last != nullptr) {
    // So near to a thing a camera sees one front of it. They faced it when they were told the last
    // step, by which nobody errs by much.
    const bool walks = state_ == State::kWalking && unseen_.steps_until_ns == 0;
    if (walks && way_.is_last_step(*last)) return end_unseen();
    // Where they face a bare wall no picture tells of a place.
    if (state_ == State::kTurning && age_s <= kOldest_s) {
      const auto step_m = way_.unseen_step_m(*last, walker_.obstacle_m, floor_);
      if (step_m) return step_unseen(*step_m);
    }
  }
  become_lost();
  // Who stands has waited already, and nobody turns about on a step.
  unseen_.waits_for_place = !is_new && (!stands || stairs_);
  return say_lost(unseen_.waits_for_place ? "guide.lost_wait"
                  : is_new                ? "route.no_place"
                                          : "guide.lost");
}

Prompt Guidance::step_unseen(double step_m) {
  constexpr double kFeelsTheirWay_m_s = 0.35;
  state_ = State::kWalking;
  Prompt prompt =
      say(step_m < kSmallStep_m ? Phrase{"guide.small_step"}
                                : walk_phrase(wording_.distance_to_walk(step_m), std::nullopt),
          Confidence::kProbable);
  unseen_.steps_until_ns = after(said_.until_ns, kReaction_s + step_m / kFeelsTheirWay_m_s);
  return prompt;
}

// That they should be there, and what to know of it before a hand is at it; the end, unless a
// picture tells meanwhile that they are not.
std::optional<Prompt> Guidance::end_unseen() {
  const Values values{{"goal", Nouns{goal().noun}}};
  if (!unseen_.should_be_there) {
    if (silent_for_s() < 2 * kReaction_s) return std::nullopt;
    unseen_.should_be_there = true;
    return say({"guide.should_be_there", values}, Confidence::kProbable);
  }
  if (auto prompt = say_of_goal(Confidence::kProbable)) return prompt;
  if (silent_for_s() < way_.options().remind_s) return std::nullopt;
  return say_end(State::kArrived, {"guide.there_unseen", values}, Confidence::kUnsure);
}

// "guide.lost_wait" asks who walks to stand, the others for a slow turn.
Prompt Guidance::say_lost(const char* message) {
  Prompt prompt = unseen_.waits_for_place
                      ? say({message}, Confidence::kUnsure, kNoticeValid_s)
                      : say_to_turn({message}, Confidence::kUnsure, kNoticeValid_s);
  if (unseen_.waits_for_place) said_.turns_until_ns = 0;
  prompt.sound = Sound::kLost;
  return prompt;
}

void Guidance::become_lost() {
  state_ = State::kLost;
  unseen_.is_blocked = false;
  unseen_.steps_until_ns = 0;
  unseen_.room.reset();
  said_.reminder = false;
}

Guidance::State Guidance::resumed() const {
  return said_.of_beginning == 0 ? State::kBeginning : stairs_ ? State::kStairs : State::kStopped;
}

std::optional<Prompt> Guidance::lost() {
  if (const Pose* const pose = track_.pose(now_ns()); pose != nullptr) {
    state_ = resumed();
    const bool waited = std::exchange(unseen_.waits_for_place, false);
    const bool is_blocked = std::exchange(unseen_.is_blocked, false);
    if (waited && state_ == State::kBeginning) return std::nullopt;  // the beginning is told next
    if (waited && state_ == State::kStopped) {  // they stand, and what to do says enough
      return is_blocked ? blocked(*pose) : stopped(*pose);
    }
    Prompt prompt = say({"guide.found"});
    prompt.sound = Sound::kBack;
    return prompt;
  }
  const bool is_long = silent_for_s() > way_.options().remind_s;
  if (unseen_.waits_for_place) {
    if (silent_for_s() < way_.options().lost_s) return std::nullopt;
    if (stairs_) return is_long ? std::optional(say_lost("guide.lost_wait")) : std::nullopt;
    unseen_.waits_for_place = unseen_.is_blocked = false;
    return say_lost("route.no_place");
  }
  if (auto prompt = by_rooms()) return prompt;
  if (said_.reminder || !is_long) return std::nullopt;
  said_.reminder = true;
  return say_to_turn({"route.no_place"}, Confidence::kUnsure, kNoticeValid_s);
}

// Once in each room.
std::optional<Prompt> Guidance::by_rooms() {
  const auto& room = walker_.room;
  if (!room || !goal().room || room == unseen_.room) return std::nullopt;
  unseen_.room = room;
  std::vector<std::string> rooms;
  if (*room != *goal().room) {
    rooms = way_between_rooms(*room, *goal().room, way_.map().doorways);
    if (rooms.empty()) return std::nullopt;
  } else if (goal().kind == Goal::Kind::kRoom) {
    state_ = State::kArrived;
  }
  const auto phrase = rooms_phrase(goal(), rooms);
  if (!phrase) return std::nullopt;
  Prompt prompt = say(*phrase, Confidence::kSure, kRoomValid_s);
  if (is_over()) said_.end = prompt.text;
  return prompt;
}

// To who asks: no picture tells where they are. Who was seen a moment ago waits for the next one;
// for others a slow turn finds one.
Prompt Guidance::no_place() {
  if (is_over() || state_ == State::kPaused) {
    unseen_.waits_for_place = false;
    return say_lost("route.no_place");
  }
  if (track_.pose(now_ns()) != nullptr) return say({"route.none"}, Confidence::kUnsure);
  unseen_.waits_for_place = stairs_ || track_.age_s(now_ns()) < way_.options().lost_standing_s;
  become_lost();
  return say_lost(unseen_.waits_for_place ? "guide.lost_wait" : "route.no_place");
}

// ---- the end ----

Prompt Guidance::say_end(State end, const Phrase& phrase, Confidence confidence) {
  state_ = end;
  Prompt prompt = say(phrase, confidence);
  said_.end = prompt.text;
  return prompt;
}

// Who walks on would not be there any more when they have heard it.
Prompt Guidance::arrive_or_stop(const Pose& pose) {
  const bool walks_past = track_.is_walking() && !way_.comes_to_rest(pose);
  return walks_past ? stop({"guide.stop"}) : arrive(pose);
}

Prompt Guidance::arrive(const Pose& pose) {
  Prompt prompt = say_end(State::kArrived, there_phrase(goal(), pose), Confidence::kSure);
  prompt.sound = Sound::kBack;
  return prompt;
}

// As near as the way is known: the rest by direction, or by rooms.
Prompt Guidance::end_of_way() {
  return say_end(State::kNearest, {"guide.near_end"}, Confidence::kUnsure);
}

Prompt Guidance::end_barred() {
  barred_.ends_way = true;
  return end_of_way();
}

std::optional<Prompt> Guidance::say_of_goal(Confidence confidence) {
  const std::vector<Phrase> phrases = at_goal_phrases(goal(), wording_);
  const auto said = static_cast<std::size_t>(said_.of_end);
  if (said >= phrases.size()) return std::nullopt;
  ++said_.of_end;
  return say(phrases[said], confidence);
}

// What is said after the first word of the end: of the goal, or what is left and what stands
// between.
std::optional<Prompt> Guidance::finish() {
  if (state_ == State::kArrived) return say_of_goal(Confidence::kSure);
  const int said = said_.of_end++ - (barred_.ends_way ? 1 : 0);
  if (said < 0) return say({"guide.barred"}, Confidence::kUnsure);
  // What the map knows is not what stands between where something else does.
  if (said > (barred_.ends_way ? 0 : 1)) return std::nullopt;
  const Pose* const pose = track_.pose(now_ns());
  const bool knows_both = pose != nullptr && goal().outline;
  if (said == 0 && !plan().rooms.empty()) {
    const auto phrase = rooms_phrase(goal(), plan().rooms);
    return phrase ? std::optional(say(*phrase)) : std::nullopt;
  }
  if (!knows_both) return std::nullopt;
  const Vector2d& here = pose->position_plan;
  if (!way_.map().are_on_one_storey(here, goal().outline->middle_plan)) {
    const bool tells_room = said == 0 && goal().room && goal().kind != Goal::Kind::kRoom;
    if (!tells_room) return std::nullopt;
    return say({"where.room", {{"thing", Nouns{goal().noun}}, {"room", room(*goal().room)}}});
  }
  if (said == 1) {
    const KnownThing* const between = thing_between(here, goal(), way_.map());
    if (between == nullptr) return std::nullopt;
    return say({"guide.between", {{"thing", thing(between->name)}}});
  }
  const Bearing bearing = bearing_of(goal().outline->nearest_to(here), *pose);
  const bool is_sure = bearing.is_sure && goal().is_sure;
  return say({is_sure ? "where.direction" : "where.direction_probable",
              {{"thing", Nouns{goal().noun}},
               {"hour", fmt::format("{}", bearing.hour)},
               {"distance", wording_.distance(bearing.distance_m)}}},
             is_sure ? Confidence::kSure : Confidence::kProbable);
}

// To who asks after the end of the way. Who only did not hear it need not be seen again.
Prompt Guidance::say_end_again(const Pose* pose, GuidanceRequest request) {
  if (pose == nullptr && request == GuidanceRequest::kRepeat && !said_.end.empty()) {
    return say({"repeat.earlier", {{"text", said_.end}}});
  }
  // Elsewhere something else may be in the way, or nothing.
  barred_.ends_way = barred_.ends_way && pose != nullptr && floor_.was_barred_at(*pose);
  said_.of_end = goal().kind == Goal::Kind::kRoom && !barred_.ends_way ? 1 : 0;
  return pose == nullptr ? no_place() : state_ == State::kArrived ? arrive(*pose) : end_of_way();
}

// ---- requests ----

Prompt Guidance::request(GuidanceRequest request, TimestampNs now_ns) {
  walker_.now_ns = now_ns;
  if (state_ == State::kEnded) return say({"guide.not_running"});
  switch (request) {
    case GuidanceRequest::kEnd:
      state_ = State::kEnded;
      return say({"guide.ended"}, Confidence::kSure, kNoticeValid_s);
    case GuidanceRequest::kPause:
      if (!is_over()) state_ = State::kPaused;
      return say({is_over() ? "guide.not_running" : "guide.paused"}, Confidence::kSure,
                 kNoticeValid_s);
    case GuidanceRequest::kResume:
      if (state_ == State::kPaused) state_ = resumed();
      barred_.waits_since_ns.reset();
      return say({"guide.resumed"}, Confidence::kSure, kNoticeValid_s);
    default:
      return answer(request);
  }
}

std::optional<Prompt> Guidance::stop_who_walks(TimestampNs now_ns) {
  walker_.now_ns = now_ns;
  const bool walks = state_ == State::kWalking && track_.is_walking();
  return walks ? std::optional(stop({"guide.stop"})) : std::nullopt;
}

Prompt Guidance::end_without_goal(TimestampNs now_ns) {
  walker_.now_ns = now_ns;
  Prompt prompt = stop({"guide.ended_unknown", {{"goal", Nouns{goal().noun}}}});
  state_ = State::kEnded;
  return prompt;
}

// Of the way.
Prompt Guidance::answer(GuidanceRequest request) {
  const Pose* const pose = track_.pose(now_ns());
  if (is_over()) return say_end_again(pose, request);
  const bool is_how_far = request == GuidanceRequest::kHowFar;
  if (state_ == State::kPaused && !is_how_far) return say({"guide.paused"});
  if (pose == nullptr || state_ == State::kByRooms) {
    Prompt prompt = no_place();
    if (request == GuidanceRequest::kBlocked) {
      unseen_.is_blocked = state_ == State::kLost && unseen_.waits_for_place;
    }
    return prompt;
  }
  if (is_how_far) {
    if (!way_.has_legs()) plan_from(*pose);
    if (!way_.has_legs()) return say({"route.none"}, Confidence::kUnsure);
    return say(
        {"guide.far",
         {{"goal", Nouns{goal().noun}}, {"distance", wording_.distance(way_.left_m(*pose))}}});
  }
  if (state_ == State::kStairs) return say_stairs();  // in the way are the steps themselves
  if (course() == Course::kWaits && request != GuidanceRequest::kBlocked) {
    if (!barred_.may_be_somebody) return say({"guide.no_way_around"}, Confidence::kUnsure);
    said_.wait = true;
    return say({"guide.wait_or_ask"});
  }
  // To who stands, turns or is past its end, what comes after the leg is not what to do next.
  const bool follows_leg =
      state_ == State::kWalking && way_.has_legs() && !way_.is_at_leg_end(*pose);
  if (request == GuidanceRequest::kNext && follows_leg) {
    const auto phrase = what_comes_next(*pose);
    return phrase ? say(*phrase) : act(*pose);
  }
  return request == GuidanceRequest::kBlocked ? blocked(*pose) : act(*pose);
}

}  // namespace roomwise::guide
