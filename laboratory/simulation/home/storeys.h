#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "laboratory/simulation/home/home_generator.h"
#include "laboratory/simulation/home/home_model.h"
#include "roomwise/base/expected.h"

// Homes of two storeys: planned side by side, in the world above one another.
namespace roomwise::simulation {

// A furnished home of two storeys by day, as a plan: the options' rooms below, bedrooms, a bathroom
// and perhaps a study above, joined by a straight staircase in a hall of its own, through which one
// enters. Fails where no upper storey was found that can stand on the lower one.
[[nodiscard]] Expected<HomeModel> generate_two_storeys(const HomeOptions& options,
                                                       std::span<const FurnitureModel> models);

// The same home with its storeys above one another, as it is drawn and written down. Of one storey
// it is the plan.
[[nodiscard]] HomeModel in_world(HomeModel plan);

// The first step's and the last step's side of it, where one stands before climbing and after;
// in the plan of the lower and of the upper storey.
[[nodiscard]] Eigen::Vector2d place_below(const Staircase& stairs);
[[nodiscard]] Eigen::Vector2d place_above(const HomeModel& plan, const Staircase& stairs);

// The way over stairs from place_below() to the same place as place_above(), in the world.
struct StairsWay {
  std::vector<Eigen::Vector2d> places;
  std::vector<double> floor_m;  // how high one's feet are, evened out as a body does
};
[[nodiscard]] StairsWay way_over(const HomeModel& plan, const Staircase& stairs);

// A room of a plan by a place in the world and the height of the feet there.
[[nodiscard]] std::size_t room_at(const HomeModel& plan, const Eigen::Vector2d& place_world,
                                  double floor_m);

}  // namespace roomwise::simulation
