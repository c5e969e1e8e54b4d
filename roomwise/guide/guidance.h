#pragma once

#include <deque>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "roomwise/guide/guidance_words.h"
#include "roomwise/guide/legs.h"
#include "roomwise/guide/obstacle.h"
#include "roomwise/guide/plan.h"
#include "roomwise/guide/prompt.h"
#include "roomwise/guide/walker_track.h"
#include "roomwise/guide/wording.h"

namespace roomwise::guide {

struct GuidanceOptions {
  PlanOptions plan = {};
  // The next action is announced while it is so far ahead, m.
  double announce_from_m = 3, announce_to_m = 1.5;
  // Who walks hears something after so much, whichever comes first.
  double reassure_m = 5, reassure_s = 8;
  // Off the way: so far beside it or turned so far from it, for so long.
  double off_way_m = 1, off_way_degrees = 30, off_way_s = 2;
  // Without a pose, of who walks or was told to, who is told to stand and wait as long again, and
  // of who stands: the slow turn that is asked for then costs more than waiting for the next
  // picture that tells of one.
  double lost_s = 4, lost_standing_s = 8;
  // From a person's edge to a thing that is reached, and a person's radius seen from above, m.
  double arrived_m = 0.3, body_radius_m = 0.25;
  // Who stands where there is something to do hears of it again after so long, once.
  double remind_s = 8;

  [[nodiscard]] Expected<void> validate() const;
};

// What is known of who is led, now.
struct Walker {
  TimestampNs now_ns = 0;         // of a clock that never goes back
  std::optional<Pose> pose = {};  // by the newest picture that told of one
  TimestampNs pose_ns = 0;        // when that was
  std::optional<std::string> room = {};
  // What depth shows straight ahead, m, wherever they are; absent where it shows nothing near.
  std::optional<double> obstacle_m = {};
  // What they could walk into, as the picture of the pose shows it: where on the floor.
  std::vector<Eigen::Vector2d> obstacles = {};
};

// Where the goal is, for who is about to touch it.
struct Aim {
  double bearing_rad = 0;  // from where they look, positive to the left
  double distance_m = 0;   // from their middle, along the floor
};

// How it goes, for who looks on.
enum class Course {
  kOnWay,
  kOffWay,   // and was told so
  kLost,     // nobody knows where they are
  kByRooms,  // no way is known: they are told the rooms that they come to
  kPaused,
  kWaits,    // for what is in the way and may go
  kArrived,  // down to here it is over
  kNearest,  // at the end of the way that is known
  kEnded,
};
[[nodiscard]] std::string_view to_string(Course course);  // "on_way"

// What the person led may want meanwhile.
enum class GuidanceRequest { kPause, kResume, kRepeat, kHowFar, kNext, kBlocked, kEnd };

// Leads somebody to a goal: told where they are again and again, it says what to do next, one
// action at a time. No sound, no threads, no clock of its own.
//
//   Guidance guidance(map, goal, wording);
//   if (auto prompt = guidance.update(walker)) ...say it...     some times a second
//
// It plans anew from where the person really is before each action, so that errors of steps and
// turns do not add up. Rules: docs/guide.md, each with a test.
class Guidance {
 public:
  enum class State {
    kBeginning,  // tells where things stand
    kTurning,    // on the spot
    kWalking,
    kCorner,   // at a leg's end, where a turn was announced
    kStopped,  // was told to stop; is told what to do once they stand
    kStairs,   // before stairs or on them; hears of the end
    kLost,     // nobody knows where the person is
    kPaused,
    kByRooms,  // only rooms are known
    kArrived,
    kNearest,  // at the end of the way that is known
    kEnded,    // by request, or since nothing is known
  };

  // What map and wording point to must outlive it.
  Guidance(const HomeMap& map, Goal goal, const Wording& wording,
           const GuidanceOptions& options = {});

  // What to say now, if anything. While an earlier prompt of its own is still being spoken only
  // what warns of a hazard.
  [[nodiscard]] std::optional<Prompt> update(const Walker& walker);
  // The answer to a request.
  [[nodiscard]] Prompt request(GuidanceRequest request, TimestampNs now_ns);

  [[nodiscard]] State state() const { return state_; }
  [[nodiscard]] Course course() const;
  // From the newest place along the way; nothing where either is not known.
  [[nodiscard]] std::optional<double> left_m() const;
  [[nodiscard]] bool is_over() const {
    return state_ == State::kArrived || state_ == State::kNearest || state_ == State::kEnded;
  }
  // Whether what is in the way is told by it where it matters, or needs no word since somebody
  // stands, was just told to turn on the spot, or is on stairs. Else whoever sees it must tell:
  // paused, lost for long or without a place people walk as they like.
  [[nodiscard]] bool judges_obstacles(TimestampNs now_ns) const;
  [[nodiscard]] const Goal& goal() const { return goal_; }
  // The way that is followed now.
  [[nodiscard]] const Plan& plan() const { return plan_; }
  // Of a thing that is near and straight ahead or to be turned to, by the newest picture; absent
  // where its place or theirs is not sure, or something else is to be done first.
  [[nodiscard]] std::optional<Aim> aim() const;
  // Where the leg ends that is being walked; of stairs a place over their first step.
  [[nodiscard]] std::optional<Eigen::Vector2d> next_place() const;

