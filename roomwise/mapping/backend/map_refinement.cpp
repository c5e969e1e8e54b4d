#include "roomwise/mapping/backend/map_refinement.h"

#include <algorithm>

#include "roomwise/mapping/backend/frame_poses.h"

namespace roomwise::mapping {
namespace {

using geometry::RigidTransform;
using geometry::Vector6d;

// Key-frames in the order of a bundle's cameras: first the first of each component, which are held.
std::vector<std::uint32_t> places_of(const MapSolution& solution) {
  std::vector<std::uint32_t> places(solution.component.size());
  std::vector<bool> is_met(solution.components, false);
  std::uint32_t next_held = 0;
  auto next = static_cast<std::uint32_t>(solution.components);
  for (std::size_t id = 0; id < places.size(); ++id) {
    const bool is_first = !is_met[solution.component[id]];
    is_met[solution.component[id]] = true;
    places[id] = is_first ? next_held++ : next++;
  }
  return places;
}

// The edges that agree with the solution.
std::vector<PoseGraphEdge> agreeing_edges(const MapSolution& solution,
                                          std::span<const PoseGraphEdge> edges,
                                          const MapSolverOptions& solver) {
  PoseGraph graph;
  for (std::size_t id = 0; id < solution.world_from_keyframe.size(); ++id)
    graph.world_from_node[id] = solution.world_from_keyframe[id];
  std::vector<PoseGraphEdge> agreeing =
      demote_inconsistent_odometry(solution.world_from_keyframe.size(), edges);
  std::erase_if(agreeing, [&](const PoseGraphEdge& edge) {
    return is_contradicted(graph, edge, solver) ||
           solution.component[edge.from] != solution.component[edge.to];
  });
  return agreeing;
}

// How unsure the edges are of which views were taken by a rolling shutter: the top and the bottom
// of a picture stand half a readout's motion from where the middle is.
PoseGraphEdge with_shutter_motion(const PoseGraphEdge& edge,
                                  std::span<const Vector6d> readout_motions) {
  constexpr double kShare = 0.5;     // of a picture's distortion that goes into the pose
  constexpr double kDistance_m = 1;  // at which a turn passes for a shift
  const Vector6d difference = readout_motions[edge.from] - readout_motions[edge.to];
  const double angle = kShare * difference.head<3>().norm();
  PoseGraphEdge loose = edge;
  loose.information = motion::with_systematic_error(
      edge.information, kDistance_m * angle + kShare * difference.tail<3>().norm(), 0.5 * angle);
  return loose;
}

// One map on its way.
class Refiner {
 public:
  Refiner(const MapSolution& solution, const RefinementInputs& inputs,
          const MapSolverOptions& solver, const RefinementOptions& options, Progress& progress)
      : inputs_(inputs),
        options_(options),
        progress_(progress),
        component_(solution.component),
        places_(places_of(solution)),
        edges_(agreeing_edges(solution, inputs.edges, solver)),
        poses_(solution.world_from_keyframe) {
    bundle_.models.clear();
    for (const RefinedWalk& walk : inputs.walks)
      bundle_.models.push_back({walk.camera, options.residuals, walk.readout_s});
    bundle_.models.back().readout_s = 0;
    bundle_.fixed_cameras = solution.components;
    bundle_.cameras.resize(poses_.size());
    const auto pairs =
        covisible_keyframes(inputs.features, poses_, solution.component, options.landmarks);
    bundle_.landmarks = find_landmarks(inputs.features, poses_, pairs, options.landmarks);
    for (Landmark& landmark : bundle_.landmarks)
      for (LandmarkView& view : landmark.views) view.camera = places_[view.camera];
  }

  Expected<MapRefinement> run() {
    // At first the poses still err, and what is wrong is further off than that.
    constexpr double kFirstSigmas = 10;
    MapRefinement refinement;
    int done = 0;
    const auto go_on = [&] {
      progress_.advance(static_cast<std::uint64_t>(done++), "");
      return progress_.check("landmarks were adjusted");
    };
    for (int round = 0; round < options_.rounds; ++round) {
      set_bundle_cameras();
      cull_views(bundle_, (round == 0 ? kFirstSigmas : 1) * options_.max_sigmas);
      ROOMWISE_TRY(const BundleReport report, adjust_bundle(bundle_, options_.bundle, go_on));
      refinement.iterations += report.solver.iterations;
      refinement.termination = report.solver.termination;
      refinement.rms_px = report.rms_px;
      for (std::size_t id = 0; id < poses_.size(); ++id)
        poses_[id] = bundle_.cameras[places_[id]].world_from_camera;
    }
    refinement.world_from_keyframe = poses_;
    if (knows_velocity_) refinement.readout_s = bundle_.models.back().readout_s;
    refinement.landmarks = bundle_.landmarks.size();
    for (const Landmark& landmark : bundle_.landmarks) refinement.views += landmark.views.size();
    return refinement;
  }

