#pragma once

#include <cstdint>

#include "roomwise/home/home.h"
#include "roomwise/mapping/map_solver.h"
#include "roomwise/objects/object_map.h"
#include "roomwise/recording/trajectory_file.h"

// What follows from the measurements that a home holds, and can be computed anew at any time.
namespace roomwise::pipeline {

// Optimises the pose graph of all that is stored and moves the key-frames.
[[nodiscard]] Expected<mapping::MapSolution> solve_stored_map(
    home::Home& home, const mapping::MapSolverOptions& options);

// The pose graph as the map is now: without the loops that contradict it (solve_map() left them
// out).
[[nodiscard]] Expected<mapping::PoseGraph> stored_pose_graph(
    const home::Home& home, const mapping::MapSolverOptions& options);

// Applies the rules of objects/ to what the networks saw, with the home's concepts and the poses as
// they are now: after mapping, after optimising, after editing the concepts. The number of objects.
[[nodiscard]] Expected<std::uint64_t> update_objects(home::Home& home,
                                                     const objects::ObjectRules& rules);

// The poses of all frames that the largest piece of the map places, in the order of time.
[[nodiscard]] Expected<recording::Trajectory> stored_trajectory(const home::Home& home);

}  // namespace roomwise::pipeline
