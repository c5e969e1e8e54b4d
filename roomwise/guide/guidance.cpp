#include "roomwise/guide/guidance.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "roomwise/guide/floor_search.h"
#include "roomwise/guide/in_room.h"
#include "roomwise/guide/surfaces.h"

namespace roomwise::guide {
namespace {

using Eigen::Vector2d;

constexpr double kSameHazard_s = 4;     // what is in the way is told again after this
constexpr double kLegEnd_m = 0.35;      // half a step before a leg's end one is at it
constexpr double kAtEnd_m = 0.22;       // a foot's length from the way's end one is there
constexpr double kSmallStep_m = 0.45;   // a whole one would lead past it
constexpr double kBeyondDoor_m = 0.45;  // both feet are, and not in its frame
constexpr double kSlack_m = 0.05;       // of positions: whoever is told so is to be there
constexpr double kHand_m = 0.7;         // beside the way a hand finds what stands there

// What people hear, they do within a second and a half (see docs/guide.md).
constexpr double kReaction_s = 1.3;  // and the next picture tells of it
constexpr double kMaxGap_s = 1.5;    // older places tell nothing of where somebody is now
constexpr int kMaxTries = 4;
constexpr double kPrecise_rad = 10 * kDegree_rad;  // where it was barred: a door's frame, mostly
constexpr double kWalks_m_s = 0.3;                 // nobody turns on the spot so fast
constexpr double kStandsAfter_s = 1.5;
// A person keeps a line to about so much: from there on a word helps more than it disturbs.
constexpr double kMissed_m = 0.35;
constexpr double kCorrection_s = 3;  // between two of them: the first must be heard and done

// Straight enough to begin to walk a leg: at its end it would be missed by a step's half; but not
// finer than people turn.
double straight_enough_rad(double length_m) {
  return std::clamp(std::atan2(0.4, length_m), 15 * kDegree_rad, 25 * kDegree_rad);
}

double heading_to(const Vector2d& from, const Vector2d& to) {
  const Vector2d towards = to - from;
  return std::atan2(towards.y(), towards.x());
}

}  // namespace

std::string_view to_string(Course course) {
  switch (course) {
    case Course::kOnWay:
      return "on_way";
    case Course::kOffWay:
      return "off_way";
    case Course::kLost:
      return "lost";
    case Course::kByRooms:
      return "by_rooms";
    case Course::kPaused:
      return "paused";
    case Course::kWaits:
      return "waiting";
    case Course::kArrived:
      return "arrived";
    case Course::kNearest:
      return "nearest";
    case Course::kEnded:
      break;
  }
  return "ended";
}

Expected<void> GuidanceOptions::validate() const {
  ROOMWISE_CHECK_OK(plan.validate());
  if (!(announce_to_m > 0 && announce_from_m > announce_to_m)) {
    return fail("announce_from_m is {} and announce_to_m {}; expected the first to be larger",
                announce_from_m, announce_to_m);
  }
  for (const auto& [name, value] :
       {std::pair{"reassure_m", reassure_m}, std::pair{"reassure_s", reassure_s},
        std::pair{"off_way_m", off_way_m}, std::pair{"off_way_degrees", off_way_degrees},
        std::pair{"off_way_s", off_way_s}, std::pair{"lost_s", lost_s},
        std::pair{"lost_standing_s", lost_standing_s}, std::pair{"arrived_m", arrived_m},
        std::pair{"body_radius_m", body_radius_m}, std::pair{"remind_s", remind_s}}) {
    if (!(value > 0)) return fail("{} is {}; expected more than 0", name, value);
  }
  return {};
}

Guidance::Guidance(const HomeMap& map, Goal goal, const Wording& wording,
                   const GuidanceOptions& options)
    : map_(map),
      goal_(std::move(goal)),
      wording_(wording),
      options_(options),
      doorways_(map.doorways.begin(), map.doorways.end()) {}

// ---- saying ----

Prompt Guidance::say(const Phrase& phrase, TimestampNs now_ns, Confidence confidence,
                     double valid_s) {
  Prompt prompt = make_prompt(
      wording_, "guide", phrase.message, phrase.values, confidence, guide::after(now_ns, valid_s),
      fmt::format("guidance, {:.1f} m planned", length_m(plan_.route, known_stairs())));
  if (confidence == Confidence::kSure) prompt.sound = Sound::kNone;
  silent_from_ns_ = guide::after(now_ns, speaking_s(prompt.text));
  said_at_walked_m_ = track_.walked_m();
  return prompt;
}

Prompt Guidance::say_to_turn(const Phrase& phrase, TimestampNs now_ns, Confidence confidence,
                             double valid_s) {
  Prompt prompt = say(phrase, now_ns, confidence, valid_s);
  turns_until_ns_ = guide::after(silent_from_ns_, options_.remind_s);
  return prompt;
}

// Of what is to be walked, rather less than more: who stops short is told the rest, who goes too
// far has to come back. Going too far costs twice, so a third of the roundings may.
std::string Guidance::distance(double distance_m) const {
  constexpr double kLess = 0.5 - 1.0 / 3;
  constexpr double kHalfMetre_m = 0.5;
  const bool in_steps = wording_.style.distances == DistanceUnit::kSteps;
  return wording_.distance(distance_m - kLess * (in_steps ? wording_.style.step_m : kHalfMetre_m));
}

// What will be left when it has been heard: who walks goes on meanwhile.
double Guidance::left_when_heard_m(double distance_m, double spoken_s) const {
  const double speed_m_s = track_.is_standing() ? 0 : pace_m_s_;
  return distance_m - walked_since_pose_m() - speed_m_s * (spoken_s + kReaction_s);
}

// A place is as old as its picture: who walks has gone on since.
double Guidance::walked_since_pose_m() const {
  return track_.is_standing() ? 0 : pace_m_s_ * pose_age_s_;
}

// Who has just begun to walk seems slow for a second, and is not: how fast they were before tells
// more. It fades, so that one wrong place is forgotten.
void Guidance::keep_pace() {
  constexpr double kFades = 0.99;  // with each look, some a second
  const double speed_m_s = track_.speed_m_s().value_or(0);
  if (speed_m_s > kWalks_m_s) pace_m_s_ = std::max(kFades * pace_m_s_, speed_m_s);
}

Prompt Guidance::stop(const Phrase& phrase, TimestampNs now_ns) {
  state_ = State::kStopped;
  Prompt prompt = say(phrase, now_ns);
  prompt.sound = Sound::kAlert;
  return prompt;
}

// ---- where on the way ----

void Guidance::plan_from(const Pose& pose) {
  HomeMap map = map_;
  if (map.floor != nullptr) map.floor = &floor();
  plan_ = plan_way(map, {.pose = pose, .room = room_}, goal_, options_.plan);
  legs_ = legs_of(plan_.route, doorways_, known_stairs());
  if (plan_.reach == Reach::kWhole) reach_out();
  leg_ = 0;
  // What is left of a leg that ends here is done.
  while (leg_ + 1 < legs_.size() && !legs_[leg_].stairs &&
         (left_on_leg_m(pose) < kLegEnd_m || may_skip_leg(pose))) {
    ++leg_;
  }
  step_clear(pose);
  announced_ = false;
  reminded_ = false;
  off_since_ns_.reset();
  is_off_way_ = false;
}

// Up to a thing one walks until a hand or a cane is at it: the last leg goes on to where the body
// would touch it; to a door's frame, until one stands in it.
void Guidance::reach_out() {
  if (goal_.kind == Goal::Kind::kRoom) return;
  const double body_m = goal_.kind == Goal::Kind::kDoor ? 0 : options_.body_radius_m;
  const Vector2d from = legs_.empty() ? plan_.route.back() : legs_.back().to;
  const Vector2d towards = plan_.touch_gravity - from;
  double further_m = std::min(towards.norm() - body_m, kHand_m / 2);
  const auto end = [&] { return Vector2d(from + further_m * towards.normalized()); };
  // As far as the body fits; the rest is for a hand.
  const auto fits = [&] { return map_.floor->fits(end(), options_.plan.narrow_radius_m); };
  while (further_m > 0 && !fits()) further_m -= map_.floor->cell_m();
  if (further_m <= 0) return;
  if (legs_.empty()) {
    if (further_m > kAtEnd_m) legs_.push_back({from, end(), further_m});
    return;
  }
  legs_.back().length_m += further_m;
  legs_.back().to = end();
}

// How much must be free to their sides: as ways lead, or as they stand already.
double Guidance::narrow_m_at(const Vector2d& here) const {
  return std::clamp(clearance_m(floor(), here) - kSlack_m, 0.0, options_.plan.narrow_radius_m);
}

// A leg leaves out small corners, and somebody may stand beside it, nearer to things than ways
// lead: who then went straight to its end would touch them. First a step to where the way is clear.
void Guidance::step_clear(const Pose& pose) {
  if (legs_.empty() || legs_[leg_].stairs) return;
  const Vector2d& here = pose.position_gravity;
  const double narrow_m = narrow_m_at(here);
  const FloorSearch search(floor(), narrow_m, narrow_m);
  if (search.is_clear(here, legs_[leg_].to, narrow_m)) return;
  std::optional<Vector2d> farthest;
  for (std::size_t i = 0; i + 1 < plan_.route.size(); ++i) {
    const Vector2d along = plan_.route[i + 1] - plan_.route[i];
    const int parts = std::max(1, static_cast<int>(std::ceil(along.norm() / floor().cell_m())));
    for (int part = 0; part <= parts; ++part) {
      const Vector2d place = plan_.route[i] + along * part / parts;
      if ((place - here).norm() < kAtEnd_m || !search.is_clear(here, place, narrow_m)) continue;
      farthest = place;
    }
    if (plan_.route[i + 1] == legs_[leg_].to) break;
  }
  if (!farthest) return;
  Leg& next = legs_[leg_];
  next.from = *farthest;
  next.length_m = (next.to - next.from).norm();
  legs_.insert(legs_.begin() + static_cast<std::ptrdiff_t>(leg_),
               Leg{here, *farthest, (*farthest - here).norm()});
}

// A leg of less than a step, which only leads to where one may go at once.
bool Guidance::may_skip_leg(const Pose& pose) const {
  const Vector2d& here = pose.position_gravity;
  if ((legs_[leg_].to - here).norm() > kHand_m || legs_[leg_].ends_at_door()) return false;
  if (is_next_leg_stairs()) return false;  // one begins them where they begin
  const double narrow_m = options_.plan.narrow_radius_m;
  return FloorSearch(floor(), narrow_m, narrow_m).is_clear(here, legs_[leg_ + 1].to, narrow_m);
}

double Guidance::left_on_leg_m(const Pose& pose) const {
  const Leg& leg = legs_[leg_];
  if (leg.stairs) return leg.length_m;
  const Vector2d along = Vector2d(std::cos(leg.heading_rad()), std::sin(leg.heading_rad()));
  return (leg.to - pose.position_gravity).dot(along);
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
      if (waits_since_ns_) return Course::kWaits;
      break;
    default:
      break;
  }
  return is_off_way_ ? Course::kOffWay : Course::kOnWay;
}

