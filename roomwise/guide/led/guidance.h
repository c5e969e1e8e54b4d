#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "roomwise/guide/led/barred_floor.h"
#include "roomwise/guide/led/followed_way.h"
#include "roomwise/guide/led/guidance_options.h"
#include "roomwise/guide/led/in_the_way.h"
#include "roomwise/guide/led/walker_track.h"
#include "roomwise/guide/words/prompt.h"
#include "roomwise/guide/words/wording.h"

namespace roomwise::guide {

// What is known of who is led, now.
struct Walker {
  TimestampNs now_ns = 0;         // of a clock that never goes back
  std::optional<Pose> pose = {};  // by the newest picture that told of one
  TimestampNs pose_ns = 0;        // when that was
  std::optional<std::string> room = {};
  // What depth shows straight ahead, m, wherever they are, as far as two steps and a body reach and
  // farther; absent where it shows nothing there.
  std::optional<double> obstacle_m = {};
  bool has_depth = false;  // that picture; else what is absent may be there
  // What they could walk into, as the picture of the pose shows it: where on the floor.
  std::vector<Eigen::Vector2d> obstacles = {};
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

  // What map and wording point to must outlive it. `barred`: what was found on the way before.
  Guidance(const HomeMap& map, Goal goal, const Wording& wording,
           const GuidanceOptions& options = {}, std::vector<BarredPlace> barred = {})
      : wording_(wording),
        floor_(map.floor, std::move(barred)),
        way_(map, std::move(goal), options) {}

  // What to say now, if anything. While an earlier prompt of its own is still being spoken only
  // what warns of a hazard.
  [[nodiscard]] std::optional<Prompt> update(const Walker& walker);
  // The answer to a request.
  [[nodiscard]] Prompt request(GuidanceRequest request, TimestampNs now_ns);
  // Before another guidance takes this one's place: "Stop." to who walks.
  [[nodiscard]] std::optional<Prompt> stop_who_walks(TimestampNs now_ns);
  // Since the home does not know the goal any more; what to say of it.
  [[nodiscard]] Prompt end_without_goal(TimestampNs now_ns);

  // From now on, to who changed their language or how distances are told.
  void speak_by(const Wording& wording) { wording_ = wording; }

  [[nodiscard]] State state() const { return state_; }
  [[nodiscard]] Course course() const;
  // From the newest place along the way; nothing where either is not known.
  [[nodiscard]] std::optional<double> left_m() const;
  [[nodiscard]] bool is_over() const {
    return state_ == State::kArrived || state_ == State::kNearest || state_ == State::kEnded;
  }
  // Whether what is in the way is told by it where it matters, or needs no word since somebody
  // stands, was just told to turn and does that on the spot, or is on stairs. Else whoever sees it
  // must tell: paused, lost for long or without a place people walk as they like.
  [[nodiscard]] bool judges_obstacles(TimestampNs now_ns) const;
  [[nodiscard]] const Goal& goal() const { return way_.goal(); }
  // The floor as it was found on the way.
  [[nodiscard]] const BarredFloor& floor() const { return floor_; }
  // The way that is followed now.
  [[nodiscard]] const Plan& plan() const { return way_.plan(); }
  // Of a thing that is near and straight ahead or to be turned to, by the newest picture; absent
  // where its place or theirs is not sure, or something else is to be done first.
  [[nodiscard]] std::optional<GoalBearing> goal_bearing() const;
  // Where the leg ends that is being walked; of stairs a place over their first step.
  [[nodiscard]] std::optional<Eigen::Vector2d> next_place() const;

 private:
  using MaybePrompt = std::optional<Prompt>;
  [[nodiscard]] TimestampNs now_ns() const { return walker_.now_ns; }
  void see(const Walker& walker);

  // ---- saying ----
  [[nodiscard]] Prompt say(const Phrase& phrase, Confidence confidence = Confidence::kSure,
                           double valid_s = kDirectionValid_s);
  [[nodiscard]] Prompt say_to_turn(const Phrase& phrase, Confidence confidence = Confidence::kSure,
                                   double valid_s = kDirectionValid_s);
  [[nodiscard]] Prompt say_lost(const char* message);
  [[nodiscard]] Prompt say_stairs();
  [[nodiscard]] Prompt say_end(State end, const Phrase& phrase, Confidence confidence);
  [[nodiscard]] Prompt say_end_again(const Pose* pose, GuidanceRequest request);
  [[nodiscard]] bool is_speaking() const { return now_ns() < said_.until_ns; }
  [[nodiscard]] double silent_for_s() const { return seconds_between(said_.until_ns, now_ns()); }
  // To the leg's end when so many seconds of words have been heard, in words.
  [[nodiscard]] std::string left_on_leg(const Pose& pose, double spoken_s = kSpoken_s) const;
  [[nodiscard]] std::optional<Phrase> what_comes_next(const Pose& pose,
                                                      double spoken_s = kSpoken_s) const;

