#include "roomwise/pipeline/stored/stored_map.h"

#include "roomwise/pipeline/stored/stored_edits.h"

#include "roomwise/mapping/backend/frame_poses.h"
#include "roomwise/mapping/backend/frame_smoothing.h"
#include "roomwise/mapping/backend/walk_joins.h"
#include "roomwise/mapping/localization/localization.h"
#include "roomwise/pipeline/stored/compared_views.h"
#include "roomwise/pipeline/stored/mapper_storage.h"

namespace roomwise::pipeline {
namespace {

std::vector<TimestampNs> times_of(std::span<const home::Keyframe> keyframes) {
  std::vector<TimestampNs> times;
  for (const home::Keyframe& keyframe : keyframes) times.push_back(keyframe.timestamp_ns);
  return times;
}

Expected<mapping::MapRefinement> refine(const home::Home& home,
                                        std::span<const home::Keyframe> keyframes,
                                        std::span<const mapping::PoseGraphEdge> edges,
                                        const mapping::MapSolution& solution,
                                        const mapping::FindFeatures& find_features,
                                        const std::vector<bool>& has_landmarks,
                                        const MapSettings& settings, Progress& progress) {
  ROOMWISE_TRY(const auto recordings, home.recordings());
  std::vector<std::vector<scene::Frame>> frames;
  for (const home::StoredRecording& recording : recordings) {
    ROOMWISE_TRY(frames.emplace_back(), home.frames(recording.id));
  }
  std::vector<mapping::RefinedWalk> walks;
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    walks.push_back({first_keyframe_of(keyframes, recordings[i].id), frames[i],
                     recordings[i].recording.camera, recordings[i].readout_s.value_or(0)});
  }
  const std::vector<TimestampNs> times_ns = times_of(keyframes);
  return mapping::refine_map(solution, {edges, find_features, has_landmarks, times_ns, walks},
                             settings.solver, settings.refinement, progress);
}

// What is solved when a walk, whose first key-frame this is, joins a map that was solved before: of
// the edges between earlier key-frames of one component those that the map was found from, and they
// say where it is.
std::vector<mapping::PoseGraphEdge> edges_to_join(std::span<const home::Keyframe> keyframes,
                                                  std::span<const mapping::PoseGraphEdge> measured,
                                                  home::KeyframeId first_of_walk,
                                                  const mapping::MapSolverOptions& options) {
  mapping::PoseGraph stored;
  for (const home::Keyframe& keyframe : keyframes)
    stored.world_from_node[keyframe.id] = keyframe.pose.world_from_keyframe;
  const auto doubted = mapping::demote_inconsistent_odometry(keyframes.size(), measured);
  std::vector<mapping::PoseGraphEdge> edges;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    mapping::PoseGraphEdge edge = measured[i];
    const home::KeyframePose& from = keyframes[edge.from].pose;
    const home::KeyframePose& to = keyframes[edge.to].pose;
    if (std::max(edge.from, edge.to) < first_of_walk && from.component == to.component) {
      if (mapping::is_contradicted(stored, doubted[i], options)) continue;
      edge.from_from_to = from.world_from_keyframe.inverse() * to.world_from_keyframe;
    }
    edges.push_back(edge);
  }
  return edges;
}

// By key-frame: whether landmarks are looked for in it. Of a walk that joins its own and those that
// may show the same, as the localiser takes it; of a map that is solved anew all.
std::vector<bool> keyframes_to_adjust(std::span<const home::Keyframe> keyframes,
                                      const home::StoredRecording& last,
                                      const mapping::MapSolution& solution) {
  std::vector<bool> wanted(keyframes.size(), last.finished);
  if (last.finished) return wanted;
  const home::KeyframeId first = first_keyframe_of(keyframes, last.id);
  const mapping::LocalizerOptions near;
  const auto& poses = solution.world_from_keyframe;
  for (home::KeyframeId id = 0; id < keyframes.size(); ++id) {
    for (home::KeyframeId own = first; own < keyframes.size() && !wanted[id]; ++own) {
      if (solution.component[own] != solution.component[id]) continue;
      const geometry::RigidTransform apart = poses[own].inverse() * poses[id];
      wanted[id] = apart.distance_m() <= near.place_m && apart.angle_rad() <= near.place_rad;
    }
  }
  return wanted;
}