std::optional<double> Guidance::left_m() const {
  const Pose* const pose = track_.newest();
  const bool is_led = !is_over() && state_ != State::kLost && state_ != State::kByRooms;
  if (!is_led || pose == nullptr || legs_.empty()) return std::nullopt;
  return left_m(*pose);
}

double Guidance::left_m(const Pose& pose) const {
  double left_m = 0;
  for (std::size_t i = leg_; i < legs_.size(); ++i) {
    left_m += i == leg_ && !legs_[i].stairs ? (legs_[i].to - pose.position_gravity).norm()
                                            : legs_[i].length_m;
  }
  return left_m;
}

// How far somebody would have to turn to face the leg's end, positive to the left.
double Guidance::bearing_error_rad(const Pose& pose) const {
  const Leg& leg = legs_[leg_];
  // So near to its end, its own direction says more than that of a point underfoot.
  const bool is_near = leg.stairs || (leg.to - pose.position_gravity).norm() < 2 * kLegEnd_m;
  return turn_rad(pose.heading_rad,
                  is_near ? leg.heading_rad() : heading_to(pose.position_gravity, leg.to));
}

bool Guidance::goes_straight_on() const {
  return !is_last_leg() && !is_next_leg_stairs() &&
         std::abs(turn_rad(legs_[leg_].heading_rad(), legs_[leg_ + 1].heading_rad())) < kNoTurn_rad;
}

// Of an opening that ends a leg.
std::optional<std::string> Guidance::room_beyond(const Leg& leg) const {
  if (leg.doorway == nullptr || leg.ends_at_door()) return std::nullopt;
  const Vector2d step =
      kBeyondDoor_m * Vector2d(std::cos(leg.heading_rad()), std::sin(leg.heading_rad()));
  auto room = map_.room_at(leg.to + step);
  const bool is_other = room && room != map_.room_at(leg.to - step);
  return is_other && leg.doorway->joins(*room) ? room : std::nullopt;
}

std::optional<Noun> Guidance::place_at_end(const Leg& leg, bool is_last) const {
  if (is_last && plan_.reach == Reach::kWhole) return goal_.noun;
  if (leg.ends_at_door()) return Noun{Noun::Kind::kThing, "door"};
  if (const auto room = room_beyond(leg)) return Noun{Noun::Kind::kRoom, *room};
  std::optional<Noun> nearest;
  double nearest_m = kHand_m + options_.body_radius_m;
  for (const KnownThing& thing : map_.things) {
    if (!thing.position_gravity || !thing.is_sure(map_.today)) continue;
    const double distance_m = Goal::of(thing, map_.today).outline->distance_m(leg.to);
    if (distance_m >= nearest_m) continue;
    nearest_m = distance_m;
    nearest = Noun{Noun::Kind::kThing, thing.name};
  }
  return nearest;
}

bool Guidance::is_in_goal_room(const Pose& pose) const {
  return map_.layout == nullptr || !goal_.room || goal_.kind == Goal::Kind::kDoor ||
         map_.room_at(pose.position_gravity) == goal_.room;
}

// By two pictures: one may be wrong.
bool Guidance::has_arrived(const Pose& pose) {
  if (!is_at_goal(pose)) {
    at_goal_by_.reset();
    return false;
  }
  if (!at_goal_by_) at_goal_by_ = pose.position_gravity;
  return *at_goal_by_ != pose.position_gravity || track_.is_standing();
}

// Without being told: at what stands before them, or anywhere in a room.
bool Guidance::comes_to_rest(const Pose& pose) const {
  if (goal_.kind == Goal::Kind::kRoom) return true;
  const Vector2d touch = goal_.outline->nearest_to(pose.position_gravity);
  return is_solid() && with_side("", touch, pose) == "_ahead";
}

bool Guidance::is_at_goal(const Pose& pose) const {
  if (plan_.reach != Reach::kWhole || !is_in_goal_room(pose)) return false;
  const Vector2d& end = legs_.empty() ? plan_.route.back() : legs_.back().to;
  const double to_end_m = (end - pose.position_gravity).norm();
  // Not from where it is the next room to some.
  const bool may_be_between = map_.layout == nullptr || !goal_.room ||
                              goal_.kind == Goal::Kind::kDoor ||
                              !is_well_inside(map_, *goal_.room, end);
  if (!may_be_between && !is_well_inside(map_, *goal_.room, pose.position_gravity)) return false;
  // Anywhere beyond the door is in the room, but who stands in the door is not.
  if (goal_.kind == Goal::Kind::kRoom) {
    return to_end_m < kAtEnd_m ||
           std::ranges::all_of(map_.doorways, [&](const rooms::Doorway& doorway) {
             return !doorway.joins(*goal_.room) ||
                    (doorway.middle_gravity - pose.position_gravity).norm() > kBeyondDoor_m;
           });
  }
  // What stands on something is reached from where the way ends; a spot is stood on, and so is what
  // lies so low that the floor counts as free.
  const bool is_low = map_.floor->at(goal_.outline->nearest_to(end)) == fusion::FloorCell::kFree;
  const bool is_door = goal_.kind == Goal::Kind::kDoor;
  const double body_m = is_low || is_door ? 0 : options_.body_radius_m;
  return to_end_m < kAtEnd_m ||
         goal_.outline->distance_m(pose.position_gravity) <= options_.arrived_m + body_m - kSlack_m;
}