 private:
  static constexpr double kSpoken_s = 2;  // a prompt of some words
  using MaybePrompt = std::optional<Prompt>;
  [[nodiscard]] Prompt say(const Phrase& phrase, TimestampNs now_ns,
                           Confidence confidence = Confidence::kSure, double valid_s = 2);
  [[nodiscard]] MaybePrompt begin(const Walker& walker);
  [[nodiscard]] MaybePrompt where_one_stands(const Pose& pose, TimestampNs now_ns);
  [[nodiscard]] MaybePrompt turning(const Pose& pose, TimestampNs now_ns);
  [[nodiscard]] MaybePrompt walking(const Pose& pose, TimestampNs now_ns);
  [[nodiscard]] MaybePrompt at_leg_end(const Pose& pose, TimestampNs now_ns);
  [[nodiscard]] MaybePrompt corner(const Pose& pose, TimestampNs now_ns);
  [[nodiscard]] MaybePrompt keep_on_way(const Pose& pose, TimestampNs now_ns);
  [[nodiscard]] MaybePrompt announce(const Pose& pose, TimestampNs now_ns);
  [[nodiscard]] MaybePrompt stopped(const Pose& pose, TimestampNs now_ns);
  [[nodiscard]] MaybePrompt on_stairs(const Pose& pose, TimestampNs now_ns);
  [[nodiscard]] Prompt say_stairs(TimestampNs now_ns);
  [[nodiscard]] std::span<const fusion::Staircase> known_stairs() const;
  [[nodiscard]] bool is_next_leg_stairs() const {
    return leg_ + 1 < legs_.size() && legs_[leg_ + 1].stairs.has_value();
  }
  [[nodiscard]] MaybePrompt without_pose(const Walker& walker);
  [[nodiscard]] Prompt say_lost(const char* message, TimestampNs now_ns);
  [[nodiscard]] Prompt no_place(TimestampNs now_ns);
  [[nodiscard]] Prompt say_end_again(const Pose* pose, TimestampNs now_ns);
  [[nodiscard]] Prompt blocked(const Pose& pose, TimestampNs now_ns);
  void become_lost();
  [[nodiscard]] double unseen_step_m() const;
  [[nodiscard]] bool may_step_unseen(TimestampNs now_ns) const;
  [[nodiscard]] bool may_end_unseen() const;
  [[nodiscard]] Prompt step_unseen(TimestampNs now_ns);
  [[nodiscard]] MaybePrompt end_unseen(TimestampNs now_ns);
  // What it lies on, how high to reach, and what a helper noted.
  [[nodiscard]] std::vector<Phrase> at_goal_phrases() const;
  // Was just told to: what is ahead of who turns on the spot is in nobody's way for a while.
  [[nodiscard]] Prompt say_to_turn(const Phrase& phrase, TimestampNs now_ns,
                                   Confidence confidence = Confidence::kSure, double valid_s = 2);
  [[nodiscard]] MaybePrompt by_rooms(const Walker& walker);
  [[nodiscard]] MaybePrompt off_the_way(const Pose& pose, TimestampNs now_ns);
  [[nodiscard]] MaybePrompt hazard(const Pose& pose, TimestampNs now_ns);
  [[nodiscard]] MaybePrompt finish(TimestampNs now_ns);
  [[nodiscard]] const KnownThing* thing_between(const Eigen::Vector2d& from) const;
  [[nodiscard]] double left_when_heard_m(double distance_m, double spoken_s = kSpoken_s) const;
  [[nodiscard]] double walked_since_pose_m() const;
  void keep_pace();
  [[nodiscard]] Prompt arrive_or_stop(const Pose& pose, TimestampNs now_ns);
  [[nodiscard]] Prompt arrive(const Pose& pose, TimestampNs now_ns);
  [[nodiscard]] Prompt stop(const Phrase& phrase, TimestampNs now_ns);
  // Plans anew and says what to do now.
  [[nodiscard]] Prompt act(const Pose& pose, TimestampNs now_ns);
  [[nodiscard]] double freer_side(const Pose& pose) const;
  [[nodiscard]] Prompt end_of_way(const Pose& pose, TimestampNs now_ns);
  void plan_from(const Pose& pose);
  void reach_out();
  [[nodiscard]] double narrow_m_at(const Eigen::Vector2d& here) const;
  void step_clear(const Pose& pose);
  [[nodiscard]] bool may_skip_leg(const Pose& pose) const;
  [[nodiscard]] bool comes_to_rest(const Pose& pose) const;
  [[nodiscard]] const fusion::FloorGrid& floor() const {
    return barred_floor_ ? *barred_floor_ : *map_.floor;
  }
  [[nodiscard]] bool has_arrived(const Pose& pose);
  // What depth shows in the way, as seen along this leg, and whether the map knows it.
  struct InTheWay {
    ObstacleAhead seen;
    Pose from;  // where they stand, along the leg
    bool is_on_map = false;