// By key-frame: its component, as it is stored; a walk that is not finished is a part of its own.
std::vector<std::size_t> parts_of_map(std::span<const home::Keyframe> keyframes,
                                      std::span<const home::StoredRecording> recordings) {
  std::size_t components = 0;
  for (const home::Keyframe& keyframe : keyframes)
    components = std::max<std::size_t>(components, keyframe.pose.component + 1);
  std::vector<std::size_t> parts;
  for (const home::Keyframe& keyframe : keyframes) {
    const bool is_new = keyframe.recording == recordings.back().id && !recordings.back().finished;
    parts.push_back(is_new ? components : keyframe.pose.component);
  }
  return parts;
}

// The map stays the map: the component that has most of its key-frames of before becomes 0, also
// where a walk that joins nothing has more.
void keep_map_first(std::vector<std::size_t>& component,
                    std::span<const home::Keyframe> keyframes_of_before) {
  std::map<std::size_t, std::size_t> of_map;  // how many key-frames, by component
  for (const home::Keyframe& keyframe : keyframes_of_before) {
    if (keyframe.pose.component == 0) ++of_map[component[keyframe.id]];
  }
  if (of_map.empty()) return;
  const std::size_t map =
      std::ranges::max_element(of_map, {}, &std::pair<const std::size_t, std::size_t>::second)
          ->first;
  for (std::size_t& one : component) one = one == map ? 0 : one < map ? one + 1 : one;
}

// Solves the map without joins that too few edges bear out, or that the views contradict where they
// would put them; those edges go from `edges`.
Expected<SolvedMap> solve_joined(const home::Home& home, const std::vector<std::size_t>& part_of,
                                 std::vector<mapping::PoseGraphEdge>& edges,
                                 const mapping::MapSolverOptions& solver) {
  ROOMWISE_TRY(edges, mapping::without_unsupported_joins(part_of, edges, solver));
  ROOMWISE_TRY(ComparedViews views, ComparedViews::of(home));
  const mapping::CompareDepths compare = [&](auto&&... pair) { return views.compare(pair...); };
  // Without the worst, what was bent by it is judged anew.
  while (true) {
    ROOMWISE_TRY(mapping::MapSolution solution, mapping::solve_map(part_of.size(), edges, solver));
    ROOMWISE_TRY(auto kept, mapping::without_contradicted_joins(part_of, edges, solution, compare));
    if (kept.size() == edges.size()) return SolvedMap{std::move(solution), {}, views.unread()};
    edges = std::move(kept);
  }
}

// Where the frames of one recording are, those of other components than the map's left out.
std::vector<mapping::PlacedFrame> place_frames(
    std::span<const scene::Frame> frames,
    std::span<const std::optional<geometry::RigidTransform>> poses,
    std::span<const home::Keyframe> keyframes) {
  std::vector<mapping::PlacedFrame> placed;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    mapping::PlacedFrame& frame = placed.emplace_back();
    frame.timestamp_ns = frames[i].timestamp_ns;
    if (!frames[i].place || keyframes[frames[i].place->keyframe].pose.component != 0) continue;
    frame.world_from_camera = poses[i];
    frame.is_fixed = frame.timestamp_ns == keyframes[frames[i].place->keyframe].timestamp_ns;
  }
  return placed;
}

}  // namespace