// ---- what happens ----

std::optional<Prompt> Guidance::update(const Walker& walker) {
  if (walker.pose && walker.pose->sigma_m <= UserLocation::kMaxSigma_m) {
    track_.add(*walker.pose, walker.pose_ns);
  }
  // Where a place is not believed, nothing is that was seen from there.
  is_placed_ = walker.pose && track_.age_s(walker.pose_ns) == 0;
  obstacles_ = is_placed_ ? walker.obstacles : std::vector<Vector2d>();
  obstacle_m_ = walker.obstacle_m;
  keep_pace();
  pose_age_s_ = std::min(track_.age_s(walker.now_ns), kMaxGap_s);
  room_ = walker.room;
  if (!room_ && track_.pose(walker.now_ns) != nullptr) {
    room_ = map_.room_at(track_.pose(walker.now_ns)->position_gravity);
  }
  if (state_ == State::kPaused || state_ == State::kEnded) return std::nullopt;
  if (is_over()) return is_speaking(walker.now_ns) ? std::nullopt : finish(walker.now_ns);
  if (began_ns_ == 0) began_ns_ = walker.now_ns;
  const Pose* const pose = track_.pose(walker.now_ns);
  if (pose != nullptr) {
    if (std::exchange(should_be_there_, false)) said_of_end_ = 0;
    steps_until_ns_ = 0;
    if (auto warning = hazard(*pose, walker.now_ns)) return warning;
    if (auto warning = off_the_way(*pose, walker.now_ns)) return warning;
  }
  if (is_speaking(walker.now_ns)) return std::nullopt;
  if (state_ == State::kByRooms) return by_rooms(walker);
  if (pose == nullptr || state_ == State::kLost) return without_pose(walker);
  switch (state_) {
    case State::kBeginning:
      return begin(walker);
    case State::kTurning:
      return turning(*pose, walker.now_ns);
    case State::kWalking:
      return walking(*pose, walker.now_ns);
    case State::kCorner:
      return corner(*pose, walker.now_ns);
    case State::kStopped:
      return stopped(*pose, walker.now_ns);
    case State::kStairs:
      return on_stairs(*pose, walker.now_ns);
    default:
      return std::nullopt;
  }
}

// What is ahead of the way, how far, and where somebody stands: a prompt each.
std::optional<Prompt> Guidance::begin(const Walker& walker) {
  const TimestampNs now_ns = walker.now_ns;
  const Pose pose = *track_.pose(now_ns);
  const int said = said_of_beginning_++;
  if (said == 0) {
    plan_from(pose);
    if (plan_.reach == Reach::kRooms || plan_.reach == Reach::kUnknown) {
      state_ = goal_.room ? State::kByRooms : State::kEnded;
    }
    if (plan_.reach != Reach::kWhole) return say({"route.none"}, now_ns, Confidence::kUnsure);
    if (has_arrived(pose)) return arrive(pose, now_ns);
    return say({"guide.begin",
                {{"goal", Nouns{goal_.noun}}, {"distance", wording_.distance(left_m(pose))}}},
               now_ns, goal_.is_sure ? Confidence::kSure : Confidence::kProbable);
  }
  if (said == 1 && plan_.reach == Reach::kNear) {
    if (length_m(plan_.route) < kHand_m) return end_of_way(pose, now_ns);
    return say({"guide.near"}, now_ns);
  }
  if (said <= 2 && plan_.is_narrow) {
    said_of_beginning_ = 3;
    return say({"guide.narrow"}, now_ns);
  }
  if (said <= 3) {
    said_of_beginning_ = 4;
    if (auto standing = where_one_stands(pose, now_ns)) return standing;
  }
  return act(pose, now_ns);
}

// By what a hand finds first on the way, or else by the nearest thing.
std::optional<Prompt> Guidance::where_one_stands(const Pose& pose, TimestampNs now_ns) {
  if (legs_.empty() || legs_[leg_].stairs) return std::nullopt;
  std::optional<Noun> place = place_at_end(legs_[leg_], is_last_leg());
  Vector2d at = legs_[leg_].to;
  if (!place || place->kind != Noun::Kind::kThing) {
    place.reset();
    double nearest_m = 2 * kHand_m;
    for (const KnownThing& thing : map_.things) {
      if (!thing.position_gravity || !thing.is_sure(map_.today)) continue;
      const Outline outline = *Goal::of(thing, map_.today).outline;
      const double distance_m = outline.distance_m(pose.position_gravity);
      if (distance_m >= nearest_m) continue;
      nearest_m = distance_m;
      place = Noun{Noun::Kind::kThing, thing.name};
      at = outline.nearest_to(pose.position_gravity);
    }
  }
  if (!place) return std::nullopt;
  return say({with_side("guide.place", at, pose), {{"place", Nouns{*place}}}}, now_ns);
}

Prompt Guidance::act(const Pose& pose, TimestampNs now_ns) {
  plan_from(pose);
  if (plan_.reach != Reach::kWhole && plan_.reach != Reach::kNear) {
    state_ = State::kByRooms;
    told_room_.reset();
    return say({"route.none"}, now_ns, Confidence::kUnsure);
  }
  if (has_arrived(pose)) return arrive_or_stop(pose, now_ns);
  const bool is_at_end = legs_.empty() || (is_last_leg() && left_m(pose) < kAtEnd_m);
  if (is_at_end) {
    // Who found the way barred in its door stands before the room, however near its end is now.
    const bool is_before_room = goal_.kind == Goal::Kind::kRoom && !is_in_goal_room(pose);
    const bool is_there = plan_.reach == Reach::kWhole && !is_before_room;
    return is_there ? arrive(pose, now_ns) : end_of_way(pose, now_ns);
  }
  const double turn = bearing_error_rad(pose);
  const Leg& leg = legs_[leg_];
  const double length_m = leg.stairs ? leg.length_m : (leg.to - pose.position_gravity).norm();
  const double enough_rad = side_to_try_ ? kPrecise_rad : straight_enough_rad(length_m);
  if (side_to_try_ && std::abs(turn) <= enough_rad) {
    // As it should be, and barred: there may be more room to one side.
    const double side = *std::exchange(side_to_try_, std::nullopt);
    state_ = State::kTurning;
    turn_from_rad_ = pose.heading_rad;
    return say_to_turn(turn_phrase(side * kPrecise_rad), now_ns);
  }
  side_to_try_.reset();
  if (std::abs(turn) > enough_rad) {
    state_ = State::kTurning;
    turn_from_rad_ = pose.heading_rad;
    return say_to_turn(turn_phrase(turn), now_ns);
  }
  if (leg.stairs) {
    stairs_ = leg.stairs;
    state_ = State::kStairs;
    return say_stairs(now_ns);
  }
  state_ = State::kWalking;
  if (length_m < kSmallStep_m) return say({"guide.small_step"}, now_ns);
  // Who is told how far the goal is from so near needs no second word of it.
  if (is_last_leg() && length_m <= options_.announce_from_m) announced_ = true;
  auto place = place_at_end(leg, is_last_leg());
  // Its width is told where it is announced: here, where it is too near for that.
  if (length_m < options_.announce_to_m && !is_last_leg() && leg.ends_at_door()) {
    place = door_noun(*leg.doorway);
  }
  return say(walk_phrase(distance(length_m), place), now_ns);
}

std::optional<Prompt> Guidance::turning(const Pose& pose, TimestampNs now_ns) {
  const double quiet_s = silent_for_s(now_ns);
  const bool has_turned = std::abs(turn_rad(turn_from_rad_, pose.heading_rad)) > 8 * kDegree_rad;
  if (track_.speed_m_s().value_or(0) > kWalks_m_s && !has_turned && quiet_s > kReaction_s) {
    return stop({"guide.stop"}, now_ns);  // walks instead
  }
  if (has_turned && !track_.may_turn() && track_.is_standing() && quiet_s > 0.5)
    return act(pose, now_ns);
  // Waits while one stands; a word that was not heard is said again once.
  if (!has_turned && !reminded_ && quiet_s > options_.remind_s) {
    Prompt prompt = act(pose, now_ns);
    reminded_ = true;
    return prompt;
  }
  return std::nullopt;
}

