#pragma once

#include <span>
#include <vector>

#include "laboratory/simulation/furniture/furniture_catalogue.h"
#include "laboratory/simulation/home/free_space.h"
#include "laboratory/simulation/home/home_model.h"
#include "roomwise/base/expected.h"
#include "roomwise/guide/way/plan.h"

// Made-up homes to lead made-up people through. World frame: that of the home, z up, metres; it is
// the gravity-aligned frame of the map, too.
namespace roomwise::trials {

// What the guide is told of a home: floor, rooms and things as they truly are by day, with the
// doorways that the layout finds along a walk that is named rightly.
struct GuidedMap {
  fusion::FloorGrid floor;
  rooms::RoomLayout layout;
  std::vector<guide::KnownThing> things;
  std::vector<std::string> object_of_thing;  // its name in the home: "chair 3"
  std::optional<guide::Outline> way_out;     // the front door
  std::optional<std::string> way_out_room = {};
  fusion::Storeys storeys = {};

  // Borrows from this.
  [[nodiscard]] guide::HomeMap view() const {
    return {&floor, &layout, layout.doorways(), things, &storeys};
  }
};
[[nodiscard]] Expected<GuidedMap> map_truth(const simulation::HomeModel& home,
                                            std::span<const simulation::FurnitureModel> models,
                                            std::uint64_t seed);

// Where things are when somebody is led: what a body runs into, and what a cane finds of it.
struct WalkedHome {
  explicit WalkedHome(const simulation::HomeModel& home);

  simulation::HomeModel model;
  fusion::FloorGrid floor;  // of what a body runs into, between ankle and head
  fusion::FloorGrid cane;   // up to the hip: what hangs higher is not found
  fusion::Storeys storeys;  // as they truly are

  // What a body would touch there first: a thing by its name, or "right wall of the kitchen", as a
  // plan is drawn. Only of places near to something.
  [[nodiscard]] std::string nearest_thing(const Eigen::Vector2d& place) const;
};

// Somebody who stands in the way goes, so long after who is led came up to them.
struct Leaving {
  std::shared_ptr<const WalkedHome> then;
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
  double after_s = 0;
};

// Storeys and stairs of a home, which is planned as the map draws it: side by side.
[[nodiscard]] fusion::Storeys true_storeys(const simulation::HomeModel& home);

[[nodiscard]] fusion::FloorGrid grid_of(const simulation::FreeSpace& space);

// Where somebody is to be led, and what is true of it.
struct GuidedGoal {
  guide::Goal goal;                            // as the guide is told
  std::optional<guide::Outline> outline = {};  // where it truly is; a room has none
  std::optional<std::size_t> room = {};        // index into HomeModel::rooms: one must be in it
  Eigen::Vector2d start = Eigen::Vector2d::Zero();
  double start_heading_rad = 0;
  // From the goal to the nearest place where a person can stand: beside it, or before what it
  // stands on or behind.
  double nearest_stand_m = 0;
  // What one would say to be led there: "table"; set where goals are asked for by name.
  std::string word = {};
  double shortest_m = 0;        // from the start to the nearest place that counts as there
  bool is_over_stairs = false;  // it lies on another storey than the start
  bool is_hindered = false;     // something is in the way that the map does not know of
  bool is_reachable = true;     // as things are now
};

struct GoalOptions {
  std::uint64_t seed = 0;
  std::size_t goals = 20;
  double arrived_m = 0.3;  // so much farther from the goal than a person can get
  double body_radius_m = 0.25;
  double min_way_m = 2;  // shorter ones need no guide
  // Only what anybody can ask for by its name: rooms, and things that a home has a word for and of
  // which one of their name stands in a room.
  bool by_name = false;

  [[nodiscard]] Expected<void> validate() const;
};

// Whether somebody who stands there is at the goal: in its room, and as near as a person can get,
// give or take arrived_m.
[[nodiscard]] bool is_there(const simulation::HomeModel& home, const GuidedGoal& goal,
                            const Eigen::Vector2d& place, const GoalOptions& options);

// The shortest way from the start to where somebody is there; nothing where there is none.
[[nodiscard]] std::optional<double> shortest_way_m(const WalkedHome& home, const GuidedGoal& goal,
                                                   const GoalOptions& options);

// Things, rooms, doors, spots and the way out, drawn by the seed, and places to begin from; only
// what a person can reach as things are now.
[[nodiscard]] Expected<std::vector<GuidedGoal>> choose_goals(const GuidedMap& map,
                                                             const WalkedHome& home,
                                                             const GoalOptions& options);

}  // namespace roomwise::trials
