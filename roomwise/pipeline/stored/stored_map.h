#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "roomwise/base/progress.h"
#include "roomwise/home/home.h"
#include "roomwise/mapping/backend/map_refinement.h"
#include "roomwise/mapping/backend/map_solver.h"
#include "roomwise/objects/detection/confirmed_objects.h"
#include "roomwise/pipeline/stored/lost_pictures.h"
#include "roomwise/pipeline/stored/map_settings.h"
#include "roomwise/recording/trajectory_file.h"

// What follows from the measurements that a home holds, and can be computed anew at any time.
namespace roomwise::pipeline {

struct SolvedMap {
  mapping::MapSolution solution;  // of the pose graph
  // Where the settings adjust the bundle: the key-frames are where this puts them.
  std::optional<mapping::MapRefinement> refinement;
  // Why key-frames could not be read that would have told whether parts show the same place.
  std::map<home::KeyframeId, std::string> unread = {};
};

// Optimises the pose graph of all that is stored, adjusts the bundle where the settings say so, and
// moves the key-frames; where the user interrupts, none is moved. A walk that is not finished joins
// what was solved before: the edges between earlier key-frames say where they are now, and
// landmarks are looked for only in its key-frames and in those that may show the same.
// `find_features` gives what landmarks are found by; of a large map it is asked for one part after
// the other.
[[nodiscard]] Expected<SolvedMap> solve_stored_map(home::Home& home, const MapSettings& settings,
                                                   const mapping::FindFeatures& find_features,
                                                   Progress& progress);

// Takes a walk out of the home, and what was learned of rooms, for which it may have counted; the
// others stay where they are. Where it joined two of them they come apart. Things are joined anew
// from what is left.
[[nodiscard]] Expected<void> forget_walk(home::Home& home, home::RecordingId walk);

// The pose graph as the map is now: without the loops that contradict it (solve_map() left them
// out).
[[nodiscard]] Expected<mapping::PoseGraph> stored_pose_graph(
    const home::Home& home, const mapping::MapSolverOptions& options);

// Up in the map's world as the device felt it at these key-frames, at the poses given with them;
// those where it felt no gravity are left out.
[[nodiscard]] Expected<std::map<home::KeyframeId, Eigen::Vector3d>> stored_gravity(
    const home::Home& home, std::span<const home::Keyframe> keyframes);

struct FoundObjects {
  std::uint64_t by_rules = 0;   // the paper's
  std::uint64_t instances = 0;  // joined from regions
};
// Applies the rules of objects/ to what the networks saw, and joins the regions that were found,
// with the home's concepts and the poses as they are now: after mapping, after optimising, after
// editing the concepts. Where a picture that rules ask for cannot be read `lost` says what to do.
[[nodiscard]] Expected<FoundObjects> update_objects(
    home::Home& home, const objects::ObjectRules& rules,
    const std::shared_ptr<LostPictures>& lost = nullptr);

// The poses of all frames that the largest component of the map places, walk by walk in the order
// of time, or of those of one walk: along the key-frames that they hang on and, where the map's
// settings adjust the bundle, as the key-frames around and the motion of a hand say
// (mapping::frame_poses, mapping::smooth_frames).
[[nodiscard]] Expected<recording::Trajectory> stored_trajectory(
    const home::Home& home, std::optional<home::RecordingId> walk = std::nullopt);

}  // namespace roomwise::pipeline