std::optional<Prompt> Guidance::walking(const Pose& pose, TimestampNs now_ns) {
  // Who stands may be about to do what they have just heard.
  const bool rests = track_.is_standing() && silent_for_s(now_ns) > kStandsAfter_s;
  if (has_arrived(pose) && (rests || comes_to_rest(pose))) {
    return arrive(pose, now_ns);
  }
  if (left_on_leg_m(pose) < kLegEnd_m) {
    if (auto prompt = at_leg_end(pose, now_ns)) return prompt;
    if (state_ != State::kWalking) return std::nullopt;
  }
  const double quiet_s = silent_for_s(now_ns);
  if (track_.is_standing()) {
    // Who stands short of the end counted differently, and is told what is left.
    const bool has_walked = track_.walked_m() - said_at_walked_m_ > kLegEnd_m;
    const double wait_s = has_walked ? kStandsAfter_s : options_.remind_s;
    if (quiet_s < wait_s || reminded_) return std::nullopt;
    Prompt prompt = act(pose, now_ns);
    reminded_ = !has_walked;
    return prompt;
  }
  reminded_ = false;
  if (auto prompt = keep_on_way(pose, now_ns)) return prompt;
  if (auto prompt = announce(pose, now_ns)) return prompt;
  const double walked_m = track_.walked_m() - said_at_walked_m_;
  if (quiet_s > options_.reassure_s || walked_m > options_.reassure_m) {
    const Leg& leg = legs_[leg_];
    return say(more_phrase(distance(left_when_heard_m((leg.to - pose.position_gravity).norm())),
                           place_at_end(leg, is_last_leg())),
               now_ns);
  }
  return std::nullopt;
}

std::optional<Prompt> Guidance::at_leg_end(const Pose& pose, TimestampNs now_ns) {
  // The steps that were told end here: who takes more of them is stopped.
  if (is_last_leg()) {
    const bool is_past = left_on_leg_m(pose) - walked_since_pose_m() < -kLegEnd_m;
    if (is_past && !track_.is_standing()) return stop({"guide.stop"}, now_ns);
    return std::nullopt;
  }
  // Nobody walks into stairs that they have not been told of.
  if (is_next_leg_stairs()) return stop({"guide.stop"}, now_ns);
  if (goes_straight_on()) {
    const Leg& done = legs_[leg_++];
    announced_ = false;
    const auto into = room_beyond(done);
    if (!done.ends_at_door() && !into) return std::nullopt;
    const std::string left =
        distance(left_when_heard_m((legs_[leg_].to - pose.position_gravity).norm()));
    if (into) return say({"guide.into", {{"room", room(*into)}, {"distance", left}}}, now_ns);
    return say({"guide.through", {{"place", thing("door")}, {"distance", left}}}, now_ns);
  }
  state_ = State::kCorner;
  return std::nullopt;
}

std::optional<Prompt> Guidance::corner(const Pose& pose, TimestampNs now_ns) {
  if (has_arrived(pose)) return arrive_or_stop(pose, now_ns);
  if (is_last_leg()) return act(pose, now_ns);
  const double next = legs_[leg_ + 1].heading_rad();
  const bool has_turned = std::abs(turn_rad(pose.heading_rad, next)) < 25 * kDegree_rad;
  if (has_turned && !track_.may_turn()) return act(pose, now_ns);
  const bool is_past = left_on_leg_m(pose) - walked_since_pose_m() < -kLegEnd_m;
  if (!track_.is_standing() && is_past) return stop({"guide.stop"}, now_ns);
  // Who was told of the turn before makes it by themselves; who stands still is told.
  const bool waits = track_.is_standing() && !track_.may_turn();
  if (waits && silent_for_s(now_ns) > kStandsAfter_s) return act(pose, now_ns);
  return std::nullopt;
}

// Also while something is spoken: it goes before all but obstacles.
std::optional<Prompt> Guidance::off_the_way(const Pose& pose, TimestampNs now_ns) {
  const bool walks = state_ == State::kWalking && !track_.is_standing();
  const Leg* const leg = walks ? &legs_[leg_] : nullptr;
  const auto is_off = [&] {
    const Vector2d along(std::cos(leg->heading_rad()), std::sin(leg->heading_rad()));
    const Vector2d aside = pose.position_gravity - leg->from;
    const double beside_m = std::abs(along.x() * aside.y() - along.y() * aside.x());
    return beside_m > options_.off_way_m ||
           std::abs(bearing_error_rad(pose)) > options_.off_way_degrees * kDegree_rad;
  };
  if (!walks || !is_off()) {
    off_since_ns_.reset();
    return std::nullopt;
  }
  if (!off_since_ns_) off_since_ns_ = now_ns;
  if (seconds_between(*off_since_ns_, now_ns) < options_.off_way_s) return std::nullopt;
  off_since_ns_.reset();
  is_off_way_ = true;
  Prompt prompt = stop({"guide.off"}, now_ns);
  prompt.priority = Priority::kHazard;
  return prompt;
}

std::optional<Prompt> Guidance::keep_on_way(const Pose& pose, TimestampNs now_ns) {
  const Leg& leg = legs_[leg_];
  const double error = bearing_error_rad(pose);
  const double to_end_m = (leg.to - pose.position_gravity).norm();
  const bool misses = std::abs(error) > 12 * kDegree_rad && std::abs(error) < 45 * kDegree_rad &&
                      to_end_m * std::sin(std::abs(error)) > kMissed_m;
  const bool is_settled = !corrected_ns_ || seconds_between(*corrected_ns_, now_ns) > kCorrection_s;
  if (!misses || !is_settled || silent_for_s(now_ns) < kReaction_s) return std::nullopt;
  corrected_ns_ = now_ns;
  return say({error > 0 ? "guide.little_left" : "guide.little_right"}, now_ns);
}

std::optional<Phrase> Guidance::next_phrase(const Pose& pose, double spoken_s) const {
  if (legs_.empty()) return std::nullopt;
  const Leg& leg = legs_[leg_];
  if (leg.stairs) return stairs_phrase(*leg.stairs, wording_.phrases());
  const std::string left =
      distance(left_when_heard_m((leg.to - pose.position_gravity).norm(), spoken_s));
  if (is_last_leg()) {
    if (plan_.reach == Reach::kNear) return Phrase{"guide.soon_end", {{"distance", left}}};
    return Phrase{"guide.soon_goal", {{"distance", left}, {"goal", Nouns{goal_.noun}}}};
  }
  if (is_next_leg_stairs()) {
    return Phrase{stairs_message("stairs.soon", *legs_[leg_ + 1].stairs), {{"distance", left}}};
  }
  if (goes_straight_on()) {
    if (const auto into = room_beyond(leg)) {
      return Phrase{"guide.soon_into", {{"distance", left}, {"room", room(*into)}}};
    }
    if (!leg.ends_at_door()) return std::nullopt;
    return Phrase{"guide.soon_through",
                  {{"distance", left}, {"place", Nouns{door_noun(*leg.doorway)}}}};
  }
  return soon_turn_phrase(turn_rad(leg.heading_rad(), legs_[leg_ + 1].heading_rad()), left,
                          leg.ends_at_door() ? door_noun(*leg.doorway) : place_at_end(leg, false));
}

std::optional<Prompt> Guidance::announce(const Pose& pose, TimestampNs now_ns) {
  const double left_m = (legs_[leg_].to - pose.position_gravity).norm();
  if (announced_ || left_m < options_.announce_to_m) return std::nullopt;
  const auto phrase = next_phrase(pose);
  if (!phrase) return std::nullopt;
  const double spoken_s = speaking_s(wording_.phrases().text(phrase->message, phrase->values));
  // Who walks fast hears of it from farther away: so that as much is left when it has been heard.
  const double goes_on_m = left_m - left_when_heard_m(left_m, spoken_s);
  if (left_m > std::max(options_.announce_from_m, kSmallStep_m + goes_on_m)) return std::nullopt;
  // A turn that is too near to be acted on is not announced: they know how many steps it is to
  // there, and are told of it then. Who hears of it while walking counts those steps anew.
  const bool may_wait = !is_last_leg() && !is_next_leg_stairs();
  if (may_wait && left_m - goes_on_m < kSmallStep_m) return std::nullopt;
  announced_ = true;
  return say(*next_phrase(pose, spoken_s), now_ns);
}

