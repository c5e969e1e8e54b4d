#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "roomwise/base/progress.h"
#include "roomwise/mapping/backend/map_solver.h"
#include "roomwise/mapping/backend/up_measurement.h"
#include "roomwise/mapping/bundle/bundle_adjustment.h"
#include "roomwise/mapping/bundle/landmarks.h"
#include "roomwise/mapping/frontend/mapper.h"

namespace roomwise::mapping {

struct RefinementOptions {
  LandmarkOptions landmarks;
  BundleOptions bundle;
  motion::ResidualModel residuals;
  double max_sigmas = 6;  // a view further from its landmark is culled
  int rounds = 2;         // of adjusting and culling
  // Level surfaces and walls tell where up is, which holds the roll and pitch of key-frames.
  bool uses_gravity = true;
  UpMeasurementOptions up;
  // A map of more is adjusted in windows (refinement_windows.h) of a third as many, with as many
  // around them held: what features, landmarks and equations take in memory is bounded by it, about
  // 0.35 MB each.
  std::size_t max_keyframes = 1000;

  [[nodiscard]] Expected<void> validate() const;
};

// One of the walks that a map was made from.
struct RefinedWalk {
  KeyframeId first_keyframe = 0;  // the others down to the next walk's first are its, too
  std::span<const Frame> frames;  // in the order of time
  geometry::PinholeCamera camera;
  double readout_s =
      0;  // what is known of its rolling shutter; that of the last walk is found anew
};

// What landmarks are found by in key-frames, whose ids ascend; in their order.
using FindFeatures =
    std::function<Expected<std::vector<KeyframeFeatures>>(std::span<const KeyframeId>)>;

// What a map is refined from, besides its solution.
struct RefinementInputs {
  std::span<const PoseGraphEdge> edges;  // those that the solution was found from
  FindFeatures features;                 // of those that are needed next
  std::vector<bool> has_landmarks;       // by key-frame id: whether landmarks are looked for in it
  std::span<const TimestampNs> keyframe_times;  // by key-frame id
  std::span<const RefinedWalk> walks;           // in the order of their key-frames, at least one
};

struct MapRefinement {
  // By key-frame id; the first of each component stays where it was.
  std::vector<geometry::RigidTransform> world_from_keyframe;
  std::size_t landmarks = 0;
  std::size_t views = 0;
  // Of the last walk's rolling shutter; nothing where no frame is near enough in time to another
  // for the camera's motion to be known.
  std::optional<double> readout_s;
  // Key-frames at which up as the device felt it was dropped, since what is level contradicts it.
  std::size_t contradicted_gravity = 0;
  double rms_px = 0;  // of the views: see BundleReport
  int iterations = 0;
  geometry::Termination termination = geometry::Termination::kConverged;  // of the last round
};

// Bundle adjustment of a solved map: landmarks that covisible key-frames see, with depth as
// disparity, together with the edges of the pose graph (without those that contradict it), which
// hold what bare walls tell. What is level and what stands upright holds the key-frames' tilt: how
// a map bends along the vertical adds up from one to the next, and no landmark tells of it (as
// floors do in Koide et al.'s hdl_graph_slam, 2019). The readout time of a rolling shutter is found
// with the rest; edges, whose views were aligned as if exposed at once, are believed less the more
// the motions of their two key-frames differ.
//
// A large map (RefinementOptions::max_keyframes) is adjusted in windows. First each by itself, with
// nothing around it held: it measures the edges of its key-frames anew, and the pose graph of these
// says where all are (as Ni, Steedly and Dellaert join submaps, "Tectonic SAM", 2007). Then each
// with all else held, which mends the borders. The readout time is the mean of what the windows
// find by themselves, by how many views tell of it. In windows without landmarks nothing is
// measured anew: their key-frames stay where the graph says, which bends them by their edges as
// adjusting the map whole would (the far parts of a map that a further walk joined, say).
[[nodiscard]] Expected<MapRefinement> refine_map(const MapSolution& solution,
                                                 const RefinementInputs& inputs,
                                                 const MapSolverOptions& solver,
                                                 const RefinementOptions& options,
                                                 Progress& progress);

}  // namespace roomwise::mapping