 private:
  // The cameras as the poses are now, with the motions that follow from them.
  void set_bundle_cameras() {
    const SolvedKeyframes keyframes{poses_, inputs_.keyframe_times, component_};
    std::vector<Vector6d> readout_motions;  // by key-frame id: while its picture was read out
    knows_velocity_ = false;
    for (std::uint32_t i = 0; i < inputs_.walks.size(); ++i) {
      const RefinedWalk& walk = inputs_.walks[i];
      const auto frames = frame_poses(walk.frames, keyframes, edges_);
      const auto of_walk = keyframe_velocities(walk.frames, frames, keyframes);
      const bool is_last = i + 1 == inputs_.walks.size();
      const std::size_t end = is_last ? poses_.size() : inputs_.walks[i + 1].first_keyframe;
      for (std::size_t id = walk.first_keyframe; id < end; ++id) {
        readout_motions.emplace_back(bundle_.models[i].readout_s * of_walk[id]);
        bundle_.cameras[places_[id]] = {poses_[id], of_walk[id], i};
        knows_velocity_ = knows_velocity_ || (is_last && !of_walk[id].isZero());
      }
    }
    bundle_.edges.clear();
    for (const PoseGraphEdge& edge : edges_) {
      PoseGraphEdge& placed =
          bundle_.edges.emplace_back(with_shutter_motion(edge, readout_motions));
      placed.from = places_[edge.from];
      placed.to = places_[edge.to];
    }
  }

  const RefinementInputs& inputs_;
  const RefinementOptions& options_;
  Progress& progress_;
  std::span<const std::size_t> component_;  // by key-frame id
  bool knows_velocity_ = false;             // of any key-frame of the last walk
  std::vector<std::uint32_t> places_;       // by key-frame id: its camera's place in the bundle
  std::vector<PoseGraphEdge> edges_;
  std::vector<RigidTransform> poses_;  // by key-frame id
  Bundle bundle_;
};

}  // namespace

Expected<void> RefinementOptions::validate() const {
  ROOMWISE_CHECK_OK(landmarks.validate());
  ROOMWISE_CHECK_OK(bundle.validate());
  if (!(residuals.pixel_sigma_px > 0) || !(residuals.disparity_sigma_px > 0) ||
      !(residuals.focal_baseline_px_m > 0)) {
    return fail(
        "pixel_sigma_px = {}, disparity_sigma_px = {} and focal_baseline_px_m = {} must be "
        "positive",
        residuals.pixel_sigma_px, residuals.disparity_sigma_px, residuals.focal_baseline_px_m);
  }
  if (!(max_sigmas > 0)) return fail("max_sigmas = {} must be positive", max_sigmas);
  if (rounds < 1) return fail("rounds = {} must be at least 1", rounds);
  return {};
}

Expected<MapRefinement> refine_map(const MapSolution& solution, const RefinementInputs& inputs,
                                   const MapSolverOptions& solver, const RefinementOptions& options,
                                   Progress& progress) {
  ROOMWISE_CHECK_OK(options.validate());
  const std::size_t count = solution.world_from_keyframe.size();
  if (inputs.features.size() != count || inputs.keyframe_times.size() != count) {
    return fail("features of {} and times of {} key-frames for a map of {}", inputs.features.size(),
                inputs.keyframe_times.size(), count);
  }
  if (inputs.walks.empty() || inputs.walks.front().first_keyframe != 0 ||
      !std::ranges::is_sorted(inputs.walks, {}, &RefinedWalk::first_keyframe)) {
    return fail("the key-frames of {} walks do not follow each other from 0 on",
                inputs.walks.size());
  }
  if (count == 0) return MapRefinement{};
  progress.begin("adjusting landmarks",
                 static_cast<std::uint64_t>(options.rounds * options.bundle.max_iterations));
  auto refinement = Refiner(solution, inputs, solver, options, progress).run();
  progress.end();
  return refinement;
}

}  // namespace roomwise::mapping