// Has been told to stop: hears what to do as soon as they stand.
std::optional<Prompt> Guidance::stopped(const Pose& pose, TimestampNs now_ns) {
  const double quiet_s = silent_for_s(now_ns);
  const bool is_late = quiet_s > 2 * kReaction_s;  // then it is told while they walk
  if (!is_late && (!track_.is_standing() || track_.may_turn())) return std::nullopt;
  if (waits_since_ns_ && seconds_between(*waits_since_ns_, now_ns) < kSameHazard_s)
    return std::nullopt;
  waits_since_ns_.reset();
  // Who comes no further after some tries is led another way, past what is seen there, or told what
  // is left; they are not sent again.
  if (was_barred_here(pose) && barred_times_ > kMaxTries) {
    bar_what_is_seen();
    Prompt other_way = act(pose, now_ns);
    return plan_.reach == Reach::kWhole ? other_way : end_of_way(pose, now_ns);
  }
  Prompt prompt = act(pose, now_ns);
  if (!std::exchange(is_barred_by_hazard_, false) || plan_.reach == Reach::kWhole) return prompt;
  // Not around it, and it may go, as people do: the way of before holds again after a while.
  // What does not go is passed to the freer side, if at all.
  barred_floor_.reset();
  if (was_barred_here(pose)) side_to_try_ = freer_side(pose);
  count_barred(pose);
  waits_since_ns_ = now_ns;
  state_ = State::kStopped;
  return say({"guide.no_way_around"}, now_ns, Confidence::kUnsure);
}

// ---- stairs ----

std::optional<Vector2d> Guidance::next_place() const {
  if (legs_.empty()) return std::nullopt;
  const Leg& leg = legs_[leg_];
  if (!leg.stairs) return leg.to;
  return Vector2d(leg.from + Vector2d(std::cos(leg.heading_rad()), std::sin(leg.heading_rad())));
}

// One must be able to walk straight at it until one is there, or for all but half a step: the tone
// leads nobody around what stands beside the way.
std::optional<Aim> Guidance::aim() const {
  const bool acts = state_ == State::kWalking || state_ == State::kTurning;
  const bool is_near_end = acts && plan_.reach == Reach::kWhole && !legs_.empty() &&
                           is_last_leg() && !legs_[leg_].stairs;
  if (!is_near_end || !is_placed_ || !is_solid() || !goal_.is_sure) return std::nullopt;
  const Pose& pose = *track_.newest();
  const Vector2d& here = pose.position_gravity;
  const Bearing bearing = bearing_of(plan_.touch_gravity, pose);
  if (!bearing.is_sure || bearing.distance_m > options_.announce_to_m) return std::nullopt;
  const double end_m = (plan_.touch_gravity - legs_[leg_].to).norm();
  const double further_m =
      bearing.distance_m - std::max(end_m, options_.arrived_m + options_.body_radius_m);
  const double heading_rad = heading_to(here, plan_.touch_gravity);
  const double narrow_m = narrow_m_at(here);
  const Vector2d end = Pose{here, heading_rad}.place_of({further_m, 0});
  const bool is_clear = further_m < kLegEnd_m ||
                        FloorSearch(floor(), narrow_m, narrow_m).is_clear(here, end, narrow_m);
  if (!is_clear) return std::nullopt;
  return Aim{turn_rad(pose.heading_rad, heading_rad), bearing.distance_m};
}

std::span<const fusion::Staircase> Guidance::known_stairs() const {
  return map_.storeys != nullptr ? std::span(map_.storeys->stairs())
                                 : std::span<const fusion::Staircase>();
}

Prompt Guidance::say_stairs(TimestampNs now_ns) {
  Prompt prompt = say(stairs_phrase(*stairs_, wording_.phrases()), now_ns);
  prompt.sound = Sound::kAlert;
  return prompt;
}

// Nothing is said on the steps. Who is beyond the last one hears it, stands, and is led on from
// there; who turned back and left them is led anew.
std::optional<Prompt> Guidance::on_stairs(const Pose& pose, TimestampNs now_ns) {
  const fusion::Storeys& storeys = *map_.storeys;
  const fusion::Staircase& stairs = stairs_->stairs;
  const Vector2d& here = pose.position_gravity;
  const std::size_t goal = stairs_->is_up ? stairs.lower + 1 : stairs.lower;
  constexpr double kBehind_m = 0.1;  // both feet on the floor
  if (storeys.at_plan(here) == goal && storeys.beyond_m(stairs, stairs_->is_up, here) > kBehind_m) {
    const bool is_up = stairs_->is_up;
    stairs_.reset();
    state_ = State::kStopped;
    return say({is_up ? "stairs.upstairs" : "stairs.downstairs"}, now_ns);
  }
  const Vector2d& begin = stairs_->is_up ? stairs.below_plan : stairs.above_plan;
  constexpr double kLeft_m = 1.5;  // two strides from where one stood before them
  const bool has_left = storeys.at_plan(here) != goal && storeys.stairs_at(here) == nullptr &&
                        (here - begin).norm() > kLeft_m;
  if (has_left) {
    stairs_.reset();
    return act(pose, now_ns);
  }
  if (!reminded_ && track_.is_standing() && silent_for_s(now_ns) > options_.remind_s) {
    reminded_ = true;
    return say_stairs(now_ns);
  }
  return std::nullopt;
}

bool Guidance::judges_obstacles(TimestampNs now_ns) const {
  if (state_ == State::kStairs) return true;
  const bool is_told_to_turn = state_ == State::kTurning || state_ == State::kLost;
  if (is_told_to_turn && now_ns < turns_until_ns_) return true;
  const bool leads =
      !is_over() && state_ != State::kPaused && state_ != State::kByRooms && state_ != State::kLost;
  // What fills the picture takes the place away, too: then whoever sees it must tell at once.
  if (!leads || !is_placed_) return false;
  return state_ == State::kWalking || track_.is_standing();
}

// What somebody is led up to is in nobody's way, nor is what it stands on.
bool Guidance::is_goal(const Vector2d& obstacle) const {
  return is_solid() && is_last_leg() && plan_.reach == Reach::kWhole && goal_.outline &&
         goal_.outline->distance_m(obstacle) < kHand_m;
}

// About the line to the leg's end a body's width of what is new. The plan leads past what the map
// knows, as narrow as ways are: that counts for who has left the plan's line so far that theirs
// is not clear on the map, or who does not head along it.
std::optional<Guidance::InTheWay> Guidance::in_the_way(const Pose& pose) const {
  const Leg& leg = legs_[leg_];
  const Vector2d towards = leg.to - pose.position_gravity;
  const double to_end_m = towards.norm();
  const Pose along{pose.position_gravity,
                   to_end_m > kAtEnd_m ? std::atan2(towards.y(), towards.x()) : leg.heading_rad(),
                   pose.sigma_m};
  // Along what they stand at already they may go, not nearer.
  const double here_m = clearance_m(floor(), pose.position_gravity);
  const double narrow_m =
      std::clamp(here_m - kSlack_m, 0.0, options_.plan.narrow_radius_m - kSlack_m);
  const WalkingCorridor line{
      .half_width_m = options_.body_radius_m,
      .length_m = std::min(WalkingCorridor().length_m, to_end_m + kLegEnd_m)};
  const WalkingCorridor narrow{.half_width_m = narrow_m, .length_m = line.length_m};
  const WalkingCorridor facing{.half_width_m = narrow_m};
  const auto nearest = [&](const Pose& from, const WalkingCorridor& corridor,
                           bool on_map) -> std::optional<InTheWay> {
    std::vector<Vector2d> ahead;
    for (const Vector2d& obstacle : obstacles_) {
      const Vector2d seen = from.ahead_left_of(obstacle);
      const bool counts =
          seen.x() > 0 && !is_goal(obstacle) && (on_map || !is_on_map(obstacle, floor()));
      if (counts) ahead.push_back(seen);
    }
    const auto obstacle = nearest_ahead(ahead, corridor);
    if (!obstacle) return std::nullopt;
    return InTheWay{*obstacle, from, on_map};
  };
  if (const auto unknown = nearest(along, line, false)) return unknown;
  const double checked_m = std::min(to_end_m, line.length_m);
  const bool is_clear =
      FloorSearch(floor(), narrow_m, narrow_m)
          .is_clear(pose.position_gravity, along.place_of({checked_m, 0}), narrow_m);
  std::optional<InTheWay> known = is_clear ? std::nullopt : nearest(along, narrow, true);
  if (!known && std::abs(bearing_error_rad(pose)) > straight_enough_rad(to_end_m)) {
    known = nearest(pose, facing, true);
  }
  return known;
}

