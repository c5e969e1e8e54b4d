#include "roomwise/mapping/backend/map_refinement.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>

#include "roomwise/mapping/backend/frame_poses.h"
#include "roomwise/mapping/backend/grounds.h"
#include "roomwise/mapping/backend/refinement_windows.h"

namespace roomwise::mapping {
namespace {

using geometry::RigidTransform;
using geometry::Vector6d;

// By key-frame id: whether it is the first of its component, which is held.
std::vector<bool> firsts_of_components(const MapSolution& solution) {
  std::vector<bool> is_met(solution.components, false);
  std::vector<bool> is_first;
  for (const std::size_t component : solution.component) {
    is_first.push_back(!is_met[component]);
    is_met[component] = true;
  }
  return is_first;
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

// The edge with its covariance inflated by what a rolling shutter displaces: the top and the bottom
// of a picture are taken half a readout's motion (given for both key-frames) from its middle.
PoseGraphEdge with_shutter_motion(const PoseGraphEdge& edge, const Vector6d& from,
                                  const Vector6d& to) {
  constexpr double kShare = 0.5;     // of a picture's distortion that goes into the pose
  constexpr double kDistance_m = 1;  // at which a turn passes for a shift
  const Vector6d difference = from - to;
  const double angle = kShare * difference.head<3>().norm();
  PoseGraphEdge loose = edge;
  loose.information = motion::with_systematic_error(
      edge.information, kDistance_m * angle + kShare * difference.tail<3>().norm(), 0.5 * angle);
  return loose;
}

// All of a map that is small enough, else windows of it.
std::vector<RefinementWindow> windows_of(const MapSolution& solution,
                                         const RefinementOptions& options) {
  const std::size_t count = solution.world_from_keyframe.size();
  if (count > options.max_keyframes) {
    const std::size_t third = options.max_keyframes / 3;
    return refinement_windows(solution.world_from_keyframe, solution.component, third, third);
  }
  RefinementWindow all;
  for (KeyframeId id = 0; id < count; ++id) all.own.push_back(id);
  return {all};
}

// Which key-frames are the cameras of a window's bundle: those that are held come first.
struct BundleCameras {
  std::vector<KeyframeId> keyframe;           // by place
  std::map<KeyframeId, std::uint32_t> place;  // of those that are cameras
  std::size_t held = 0;

  [[nodiscard]] bool has(KeyframeId id) const { return place.contains(id); }
};

// At first the poses still err, and what is wrong is so many times further off than in the end.
constexpr double kFirstRoundFactor = 10;

// By key-frame id: which edges lead to it or from it, by their numbers.
std::vector<std::vector<std::size_t>> edges_by_keyframe(std::size_t keyframes,
                                                        std::span<const PoseGraphEdge> edges) {
  std::vector<std::vector<std::size_t>> of_keyframe(keyframes);
  for (std::size_t i = 0; i < edges.size(); ++i) {
    of_keyframe[edges[i].from].push_back(i);
    of_keyframe[edges[i].to].push_back(i);
  }
  return of_keyframe;
}

// What adjusting one window came to.
struct AdjustedWindow {
  std::size_t landmarks = 0;  // those that it has from no other window
  std::size_t views = 0;      // of its own key-frames
  double rms_px = 0;
  int iterations = 0;
  geometry::Termination termination = geometry::Termination::kConverged;
  double readout_s = 0;
  std::size_t readout_observations = 0;  // of the last walk's key-frames whose motion is known
};

// One map on its way.
class Refiner {
 public:
  Refiner(const MapSolution& solution, const RefinementInputs& inputs,
          const MapSolverOptions& solver, const RefinementOptions& options, Progress& progress)
      : inputs_(inputs),
        options_(options),
        progress_(progress),
        component_(solution.component),
        is_first_(firsts_of_components(solution)),
        edges_(agreeing_edges(solution, inputs.edges, solver)),
        edges_of_(edges_by_keyframe(solution.world_from_keyframe.size(), edges_)),
        poses_(solution.world_from_keyframe),
        windows_(windows_of(solution, options)),
        graph_options_(solver.graph),
        grounds_(options.up, solution.component) {
    for (std::uint32_t i = 0; i < inputs.walks.size(); ++i) {
      const bool is_last = i + 1 == inputs.walks.size();
      walk_of_.resize(is_last ? poses_.size() : inputs.walks[i + 1].first_keyframe, i);
      if (options.uses_gravity) add_gravity(inputs.walks[i].frames);
    }
  }

  Expected<MapRefinement> run() {
    const bool is_whole = windows_.size() == 1;
    iterations_of_window_ =
        static_cast<std::uint64_t>(options_.rounds * options_.bundle.max_iterations);
    progress_.begin("adjusting landmarks",
                    (is_whole ? 1 : 2) * windows_.size() * iterations_of_window_);
    BundleOptions bundle = options_.bundle;
    MapRefinement refinement;
    if (!is_whole) {
      ROOMWISE_RETURN_IF_ERROR(join_windows(refinement));
      bundle.readout_sigma_s = 0;  // it is found once
    }
    ROOMWISE_TRY(const auto adjusted, sweep(bundle, /*has_free_boundary=*/false));
    if (is_whole) readout_s_ = adjusted.front().readout_s;
    sum_up(adjusted, refinement);
    refinement.world_from_keyframe = poses_;
    refinement.contradicted_gravity = grounds_.contradicted();
    if (knows_velocity_) refinement.readout_s = readout_s_;
    return refinement;
  }

 private:
  // Each window by itself measures anew how its key-frames lie to each other; the graph of these
  // measurements says where all are. So what drifted is spread over all, and ends at no border.
  Expected<void> join_windows(MapRefinement& refinement) {
    measured_ = edges_;
    is_measured_.assign(edges_.size(), false);
    ROOMWISE_TRY(const auto floated, sweep(options_.bundle, /*has_free_boundary=*/true));
    readout_s_ = mean_readout_s(floated);
    sum_up(floated, refinement);
    PoseGraph graph;
    graph.edges = std::move(measured_);
    std::vector<KeyframeId> all;
    for (KeyframeId id = 0; id < poses_.size(); ++id) {
      graph.world_from_node[id] = poses_[id];
      all.push_back(id);
    }
    const double kernel_sigmas = kFirstRoundFactor * options_.bundle.kernel_sigmas;
    for (const Ground& ground : grounds_.under(all, poses_, poses_.size(), kernel_sigmas)) {
      graph.world_from_node[ground.edges.front().from] = ground.world_from_ground;
      std::ranges::copy(ground.edges, std::back_inserter(graph.edges));
    }
    PoseGraphOptions plain = graph_options_;
    plain.relaxes_start = false;
    ROOMWISE_RETURN_IF_ERROR(optimize(graph, plain));
    for (KeyframeId id = 0; id < poses_.size(); ++id) poses_[id] = graph.world_from_node[id];
    return {};
  }

  Expected<std::vector<AdjustedWindow>> sweep(const BundleOptions& options,
                                              bool has_free_boundary) {
    update_velocities();
    std::vector<AdjustedWindow> swept;
    for (const RefinementWindow& window : windows_) {
      ROOMWISE_TRY(swept.emplace_back(), adjust(window, options, has_free_boundary));
      done_ = ++windows_done_ * iterations_of_window_;
    }
    return swept;
  }

  static double mean_readout_s(const std::vector<AdjustedWindow>& windows) {
    double sum = 0, views = 0;
    for (const AdjustedWindow& window : windows) {
      sum += static_cast<double>(window.readout_observations) * window.readout_s;
      views += static_cast<double>(window.readout_observations);
    }
    return views > 0 ? sum / views : 0;
  }

  static void sum_up(const std::vector<AdjustedWindow>& windows, MapRefinement& refinement) {
    double squares = 0;
    refinement.landmarks = refinement.views = 0;
    for (const AdjustedWindow& window : windows) {
      refinement.landmarks += window.landmarks;
      refinement.views += window.views;
      squares += window.rms_px * window.rms_px * static_cast<double>(window.views);
      refinement.iterations += window.iterations;
      if (window.iterations > 0) refinement.termination = window.termination;
    }
    if (refinement.views > 0)
      refinement.rms_px = std::sqrt(squares / static_cast<double>(refinement.views));
  }

  // What the devices felt in key-frames.
  void add_gravity(std::span<const Frame> frames) {
    for (const Frame& frame : frames) {
      if (!frame.place || !frame.motion || !frame.motion->device.up_camera) continue;
      const KeyframeId id = frame.place->keyframe;
      if (inputs_.keyframe_times[id] == frame.timestamp_ns)
        grounds_.add_gravity(id, *frame.motion->device.up_camera);
    }
  }

  // How the cameras move, by the poses as they are now.
  void update_velocities() {
    const SolvedKeyframes keyframes{poses_, inputs_.keyframe_times, component_};
    velocities_.clear();
    turning_rad_s_.clear();
    knows_velocity_ = false;
    for (std::uint32_t i = 0; i < inputs_.walks.size(); ++i) {
      const RefinedWalk& walk = inputs_.walks[i];
      const auto frames = frame_poses(walk.frames, keyframes, edges_);
      const auto of_walk = keyframe_velocities(walk.frames, frames, keyframes);
      const auto turning = keyframe_turning(walk.frames, frames, keyframes);
      for (KeyframeId id = walk.first_keyframe; id < poses_.size() && walk_of_[id] == i; ++id) {
        velocities_.push_back(of_walk[id]);
        turning_rad_s_.push_back(turning[id]);
        const bool is_last = i + 1 == inputs_.walks.size();
        knows_velocity_ = knows_velocity_ || (is_last && !of_walk[id].isZero());
      }
    }
  }

  // With all else held; or, with a free boundary, those around as free as its own, for no more than
  // to measure its edges anew.
  [[nodiscard]] Expected<AdjustedWindow> adjust(const RefinementWindow& window,
                                                const BundleOptions& options,
                                                bool has_free_boundary) {
    const auto has_landmarks = [&](KeyframeId id) { return inputs_.has_landmarks[id]; };
    if (windows_.size() > 1 && std::ranges::none_of(window.own, has_landmarks)) return {};
    const BundleCameras places = places_of(window, has_free_boundary);
    std::vector<RigidTransform> before;
    for (const KeyframeId id : places.keyframe) before.push_back(poses_[id]);
    Bundle bundle;
    bundle.models.clear();
    for (const RefinedWalk& walk : inputs_.walks)
      bundle.models.push_back({walk.camera, options_.residuals, walk.readout_s});
    bundle.models.back().readout_s = readout_s_;
    bundle.fixed_cameras = places.held;
    std::vector<KeyframeId> seen;
    std::ranges::merge(window.own, window.around, std::back_inserter(seen));
    ROOMWISE_TRY(const std::vector<KeyframeFeatures> features, features_of(seen));
    bundle.landmarks = landmarks_of(window, places, seen, features);
    if (options_.uses_gravity) grounds_.measure(seen, window.own, features, poses_, turning_rad_s_);

    AdjustedWindow adjusted;
    const auto go_on = [&] {
      progress_.advance(done_++, "");
      return progress_.check("landmarks were adjusted");
    };
    for (int round = 0; round < options_.rounds; ++round) {
      // In windows the velocities stay as they were when the sweep began: all frames would be asked
      // anew.
      if (round > 0 && windows_.size() == 1) update_velocities();
      const double widened = round == 0 ? kFirstRoundFactor : 1;
      set_cameras(window, places, has_free_boundary, bundle);
      add_gravity_nodes(places, widened * options_.bundle.kernel_sigmas, bundle);
      cull_views(bundle, widened * options_.max_sigmas);
      ROOMWISE_TRY(const BundleReport report, adjust_bundle(bundle, options, go_on));
      adjusted.iterations += report.solver.iterations;
      adjusted.termination = report.solver.termination;
      adjusted.rms_px = report.rms_px;
      for (std::size_t i = places.held; i < places.keyframe.size(); ++i)
        poses_[places.keyframe[i]] = bundle.cameras[i].world_from_camera;
    }
    if (has_free_boundary) {
      measure_edges(window, places);
      for (std::size_t i = 0; i < before.size(); ++i) poses_[places.keyframe[i]] = before[i];
    }
    adjusted.readout_s = bundle.models.back().readout_s;
    count(window, places, bundle, adjusted);
    return adjusted;
  }

  // The edges of the window's own key-frames as it lies now; the first window to say so counts.
  void measure_edges(const RefinementWindow& window, const BundleCameras& places) {
    for (const std::size_t i : edges_at(window.own)) {
      const auto& [from, to] = std::pair(edges_[i].from, edges_[i].to);
      if (is_measured_[i] || !places.has(from) || !places.has(to)) continue;
      measured_[i].from_from_to = poses_[from].inverse() * poses_[to];
      is_measured_[i] = true;
    }
  }

  // Which edges lead to these key-frames or from them; numbers ascend.
  [[nodiscard]] std::vector<std::size_t> edges_at(std::span<const KeyframeId> ids) const {
    std::vector<std::size_t> numbers;
    for (const KeyframeId id : ids) std::ranges::copy(edges_of_[id], std::back_inserter(numbers));
    std::ranges::sort(numbers);
    const auto twice = std::ranges::unique(numbers);
    numbers.erase(twice.begin(), twice.end());
    return numbers;
  }

  static bool is_own(const RefinementWindow& window, KeyframeId id) {
    return std::ranges::binary_search(window.own, id);
  }

  // Its own key-frames and those around; where it does not float also those that edges lead to.
  [[nodiscard]] BundleCameras places_of(const RefinementWindow& window,
                                        bool has_free_boundary) const {
    std::map<KeyframeId, bool> may_move;  // of those that are there
    for (const KeyframeId id : window.around) may_move[id] = has_free_boundary;
    for (const KeyframeId id : window.own) may_move[id] = true;
    if (has_free_boundary) {
      may_move[window.own.front()] = false;
    } else {
      for (const std::size_t edge : edges_at(window.own)) {
        may_move.try_emplace(edges_[edge].from, false);
        may_move.try_emplace(edges_[edge].to, false);
      }
      for (auto& [id, moves] : may_move) moves = moves && !is_first_[id];
    }
    BundleCameras places;
    for (const bool moving : {false, true}) {
      for (const auto& [id, moves] : may_move) {
        if (moves != moving) continue;
        places.place[id] = static_cast<std::uint32_t>(places.keyframe.size());
        places.keyframe.push_back(id);
        places.held += moves ? 0 : 1;
      }
    }
    return places;
  }

  // Landmarks that key-frames of the window see; those that none of its own sees move nothing.
  [[nodiscard]] std::vector<Landmark> landmarks_of(
      const RefinementWindow& window, const BundleCameras& places, std::span<const KeyframeId> ids,
      std::span<const KeyframeFeatures> features) const {
    std::vector<RigidTransform> poses;
    std::vector<std::size_t> components;
    std::vector<bool> of_window;
    for (const KeyframeId id : ids) {
      poses.push_back(poses_[id]);
      components.push_back(component_[id]);
      of_window.push_back(is_own(window, id));
    }
    auto pairs = covisible_keyframes(features, poses, components, options_.landmarks);
    std::erase_if(pairs,
                  [&](const Covisible& pair) { return !of_window[pair.a] && !of_window[pair.b]; });
    auto landmarks = find_landmarks(features, poses, pairs, options_.landmarks);
    for (Landmark& landmark : landmarks)
      for (LandmarkView& view : landmark.views) view.camera = places.place.at(ids[view.camera]);
    return landmarks;
  }

  // Those in which nothing is looked for are empty.
  [[nodiscard]] Expected<std::vector<KeyframeFeatures>> features_of(
      std::span<const KeyframeId> ids) const {
    std::vector<KeyframeId> asked;
    std::ranges::copy_if(ids, std::back_inserter(asked),
                         [&](KeyframeId id) { return inputs_.has_landmarks[id]; });
    ROOMWISE_TRY(auto found, inputs_.features(asked));
    if (found.size() != asked.size())
      return fail("features of {} key-frames where {} were asked for", found.size(), asked.size());
    if (asked.size() == ids.size()) return found;
    std::vector<KeyframeFeatures> features(ids.size());
    for (std::size_t i = 0, next = 0; i < ids.size(); ++i)
      if (inputs_.has_landmarks[ids[i]]) features[i] = std::move(found[next++]);
    return features;
  }

  // The cameras as the poses are now, with the edges between those of which one moves.
  void set_cameras(const RefinementWindow& window, const BundleCameras& places,
                   bool has_free_boundary, Bundle& bundle) {
    bundle.cameras.clear();
    for (const KeyframeId id : places.keyframe)
      bundle.cameras.push_back({poses_[id], velocities_[id], walk_of_[id]});
    const auto while_read_out = [&](KeyframeId id) -> Vector6d {
      return bundle.models[walk_of_[id]].readout_s * velocities_[id];
    };
    bundle.edges.clear();
    for (const std::size_t number : edges_at(has_free_boundary ? places.keyframe : window.own)) {
      const PoseGraphEdge& edge = edges_[number];
      if (!places.has(edge.from) || !places.has(edge.to)) continue;
      PoseGraphEdge& placed = bundle.edges.emplace_back(
          with_shutter_motion(edge, while_read_out(edge.from), while_read_out(edge.to)));
      placed.from = places.place.at(edge.from);
      placed.to = places.place.at(edge.to);
    }
  }

  // The ground is one camera more, which sees nothing.
  void add_gravity_nodes(const BundleCameras& places, double kernel_sigmas, Bundle& bundle) const {
    const NodeId first = bundle.cameras.size();
    for (Ground& ground : grounds_.under(places.keyframe, poses_, first, kernel_sigmas)) {
      bundle.cameras.push_back({ground.world_from_ground});
      for (PoseGraphEdge& edge : ground.edges) {
        edge.to = places.place.at(edge.to);
        bundle.edges.push_back(edge);
      }
    }
  }

  void count(const RefinementWindow& window, const BundleCameras& places, const Bundle& bundle,
             AdjustedWindow& adjusted) const {
    for (const Landmark& landmark : bundle.landmarks) {
      KeyframeId first = poses_.size();
      for (const LandmarkView& view : landmark.views) {
        const KeyframeId id = places.keyframe[view.camera];
        first = std::min(first, id);
        adjusted.views += is_own(window, id) ? 1 : 0;
        const bool tells = walk_of_[id] + 1 == inputs_.walks.size() && !velocities_[id].isZero();
        adjusted.readout_observations += tells ? 1 : 0;
      }
      adjusted.landmarks += is_own(window, first) ? 1 : 0;
    }
  }

  const RefinementInputs& inputs_;
  const RefinementOptions& options_;
  Progress& progress_;
  std::span<const std::size_t> component_;  // by key-frame id
  std::vector<bool> is_first_;              // likewise: of its component
  std::vector<std::uint32_t> walk_of_;      // likewise
  std::vector<PoseGraphEdge> edges_;
  std::vector<std::vector<std::size_t>> edges_of_;  // by key-frame id
  std::vector<RigidTransform> poses_;               // by key-frame id
  std::vector<RefinementWindow> windows_;
  PoseGraphOptions graph_options_;
  Grounds grounds_;
  std::vector<PoseGraphEdge> measured_;  // edges_ as windows measure them
  std::vector<bool> is_measured_;
  std::vector<Vector6d> velocities_;                           // by key-frame id
  std::vector<std::optional<Eigen::Vector3d>> turning_rad_s_;  // likewise, where it is known
  bool knows_velocity_ = false;                                // of any key-frame of the last walk
  double readout_s_ = 0;                                       // of the last walk
  std::uint64_t done_ = 0, windows_done_ = 0;
  std::uint64_t iterations_of_window_ = 0;
};

}  // namespace

Expected<void> RefinementOptions::validate() const {
  ROOMWISE_RETURN_IF_ERROR(landmarks.validate());
  ROOMWISE_RETURN_IF_ERROR(bundle.validate());
  ROOMWISE_RETURN_IF_ERROR(up.validate());
  if (!(residuals.pixel_sigma_px > 0) || !(residuals.disparity_sigma_px > 0) ||
      !(residuals.focal_baseline_px_m > 0)) {
    return fail(
        "pixel_sigma_px = {}, disparity_sigma_px = {} and focal_baseline_px_m = {} must be "
        "positive",
        residuals.pixel_sigma_px, residuals.disparity_sigma_px, residuals.focal_baseline_px_m);
  }
  if (!(max_sigmas > 0)) return fail("max_sigmas = {} must be positive", max_sigmas);
  if (rounds < 1) return fail("rounds = {} must be at least 1", rounds);
  if (max_keyframes < 3) return fail("max_keyframes = {} must be at least 3", max_keyframes);
  return {};
}

Expected<MapRefinement> refine_map(const MapSolution& solution, const RefinementInputs& inputs,
                                   const MapSolverOptions& solver, const RefinementOptions& options,
                                   Progress& progress) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  const std::size_t count = solution.world_from_keyframe.size();
  if (inputs.has_landmarks.size() != count || inputs.keyframe_times.size() != count) {
    return fail("landmarks are looked for in {} and times known of {} key-frames for a map of {}",
                inputs.has_landmarks.size(), inputs.keyframe_times.size(), count);
  }
  if (inputs.walks.empty() || inputs.walks.front().first_keyframe != 0 ||
      !std::ranges::is_sorted(inputs.walks, {}, &RefinedWalk::first_keyframe)) {
    return fail("the key-frames of {} walks do not follow each other from 0 on",
                inputs.walks.size());
  }
  if (count == 0) return MapRefinement{};
  auto refinement = Refiner(solution, inputs, solver, options, progress).run();
  progress.end();
  return refinement;
}

}  // namespace roomwise::mapping