Expected<SolvedMap> solve_stored_map(home::Home& home, const MapSettings& settings,
                                     const mapping::FindFeatures& find_features,
                                     Progress& progress) {
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  ROOMWISE_TRY(const auto recordings, home.recordings());
  ROOMWISE_TRY(const auto measured, home.edges());
  if (recordings.empty()) return SolvedMap{};
  std::vector<mapping::PoseGraphEdge> edges = measured;
  if (!recordings.back().finished) {
    edges = edges_to_join(keyframes, measured, first_keyframe_of(keyframes, recordings.back().id),
                          settings.solver);
  }
  ROOMWISE_TRY(SolvedMap solved,
               solve_joined(home, parts_of_map(keyframes, recordings), edges, settings.solver));
  solved.solution.rejected_edges += measured.size() - edges.size();
  keep_map_first(
      solved.solution.component,
      std::span(keyframes).first(recordings.back().finished
                                     ? keyframes.size()
                                     : first_keyframe_of(keyframes, recordings.back().id)));
  if (settings.adjusts_bundle() && !keyframes.empty()) {
    ROOMWISE_TRY(solved.refinement,
                 refine(home, keyframes, edges, solved.solution, find_features,
                        keyframes_to_adjust(keyframes, recordings.back(), solved.solution),
                        settings, progress));
  }
  const auto& solution_poses = solved.refinement ? solved.refinement->world_from_keyframe
                                                 : solved.solution.world_from_keyframe;
  std::map<home::KeyframeId, home::KeyframePose> poses;
  for (std::size_t id = 0; id < keyframes.size(); ++id)
    poses[id] = {solution_poses[id], solved.solution.component[id]};
  ROOMWISE_RETURN_IF_ERROR(home.atomically([&]() -> Expected<void> {
    if (solved.refinement && solved.refinement->readout_s)
      ROOMWISE_RETURN_IF_ERROR(
          home.put_readout(recordings.back().id, *solved.refinement->readout_s));
    return home.replace_poses(poses);
  }));
  return solved;
}

Expected<void> forget_walk(home::Home& home, home::RecordingId walk) {
  const auto in_map = [](const home::Keyframe& one) { return one.pose.component == 0; };
  return home.atomically([&]() -> Expected<void> {
    ROOMWISE_TRY(const auto before, home.keyframes());
    ROOMWISE_RETURN_IF_ERROR(home.forget_learned_rooms());
    ROOMWISE_RETURN_IF_ERROR(take_edits_off(home, walk));
    ROOMWISE_RETURN_IF_ERROR(home.remove_recording(walk));
    ROOMWISE_RETURN_IF_ERROR(home.owe_erasing());
    ROOMWISE_TRY(const auto keyframes, home.keyframes());
    ROOMWISE_TRY(const auto settings, stored_map_settings(home));
    if (keyframes.empty() || !settings) return {};
    ROOMWISE_TRY(const mapping::PoseGraph graph, stored_pose_graph(home, settings->solver));
    std::size_t components = 0;
    auto component_of = mapping::components_by_size(keyframes.size(), graph.edges, components);
    // Where that walk was most of the map, another may be more of a home than what is left.
    if (2 * std::ranges::count_if(keyframes, in_map) >= std::ranges::count_if(before, in_map)) {
      keep_map_first(component_of, keyframes);
    }
    // Each lies in the world of its first key-frame, also where that was another's before.
    std::map<home::KeyframeId, home::KeyframePose> poses;
    std::map<std::size_t, geometry::RigidTransform> first_from_world;
    for (const home::Keyframe& keyframe : keyframes) {
      const std::size_t component = component_of[keyframe.id];
      const auto [anchor, is_first] =
          first_from_world.try_emplace(component, keyframe.pose.world_from_keyframe.inverse());
      poses[keyframe.id] = {is_first ? geometry::RigidTransform::identity()
                                     : anchor->second * keyframe.pose.world_from_keyframe,
                            component};
    }
    ROOMWISE_RETURN_IF_ERROR(home.replace_poses(poses));
    // A picture of another walk that cannot be read must not keep this one from being forgotten.
    return update_objects(home, settings->objects, std::make_shared<LostPictures>(true))
        .map([](const FoundObjects&) {});
  });
}