// Of who faces so.
ObstacleAhead::Side Guidance::InTheWay::side_by(const Pose& pose) const {
  std::vector<Vector2d> ahead_left_m;
  for (const Vector2d& one : seen.all) {
    ahead_left_m.push_back(pose.ahead_left_of(from.place_of(one)));
  }
  return side_of(ahead_left_m);
}

std::optional<Prompt> Guidance::hazard(const Pose& pose, TimestampNs now_ns) {
  if (state_ != State::kWalking || legs_.empty() || map_.floor == nullptr) return std::nullopt;
  if (known_stop_at_ && (*known_stop_at_ - pose.position_gravity).norm() > kHand_m) {
    known_stop_at_.reset();
  }
  if (hazard_ns_ && seconds_between(*hazard_ns_, now_ns) < kSameHazard_s) return std::nullopt;
  const auto obstacle = in_the_way(pose);
  if (!obstacle) return std::nullopt;
  // What the map knows is told once: the way leads past it all the same, and a cane finds it. Who
  // comes back hears of it again.
  if (obstacle->is_on_map && known_stop_at_) return std::nullopt;
  const double left_m = (legs_[leg_].to - pose.position_gravity).norm();
  // The first step is no hazard: before it one is stopped anyway.
  if (is_next_leg_stairs() && obstacle->ahead_m() > left_m - kLegEnd_m) return std::nullopt;
  hazard_ns_ = now_ns;
  const bool is_at_door = !obstacle->is_on_map && legs_[leg_].ends_at_door() &&
                          std::abs(obstacle->ahead_m() - left_m) < kLegEnd_m;
  // Who was told that a door is closed has opened it, or it was open: what is ahead of them then is
  // its frame or its leaf, beside which they go on.
  const bool is_closed = is_at_door && !was_barred_here(pose);
  const KnownThing* const thing =
      obstacle->is_on_map ? sure_thing_of(obstacle->seen, obstacle->from, map_) : nullptr;
  Prompt prompt = stop(is_closed ? Phrase{"guide.stop_door"}
                                 : obstacle_phrase("guide.stop_", obstacle->side_by(pose), thing),
                       now_ns);
  prompt.priority = Priority::kHazard;
  if (is_at_door) {
    count_barred(pose);
    if (!is_closed) side_to_try_ = freer_side(pose);
  } else if (!obstacle->is_on_map) {
    is_barred_by_hazard_ = plan_.reach == Reach::kWhole;
    bar_what_is_seen();
  } else {
    known_stop_at_ = pose.position_gravity;
  }
  return prompt;
}

// ---- without a place ----

// Two steps, or what is left of the leg where that is less.
double Guidance::unseen_step_m() const {
  const double left_m = (legs_[leg_].to - track_.newest()->position_gravity).norm();
  return std::min(left_m, kHand_m + kLegEnd_m);
}

// Where they face a bare wall no picture tells of a place. A turn is what they were told, give or
// take little, and a step on free floor leads on to where they are seen.
bool Guidance::may_step_unseen(TimestampNs now_ns) const {
  constexpr double kOldest_s = 20;  // the turn, and waiting for pictures
  const Pose* const last = track_.newest();
  if (state_ != State::kTurning || last == nullptr || legs_.empty() || map_.floor == nullptr)
    return false;
  if (legs_[leg_].stairs || is_next_leg_stairs() || track_.age_s(now_ns) > kOldest_s) return false;
  const double step_m = unseen_step_m();
  const Vector2d towards = legs_[leg_].to - last->position_gravity;
  const Vector2d end = last->position_gravity + step_m * towards.normalized();
  const auto is_near = [&](const Vector2d& place) { return (place - end).norm() < 2 * kHand_m; };
  const bool is_near_stairs = std::ranges::any_of(known_stairs(), [&](const auto& stairs) {
    return is_near(stairs.below_plan) || is_near(stairs.above_plan);
  });
  // Depth tells otherwise than the map: they do not face where they should.
  const bool is_barred =
      obstacle_m_ && *obstacle_m_ < step_m + options_.body_radius_m && !is_goal(end);
  return !is_near_stairs && !is_barred &&
         FloorSearch(floor(), kSlack_m, kSlack_m).is_clear(last->position_gravity, end, kSlack_m);
}

Prompt Guidance::step_unseen(TimestampNs now_ns) {
  constexpr double kFeelsTheirWay_m_s = 0.35;
  const double step_m = unseen_step_m();
  state_ = State::kWalking;
  Prompt prompt = step_m < kSmallStep_m ? say({"guide.small_step"}, now_ns, Confidence::kProbable)
                                        : say(walk_phrase(distance(step_m), std::nullopt), now_ns,
                                              Confidence::kProbable);
  steps_until_ns_ = guide::after(silent_from_ns_, kReaction_s + step_m / kFeelsTheirWay_m_s);
  return prompt;
}

// So near to a thing a camera sees one front of it. They faced it when they were told the last
// step, by which nobody errs by much.
bool Guidance::may_end_unseen() const {
  const Pose* const last = track_.newest();
  if (state_ != State::kWalking || steps_until_ns_ != 0 || last == nullptr || !is_solid())
    return false;
  if (legs_.empty() || !is_last_leg() || plan_.reach != Reach::kWhole) return false;
  const Leg& leg = legs_.back();
  return (leg.to - last->position_gravity).norm() < kHand_m + kLegEnd_m &&
         comes_to_rest({leg.to, leg.heading_rad()});
}

// That they should be there, and what to know of it before a hand is at it; the end, unless a
// picture tells meanwhile that they are not.
std::optional<Prompt> Guidance::end_unseen(TimestampNs now_ns) {
  const Values goal{{"goal", Nouns{goal_.noun}}};
  if (!should_be_there_) {
    if (silent_for_s(now_ns) < 2 * kReaction_s) return std::nullopt;
    should_be_there_ = true;
    return say({"guide.should_be_there", goal}, now_ns, Confidence::kProbable);
  }
  const std::vector<Phrase> left = at_goal_phrases();
  if (static_cast<std::size_t>(said_of_end_) < left.size()) {
    return say(left[static_cast<std::size_t>(said_of_end_++)], now_ns, Confidence::kProbable);
  }
  if (silent_for_s(now_ns) < options_.remind_s) return std::nullopt;
  state_ = State::kArrived;
  return say({"guide.there_unseen", goal}, now_ns, Confidence::kUnsure);
}

// "guide.lost_wait" asks who walks to stand, the others for a slow turn.
Prompt Guidance::say_lost(const char* message, TimestampNs now_ns) {
  Prompt prompt = waits_for_place_
                      ? say({message}, now_ns, Confidence::kUnsure, kNoticeValid_s)
                      : say_to_turn({message}, now_ns, Confidence::kUnsure, kNoticeValid_s);
  if (waits_for_place_) turns_until_ns_ = 0;
  prompt.sound = Sound::kLost;
  return prompt;
}

void Guidance::become_lost() {
  state_ = State::kLost;
  is_blocked_unseen_ = false;
  steps_until_ns_ = 0;
  told_room_.reset();
  reminded_ = false;
}