    [[nodiscard]] double ahead_m() const { return seen.ahead_left_m.x(); }
    [[nodiscard]] ObstacleAhead::Side side_by(const Pose& pose) const;
  };
  [[nodiscard]] std::optional<InTheWay> in_the_way(const Pose& pose) const;
  [[nodiscard]] bool is_goal(const Eigen::Vector2d& obstacle) const;
  [[nodiscard]] bool is_in_reach(const Pose& pose) const;
  void bar_what_is_ahead(const Pose& pose, double radius_m);
  void bar_what_is_seen();
  void mark_occupied(std::span<const Eigen::Vector2d> middles, double radius_m);
  // That somebody came no further, about where they stand now.
  [[nodiscard]] bool was_barred_here(const Pose& pose) const;
  void count_barred(const Pose& pose);

  [[nodiscard]] bool is_at_goal(const Pose& pose) const;
  [[nodiscard]] bool is_in_goal_room(const Pose& pose) const;
  [[nodiscard]] double left_on_leg_m(const Pose& pose) const;
  [[nodiscard]] double left_m(const Pose& pose) const;
  [[nodiscard]] double bearing_error_rad(const Pose& pose) const;
  [[nodiscard]] bool goes_straight_on() const;  // after this leg
  [[nodiscard]] bool is_solid() const {         // the goal: it is come up to, and not stood on
    return goal_.kind == Goal::Kind::kThing || goal_.kind == Goal::Kind::kWayOut;
  }
  [[nodiscard]] bool is_last_leg() const { return leg_ + 1 >= legs_.size(); }
  [[nodiscard]] std::optional<std::string> room_beyond(const Leg& leg) const;
  // What a hand finds at the end of the leg, or the room that begins there.
  [[nodiscard]] std::optional<Noun> place_at_end(const Leg& leg, bool is_last) const;
  [[nodiscard]] std::optional<Phrase> next_phrase(const Pose& pose,
                                                  double spoken_s = kSpoken_s) const;
  [[nodiscard]] std::string distance(double distance_m) const;
  [[nodiscard]] bool is_speaking(TimestampNs now_ns) const { return now_ns < silent_from_ns_; }
  [[nodiscard]] double silent_for_s(TimestampNs now_ns) const {
    return seconds_between(silent_from_ns_, now_ns);
  }

  const HomeMap map_;
  const Goal goal_;
  const Wording wording_;
  const GuidanceOptions options_;
  const std::vector<rooms::Doorway> doorways_;

  State state_ = State::kBeginning;
  WalkerTrack track_;
  std::optional<std::string> room_;
  bool is_placed_ = false;                         // by the newest picture, and that is believed
  std::vector<Eigen::Vector2d> obstacles_;         // that it shows
  std::optional<double> obstacle_m_;               // straight ahead, wherever that is
  std::optional<fusion::FloorGrid> barred_floor_;  // where the person found the way barred
  std::optional<Eigen::Vector2d> barred_at_;       // and where no other one is known
  std::optional<double> side_to_try_;              // where it has more room, after it was barred
  std::optional<Eigen::Vector2d> known_stop_at_;   // before what the map knows, told once
  int barred_times_ = 0;                           // there
  bool is_barred_by_hazard_ = false;               // just now, on a way that led to the goal
  std::optional<TimestampNs> waits_since_ns_;      // for what is in the way and may go
  Plan plan_;
  std::vector<Leg> legs_;
  std::size_t leg_ = 0;
  int said_of_beginning_ = 0;       // how much of the beginning was said
  int said_of_end_ = 0;             // how much of the end was said
  bool waits_for_place_ = false;    // lost, and told to stand; not yet to turn
  bool is_blocked_unseen_ = false;  // said so meanwhile: it is told once their place is known
  bool should_be_there_ = false;    // was told so without a place
  TimestampNs steps_until_ns_ = 0;  // the steps that were asked for without a place; 0: none were
  TimestampNs turns_until_ns_ = 0;  // on the spot, as they were told to
  bool announced_ = false;          // what comes after this leg
  bool reminded_ = false;           // of what to do now
  double turn_from_rad_ = 0;        // the heading when a turn was asked for
  double pace_m_s_ = 0.5;           // at which they walk when they walk
  double pose_age_s_ = 0;           // of the newest place that is believed
  double said_at_walked_m_ = 0;
  std::optional<StairsOnWay> stairs_;  // that are walked over now
  std::optional<TimestampNs> off_since_ns_;
  bool is_off_way_ = false;                    // was told so, and of no other way yet
  std::optional<Eigen::Vector2d> at_goal_by_;  // the first place that was at the goal
  std::optional<TimestampNs> corrected_ns_;
  std::optional<TimestampNs> hazard_ns_;
  TimestampNs silent_from_ns_ = 0;  // the newest prompt has been spoken by then
  TimestampNs began_ns_ = 0;
  std::optional<std::string> told_room_;
};

}  // namespace roomwise::guide
