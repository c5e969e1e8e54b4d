#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "laboratory/simulation/scene/home_meshes.h"
#include "laboratory/trials/guidance/guidance_trial.h"

namespace roomwise::trials {

// What is in the way of each walk, and the map does not know of.
enum class Hindrance {
  kNone,
  kPerson,      // somebody stands on the way
  kPersonGoes,  // and goes, some seconds after who is led came up to them
  kClosedDoor,  // a door on the way is shut, and does not open
};
// "person", "person-goes" or "closed-door"; nothing for any other name.
[[nodiscard]] std::optional<Hindrance> parse_hindrance(std::string_view name);

// A goal in the home as it is on the walk there.
struct WalkGround {
  std::shared_ptr<const WalkedHome> home;
  GuidedGoal goal;
  std::optional<Leaving> leaving = {};
};
// Puts something in the way that the guide would plan to each goal, by the seed: somebody at least
// a metre from its ends, or a shut door that it leads through. Where there is no place for it
// nothing is. How far it is then, and whether there is another way, the goal tells.
[[nodiscard]] std::vector<WalkGround> hinder(const GuidedMap& map,
                                             const std::shared_ptr<const WalkedHome>& home,
                                             std::span<const GuidedGoal> goals, Hindrance hindrance,
                                             const TrialOptions& options);

// Loads what `load` does, and bodies of people.
[[nodiscard]] simulation::MeshLoader with_people(simulation::MeshLoader load);

}  // namespace roomwise::trials