// While somebody walks most pictures that tell of no place are a moment's; a slow turn costs more
// than standing until the next one, and they face anywhere after it.
std::optional<Prompt> Guidance::without_pose(const Walker& walker) {
  const TimestampNs now_ns = walker.now_ns;
  if (state_ != State::kLost) {
    const double missing_s = std::min(track_.age_s(now_ns), seconds_between(began_ns_, now_ns));
    const bool is_new = said_of_beginning_ == 0;
    const bool stands = state_ != State::kWalking && track_.is_standing();
    const double max_s = is_new   ? 2 * kReaction_s
                         : stands ? options_.lost_standing_s
                                  : options_.lost_s;
    if (missing_s < max_s) return std::nullopt;
    if (now_ns < steps_until_ns_) return std::nullopt;
    if (may_end_unseen()) return end_unseen(now_ns);
    if (may_step_unseen(now_ns)) return step_unseen(now_ns);
    become_lost();
    // Who stands has waited already, and nobody turns about on a step.
    waits_for_place_ = !is_new && (!stands || stairs_);
    return waits_for_place_ ? say_lost("guide.lost_wait", now_ns)
                            : say_lost(is_new ? "route.no_place" : "guide.lost", now_ns);
  }
  if (const Pose* const pose = track_.pose(now_ns); pose != nullptr) {
    state_ = said_of_beginning_ == 0 ? State::kBeginning
             : stairs_               ? State::kStairs
                                     : State::kStopped;
    const bool waited = std::exchange(waits_for_place_, false);
    const bool is_blocked = std::exchange(is_blocked_unseen_, false);
    if (waited && state_ == State::kBeginning) return std::nullopt;  // the beginning is told next
    if (waited && state_ == State::kStopped) {  // they stand, and what to do says enough
      return is_blocked ? blocked(*pose, now_ns) : stopped(*pose, now_ns);
    }
    Prompt prompt = say({"guide.found"}, now_ns);
    prompt.sound = Sound::kBack;
    return prompt;
  }
  if (waits_for_place_) {
    if (silent_for_s(now_ns) < options_.lost_s) return std::nullopt;
    if (stairs_) {
      if (silent_for_s(now_ns) <= options_.remind_s) return std::nullopt;
      return say_lost("guide.lost_wait", now_ns);
    }
    waits_for_place_ = is_blocked_unseen_ = false;
    return say_lost("route.no_place", now_ns);
  }
  if (auto prompt = by_rooms(walker)) return prompt;
  if (!reminded_ && silent_for_s(now_ns) > options_.remind_s) {
    reminded_ = true;
    return say_to_turn({"route.no_place"}, now_ns, Confidence::kUnsure, kNoticeValid_s);
  }
  return std::nullopt;
}

// Once in each room.
std::optional<Prompt> Guidance::by_rooms(const Walker& walker) {
  if (!room_ || !goal_.room || room_ == told_room_) return std::nullopt;
  told_room_ = room_;
  std::vector<std::string> rooms;
  if (*room_ != *goal_.room) {
    rooms = way_between_rooms(*room_, *goal_.room, map_.doorways);
    if (rooms.empty()) return std::nullopt;
  } else if (goal_.kind == Goal::Kind::kRoom) {
    state_ = State::kArrived;
    said_of_end_ = 1;
  }
  const auto phrase = rooms_phrase(goal_, rooms);
  if (!phrase) return std::nullopt;
  return say(*phrase, walker.now_ns, Confidence::kSure, kRoomValid_s);
}

// ---- the end ----

// Who walks on would not be there any more when they have heard it.
Prompt Guidance::arrive_or_stop(const Pose& pose, TimestampNs now_ns) {
  const bool walks = track_.speed_m_s().value_or(0) > kWalks_m_s;
  if (walks && !comes_to_rest(pose)) return stop({"guide.stop"}, now_ns);
  return arrive(pose, now_ns);
}

Prompt Guidance::arrive(const Pose& pose, TimestampNs now_ns) {
  state_ = State::kArrived;
  Phrase phrase{"guide.there_room", {}};
  if (goal_.kind == Goal::Kind::kRoom) {
    phrase.values = {{"room", room(*goal_.room)}};
    said_of_end_ = 1;
  } else {
    const Vector2d touch = goal_.kind == Goal::Kind::kDoor
                               ? goal_.outline->middle_gravity
                               : goal_.outline->nearest_to(pose.position_gravity);
    phrase = {with_side("guide.there", touch, pose), {{"goal", Nouns{goal_.noun}}}};
  }
  Prompt prompt = say(phrase, now_ns);
  prompt.sound = Sound::kBack;
  return prompt;
}

// As near as the way is known: the rest by direction, or by rooms.
Prompt Guidance::end_of_way(const Pose& /*pose*/, TimestampNs now_ns) {
  state_ = State::kNearest;
  return say({"guide.near_end"}, now_ns, Confidence::kUnsure);
}

// What stands between the end of the way and a goal that cannot be reached: the first thing on the
// straight line, as broad as a hand; null: nothing that is known.
const KnownThing* Guidance::thing_between(const Vector2d& from) const {
  constexpr double kStep_m = 0.05, kHandsBreadth_m = 0.1;
  const Vector2d towards = goal_.outline->nearest_to(from) - from;
  for (double ahead_m = 0; ahead_m < towards.norm(); ahead_m += kStep_m) {
    const Vector2d place = from + ahead_m * towards.normalized();
    for (const KnownThing& thing : map_.things) {
      const bool is_known = thing.position_gravity && thing.is_sure(map_.today);
      if (!is_known || thing.name == goal_.noun.name) continue;
      const Outline outline = *Goal::of(thing, map_.today).outline;
      // The goal itself by another name: the front door as the way out.
      const bool is_goal = outline.middle_gravity == goal_.outline->middle_gravity &&
                           outline.size_m == goal_.outline->size_m;
      if (is_goal) continue;
      if (outline.distance_m(place) < kHandsBreadth_m) return &thing;
    }
  }
  return nullptr;
}

std::vector<Phrase> Guidance::at_goal_phrases() const {
  std::vector<Phrase> phrases;
  if (goal_.kind == Goal::Kind::kThing && !goal_.on.empty()) {
    phrases.push_back({"where.on", {{"thing", thing(goal_.on)}}});
  }
  if (goal_.kind == Goal::Kind::kThing && goal_.height_m) {
    phrases.push_back({height_message(*goal_.height_m)});
  }
  if (!goal_.note.empty()) phrases.push_back({"where.note", {{"note", as_sentence(goal_.note)}}});
  return phrases;
}

// What is said after the first word of the end: what it lies on, how high to reach and what a
// helper noted, or what is left.
std::optional<Prompt> Guidance::finish(TimestampNs now_ns) {
  const auto said = static_cast<std::size_t>(said_of_end_++);
  if (state_ == State::kArrived) {
    const std::vector<Phrase> left = at_goal_phrases();
    return said < left.size() ? std::optional(say(left[said], now_ns)) : std::nullopt;
  }
  if (said > 1) return std::nullopt;
  const Pose* const pose = track_.pose(now_ns);
  if (said == 1) {
    const KnownThing* const thing =
        pose != nullptr && goal_.outline ? thing_between(pose->position_gravity) : nullptr;
    if (thing == nullptr) return std::nullopt;
    return say({"guide.between", {{"thing", guide::thing(thing->name)}}}, now_ns);
  }
  if (!plan_.rooms.empty()) {
    const auto phrase = rooms_phrase(goal_, plan_.rooms);
    return phrase ? std::optional(say(*phrase, now_ns)) : std::nullopt;
  }
  if (pose == nullptr || !goal_.outline) return std::nullopt;
  const Bearing bearing = bearing_of(goal_.outline->nearest_to(pose->position_gravity), *pose);
  return say({"where.direction",
              {{"thing", Nouns{goal_.noun}},
               {"hour", fmt::format("{}", bearing.hour)},
               {"distance", wording_.distance(bearing.distance_m)}}},
             now_ns, bearing.is_sure ? Confidence::kSure : Confidence::kProbable);
}

// ---- requests ----

// As near as the way leads; anywhere in a room.
bool Guidance::is_in_reach(const Pose& pose) const {
  if (!goal_.outline || goal_.kind == Goal::Kind::kRoom) return true;
  const double at_end_m = goal_.outline->distance_m(plan_.route.back());
  return goal_.outline->distance_m(pose.position_gravity) <=
         std::max(options_.arrived_m + options_.body_radius_m, at_end_m);
}

// What a cane found and no camera sees: so broad across the way, from where it touched it.
void Guidance::bar_what_is_ahead(const Pose& pose, double radius_m) {
  constexpr double kTouched_m = 0.35;
  const Vector2d middle = pose.place_of({kTouched_m + radius_m, 0});
  mark_occupied({&middle, 1}, radius_m);
}