  // ---- each state, with a place ----
  [[nodiscard]] MaybePrompt begin(const Pose& pose);
  [[nodiscard]] MaybePrompt turning(const Pose& pose);
  [[nodiscard]] MaybePrompt walking(const Pose& pose);
  [[nodiscard]] MaybePrompt at_leg_end(const Pose& pose);
  [[nodiscard]] MaybePrompt keep_on_way(const Pose& pose);
  [[nodiscard]] MaybePrompt announce(const Pose& pose);
  [[nodiscard]] MaybePrompt corner(const Pose& pose);
  [[nodiscard]] MaybePrompt stopped(const Pose& pose);
  [[nodiscard]] MaybePrompt waiting();
  [[nodiscard]] MaybePrompt on_stairs(const Pose& pose);
  [[nodiscard]] MaybePrompt hazard(const Pose& pose);
  [[nodiscard]] MaybePrompt off_the_way(const Pose& pose);

  // ---- what somebody does then ----
  void plan_from(const Pose& pose);
  // Where none was known before.
  [[nodiscard]] bool finds_way(const Pose& pose);
  // Plans anew and says what to do now.
  [[nodiscard]] Prompt act(const Pose& pose);
  [[nodiscard]] Prompt act_on_plan(const Pose& pose);
  [[nodiscard]] Prompt turn(const Pose& pose, const Phrase& phrase);
  [[nodiscard]] Prompt stop(const Phrase& phrase);
  [[nodiscard]] Prompt blocked(const Pose& pose);
  [[nodiscard]] bool walks_past_end(const Pose& pose) const;
  [[nodiscard]] bool has_arrived(const Pose& pose) {
    return way_.has_arrived(pose, track_.is_standing());
  }
  [[nodiscard]] Prompt arrive_or_stop(const Pose& pose);
  [[nodiscard]] Prompt arrive(const Pose& pose);
  [[nodiscard]] Prompt end_of_way();
  [[nodiscard]] Prompt end_barred();
  [[nodiscard]] MaybePrompt finish();
  // What is still to be told of it.
  [[nodiscard]] MaybePrompt say_of_goal(Confidence confidence);
  [[nodiscard]] Prompt answer(GuidanceRequest request);

  // ---- without a place ----
  [[nodiscard]] MaybePrompt unseen();
  [[nodiscard]] Prompt step_unseen(double step_m);
  [[nodiscard]] MaybePrompt end_unseen();
  [[nodiscard]] MaybePrompt lost();
  void become_lost();
  [[nodiscard]] Prompt no_place();
  [[nodiscard]] MaybePrompt by_rooms();
  // After a pause, or once they are seen again.
  [[nodiscard]] State resumed() const;

  static constexpr double kSpoken_s = 2;  // a prompt of some words

  struct Said {
    TimestampNs until_ns = 0;        // the newest prompt has been spoken by then
    TimestampNs turns_until_ns = 0;  // on the spot, as they were told to
    double at_walked_m = 0;
    int of_beginning = 0, of_end = 0;  // how much
    bool what_comes_next = false;      // after this leg
    bool reminder = false;             // of what to do now
    bool wait = false;                 // that somebody may be in the way, since they wait
    std::string end;                   // the words of it
  };
  struct Line {  // of the leg, to which they keep or do not
    std::optional<TimestampNs> off_since_ns;
    std::optional<TimestampNs> corrected_ns;
    bool is_off = false;  // was told so, and of no other way yet
  };
  struct Barred {
    bool by_hazard = false;                     // just now, on a way that led to the goal
    std::optional<double> side_to_try;          // where there is more room
    std::optional<TimestampNs> waits_since_ns;  // for what is in the way and may go
    bool may_be_somebody = false;               // that is; it was not tried here before
    bool ends_way = false;                      // they came no further
  };
  struct Unseen {
    TimestampNs led_since_ns = 0;     // 0: they are not yet
    TimestampNs steps_until_ns = 0;   // that were asked for without a place; 0: none were
    bool should_be_there = false;     // was told so
    bool waits_for_place = false;     // lost, and told to stand; not yet to turn
    bool is_blocked = false;          // said so meanwhile: it is told once their place is known
    std::optional<std::string> room;  // of which was told
  };

  Wording wording_;
  BarredFloor floor_;
  FollowedWay way_;
  State state_ = State::kBeginning;
  Walker walker_;  // newest; its pose and what was seen from there only where it is believed
  WalkerTrack track_;
  HazardWatch hazards_;
  Said said_;
  Line line_;
  Barred barred_;
  Unseen unseen_;
  std::optional<StairsOnWay> stairs_;  // that are walked over now
  TimestampNs planned_ns_ = 0;
  double turn_from_rad_ = 0;  // the heading when a turn was asked for
};

}  // namespace roomwise::guide