Expected<mapping::PoseGraph> stored_pose_graph(const home::Home& home,
                                               const mapping::MapSolverOptions& options) {
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  mapping::PoseGraph graph;
  for (const home::Keyframe& keyframe : keyframes) {
    graph.world_from_node[keyframe.id] = keyframe.pose.world_from_keyframe;
  }
  ROOMWISE_TRY(const auto edges, home.edges());
  graph.edges = mapping::demote_inconsistent_odometry(keyframes.size(), edges);
  std::erase_if(graph.edges, [&](const mapping::PoseGraphEdge& edge) {
    return mapping::is_contradicted(graph, edge, options) ||
           keyframes[edge.from].pose.component != keyframes[edge.to].pose.component;
  });
  return graph;
}

Expected<std::map<home::KeyframeId, Eigen::Vector3d>> stored_gravity(
    const home::Home& home, std::span<const home::Keyframe> keyframes) {
  std::map<std::pair<home::RecordingId, std::uint64_t>, Eigen::Vector3d> up_of_frame;
  ROOMWISE_TRY(const auto recordings, home.recordings());
  for (const home::StoredRecording& recording : recordings) {
    ROOMWISE_TRY(const auto frames, home.frames(recording.id));
    for (const scene::Frame& frame : frames) {
      if (frame.motion && frame.motion->device.up_camera)
        up_of_frame[{recording.id, frame.index}] = *frame.motion->device.up_camera;
    }
  }
  std::map<home::KeyframeId, Eigen::Vector3d> up_world;
  for (const home::Keyframe& keyframe : keyframes) {
    const auto up = up_of_frame.find({keyframe.recording, keyframe.frame_index});
    if (up != up_of_frame.end())
      up_world.emplace(keyframe.id, keyframe.pose.world_from_keyframe.rotation * up->second);
  }
  return up_world;
}

Expected<recording::Trajectory> stored_trajectory(const home::Home& home,
                                                  std::optional<home::RecordingId> walk) {
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  ROOMWISE_TRY(const auto recordings, home.recordings());
  ROOMWISE_TRY(const auto settings, stored_map_settings(home));
  std::vector<geometry::RigidTransform> world_from_keyframe;
  for (const home::Keyframe& keyframe : keyframes)
    world_from_keyframe.push_back(keyframe.pose.world_from_keyframe);
  const std::vector<TimestampNs> times_ns = times_of(keyframes);
  std::vector<std::size_t> component;
  for (const home::Keyframe& keyframe : keyframes) component.push_back(keyframe.pose.component);
  // Without bundle adjustment a frame is where it was found from its key-frame.
  const bool is_adjusted = settings && settings->adjusts_bundle();
  std::vector<mapping::PoseGraphEdge> edges;
  if (is_adjusted) {
    ROOMWISE_TRY(mapping::PoseGraph graph, stored_pose_graph(home, settings->solver));
    edges = std::move(graph.edges);
  }
  recording::Trajectory trajectory;
  for (const home::StoredRecording& recording : recordings) {
    if (walk && recording.id != *walk) continue;
    ROOMWISE_TRY(const auto frames, home.frames(recording.id));
    const auto poses =
        mapping::frame_poses(frames, {world_from_keyframe, times_ns, component}, edges);
    std::vector<mapping::PlacedFrame> placed = place_frames(frames, poses, keyframes);
    if (is_adjusted) mapping::smooth_frames(placed);
    for (const mapping::PlacedFrame& frame : placed) {
      if (frame.world_from_camera)
        trajectory.push_back({frame.timestamp_ns, *frame.world_from_camera});
    }
  }
  return trajectory;
}

}  // namespace roomwise::pipeline