void Guidance::bar_what_is_seen() {
  std::vector<Vector2d> seen;
  std::ranges::copy_if(obstacles_, std::back_inserter(seen),
                       [&](const Vector2d& obstacle) { return !is_on_map(obstacle, floor()); });
  constexpr double kSquare_m = 0.1;  // that each of them stands for
  mark_occupied(seen, kSquare_m / 2 + map_.floor->cell_m() / 2);
}

void Guidance::mark_occupied(std::span<const Vector2d> middles, double radius_m) {
  if (map_.floor == nullptr) return;
  const fusion::FloorGrid& floor = this->floor();
  image::Image<fusion::FloorCell> cells(floor.columns(), floor.rows(), fusion::FloorCell::kUnknown);
  for (int row = 0; row < floor.rows(); ++row) {
    for (int column = 0; column < floor.columns(); ++column) {
      cells.at(column, row) = floor.at(column, row);
    }
  }
  const auto reach = static_cast<int>(std::ceil(radius_m / floor.cell_m()));
  for (const Vector2d& middle : middles) {
    const Eigen::Array2i cell =
        ((middle - floor.origin_m()) / floor.cell_m()).array().floor().cast<int>();
    for (int row = std::max(0, cell.y() - reach);
         row <= std::min(floor.rows() - 1, cell.y() + reach); ++row) {
      for (int column = std::max(0, cell.x() - reach);
           column <= std::min(floor.columns() - 1, cell.x() + reach); ++column) {
        if ((floor.cell_middle_m(column, row) - middle).norm() > radius_m) continue;
        cells.at(column, row) = fusion::FloorCell::kOccupied;
      }
    }
  }
  barred_floor_ = fusion::FloorGrid(floor.origin_m(), floor.cell_m(), std::move(cells));
}

bool Guidance::was_barred_here(const Pose& pose) const {
  return barred_at_ && (*barred_at_ - pose.position_gravity).norm() < kHand_m;
}

void Guidance::count_barred(const Pose& pose) {
  barred_times_ = was_barred_here(pose) ? barred_times_ + 1 : 1;
  barred_at_ = pose.position_gravity;
}

// 1: to the left, -1: to the right; there is more room ahead.
double Guidance::freer_side(const Pose& pose) const {
  constexpr double kAhead_m = 0.5;
  const auto room_m = [&](double side) {
    const double heading = pose.heading_rad + side * 30 * kDegree_rad;
    const Vector2d place =
        pose.position_gravity + kAhead_m * Vector2d(std::cos(heading), std::sin(heading));
    double clear_m = 0;
    while (clear_m < kAhead_m && floor().fits(place, clear_m)) clear_m += floor().cell_m();
    return clear_m;
  };
  return room_m(1) >= room_m(-1) ? 1 : -1;
}

// To who asks: no picture tells where they are. Who was seen a moment ago waits for the next one;
// for others a slow turn finds one.
Prompt Guidance::no_place(TimestampNs now_ns) {
  if (is_over() || state_ == State::kPaused) {
    waits_for_place_ = false;
    return say_lost("route.no_place", now_ns);
  }
  if (track_.pose(now_ns) != nullptr) return say({"route.none"}, now_ns, Confidence::kUnsure);
  waits_for_place_ = stairs_ || track_.age_s(now_ns) < options_.lost_standing_s;
  become_lost();
  return say_lost(waits_for_place_ ? "guide.lost_wait" : "route.no_place", now_ns);
}

// Who says so stands before what a cane found. It is as broad as a body, or, where no way were left
// then, as a hand: no more of it is known.
Prompt Guidance::blocked(const Pose& pose, TimestampNs now_ns) {
  if (map_.floor == nullptr) return act(pose, now_ns);  // by rooms: there is no way to go around on
  // What is in the way at the end of the way is the goal, or what it stands on; before its room it
  // is the door.
  const bool is_near = plan_.reach == Reach::kWhole && is_last_leg() && is_in_goal_room(pose) &&
                       left_m(pose) < 2 * kLegEnd_m;
  if (is_near) {
    // Unless they are farther from it than they could be, and have not tried yet.
    if (is_in_reach(pose) || was_barred_here(pose)) return arrive(pose, now_ns);
    count_barred(pose);
  }
  constexpr double kHandsBreadth_m = 0.1;
  const auto known = barred_floor_;
  for (const double radius_m : {options_.body_radius_m, kHandsBreadth_m}) {
    barred_floor_ = known;
    bar_what_is_ahead(pose, radius_m);
    Prompt prompt = act(pose, now_ns);
    if (plan_.reach == Reach::kWhole) return prompt;
  }
  // Not around it: what was known before holds again.
  barred_floor_.reset();
  count_barred(pose);
  side_to_try_ = freer_side(pose);
  // Who comes no further after some tries is told what is left, and is not sent again.
  if (barred_times_ > kMaxTries) return end_of_way(pose, now_ns);
  state_ = State::kStopped;
  return say({"guide.no_way_around"}, now_ns, Confidence::kUnsure);
}

// To who asks after the end of the way.
Prompt Guidance::say_end_again(const Pose* pose, TimestampNs now_ns) {
  said_of_end_ = goal_.kind == Goal::Kind::kRoom ? 1 : 0;
  return pose == nullptr             ? no_place(now_ns)
         : state_ == State::kArrived ? arrive(*pose, now_ns)
                                     : end_of_way(*pose, now_ns);
}

Prompt Guidance::request(GuidanceRequest request, TimestampNs now_ns) {
  if (state_ == State::kEnded) return say({"guide.not_running"}, now_ns);
  const Pose* const pose = track_.pose(now_ns);
  const bool is_led = pose != nullptr && !is_over() && state_ != State::kByRooms;
  const bool asks_for_way = request != GuidanceRequest::kEnd &&
                            request != GuidanceRequest::kPause &&
                            request != GuidanceRequest::kResume;
  if (is_over() && asks_for_way) return say_end_again(pose, now_ns);
  switch (request) {
    case GuidanceRequest::kEnd:
      state_ = State::kEnded;
      return say({"guide.ended"}, now_ns, Confidence::kSure, kNoticeValid_s);
    case GuidanceRequest::kPause:
      if (!is_over()) state_ = State::kPaused;
      return say({is_over() ? "guide.not_running" : "guide.paused"}, now_ns, Confidence::kSure,
                 kNoticeValid_s);
    case GuidanceRequest::kResume:
      if (state_ == State::kPaused) {
        state_ = said_of_beginning_ == 0 ? State::kBeginning
                 : stairs_               ? State::kStairs
                                         : State::kStopped;
      }
      return say({"guide.resumed"}, now_ns, Confidence::kSure, kNoticeValid_s);
    case GuidanceRequest::kRepeat:
      if (state_ == State::kPaused) return say({"guide.paused"}, now_ns);
      if (is_led && state_ == State::kStairs) return say_stairs(now_ns);
      return is_led ? act(*pose, now_ns) : no_place(now_ns);
    case GuidanceRequest::kHowFar:
      if (!is_led) return no_place(now_ns);
      if (legs_.empty()) plan_from(*pose);
      if (legs_.empty()) return say({"route.none"}, now_ns, Confidence::kUnsure);
      return say({"guide.far",
                  {{"goal", Nouns{goal_.noun}}, {"distance", wording_.distance(left_m(*pose))}}},
                 now_ns);
    case GuidanceRequest::kNext: {
      if (state_ == State::kPaused) return say({"guide.paused"}, now_ns);
      if (!is_led) return no_place(now_ns);
      const auto phrase = next_phrase(*pose);
      return phrase ? say(*phrase, now_ns) : act(*pose, now_ns);
    }
    case GuidanceRequest::kBlocked: {
      if (state_ == State::kPaused) return say({"guide.paused"}, now_ns);
      if (is_led && state_ == State::kStairs) return say_stairs(now_ns);  // the steps themselves
      if (is_led) return blocked(*pose, now_ns);
      Prompt prompt = no_place(now_ns);
      is_blocked_unseen_ = state_ == State::kLost && waits_for_place_;
      return prompt;
    }
  }
  return no_place(now_ns);
}

}  // namespace roomwise::guide
