#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "roomwise/guide/led/barred_floor.h"
#include "roomwise/guide/led/guidance_options.h"
#include "roomwise/guide/way/legs.h"
#include "roomwise/guide/way/plan.h"

namespace roomwise::guide {

// Where the goal is, for who is about to touch it.
struct GoalBearing {
  double bearing_rad = 0;  // from where they look, positive to the left
  double distance_m = 0;   // from their middle, along the floor
};

// The way that somebody is led along to a goal, in legs of which one is walked now. It tells where
// on it they are, and whether they are there.
class FollowedWay {
 public:
  // What the map points to must outlive it.
  FollowedWay(const HomeMap& map, Goal goal, const GuidanceOptions& options)
      : map_(map), goal_(std::move(goal)), options_(options) {}

  // From where they are, with a pose. Legs that end there are left out.
  void plan_from(const UserLocation& from, const BarredFloor& floor);
  void take_next_leg() { ++leg_; }

  [[nodiscard]] const HomeMap& map() const { return map_; }
  [[nodiscard]] const Goal& goal() const { return goal_; }
  [[nodiscard]] const GuidanceOptions& options() const { return options_; }
  [[nodiscard]] const Plan& plan() const { return plan_; }
  [[nodiscard]] bool leads_to_goal() const { return plan_.status == PlanStatus::kComplete; }
  [[nodiscard]] bool leads_over_floor() const {
    return leads_to_goal() || plan_.status == PlanStatus::kPartial;
  }
  [[nodiscard]] double planned_m() const { return length_m(plan_.route, home_stairs()); }

  // The leg that is walked now; there is none before it is planned and where one stays.
  [[nodiscard]] bool has_legs() const { return !legs_.empty(); }
  [[nodiscard]] const Leg& leg() const { return legs_[leg_]; }
  [[nodiscard]] bool is_last_leg() const { return leg_ + 1 >= legs_.size(); }
  [[nodiscard]] const Leg& next_leg() const { return legs_[leg_ + 1]; }
  [[nodiscard]] bool goes_over_stairs_next() const { return !is_last_leg() && next_leg().stairs; }
  [[nodiscard]] bool goes_straight_on() const;
  // What a hand finds at its end, or the room that begins there.
  [[nodiscard]] std::optional<Noun> place_at_end() const;
  // "_left" or "_right" of who is there, where a thing is named that they stand beside; else "".
  [[nodiscard]] std::string side_at_end() const;
  // Of an opening that ends it.
  [[nodiscard]] std::optional<std::string> room_beyond() const;
  // Where it ends; of stairs a place over their first step.
  [[nodiscard]] Eigen::Vector2d next_place() const;

  // To its end: straight, along its direction, and by how much to turn, positive to the left.
  [[nodiscard]] double to_end_m(const Pose& pose) const {
    return (leg().to - pose.position_plan).norm();
  }
  [[nodiscard]] double left_on_leg_m(const Pose& pose) const;
  // Half a step before it; who was told less than that has to walk half of it.
  [[nodiscard]] bool is_at_leg_end(const Pose& pose) const {
    return left_on_leg_m(pose) < (leg().length_m < kLegEnd_m ? leg().length_m / 2 : kLegEnd_m);
  }
  [[nodiscard]] double bearing_error_rad(const Pose& pose) const;
  [[nodiscard]] bool is_off(const Pose& pose) const;
  // It leads to the goal, and its end can be walked to straight from there.
  [[nodiscard]] bool may_keep_leg(const Pose& pose, const BarredFloor& floor) const;
  // To the end of the way.
  [[nodiscard]] double left_m(const Pose& pose) const;
  // How far somebody may go on along the leg whom no picture places any more; `obstacle_m`: what
  // depth shows ahead of them.
  [[nodiscard]] std::optional<double> unseen_step_m(const Pose& last,
                                                    std::optional<double> obstacle_m,
                                                    const BarredFloor& floor) const;

  [[nodiscard]] bool is_in_goal_room(const Pose& pose) const;
  // By two places, of which one may be wrong, or of who stands.
  [[nodiscard]] bool has_arrived(const Pose& pose, bool is_standing);
  // Without being told: at what stands before them, or anywhere in a room.
  [[nodiscard]] bool comes_to_rest(const Pose& pose) const;
  // A step straight on, and they come to rest at the goal.
  [[nodiscard]] bool is_last_step(const Pose& pose) const;
  // As near as the way leads; anywhere in a room.
  [[nodiscard]] bool is_in_reach(const Pose& pose) const;
  // What somebody is led up to is in nobody's way, nor is what it stands on.
  [[nodiscard]] bool is_goal(const Eigen::Vector2d& obstacle) const;
  // Of a thing that is near, where its place and theirs are sure and they could walk straight at
  // it.
  [[nodiscard]] std::optional<GoalBearing> goal_bearing(const Pose& pose,
                                                        const BarredFloor& floor) const;

 private:
  void reach_out();
  [[nodiscard]] bool ends_at_goal() const { return is_last_leg() && leads_to_goal(); }
  // What a hand finds there, and on which side; no thing where another place ends it.
  [[nodiscard]] std::pair<const KnownThing*, std::string> thing_at_end() const;
  void step_clear(const Pose& pose, const BarredFloor& floor);
  [[nodiscard]] bool may_skip_leg(const Pose& pose, const BarredFloor& floor) const;
  [[nodiscard]] bool is_at_goal(const Pose& pose) const;
  [[nodiscard]] std::span<const fusion::Staircase> home_stairs() const;

  const HomeMap map_;
  const Goal goal_;
  const GuidanceOptions options_;
  Plan plan_;
  std::vector<Leg> legs_;
  std::size_t leg_ = 0;
  std::optional<Eigen::Vector2d> at_goal_by_;  // the first place that was at the goal
};

}  // namespace roomwise::guide
