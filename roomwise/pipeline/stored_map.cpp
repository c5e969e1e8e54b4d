#include "roomwise/pipeline/stored_map.h"

#include <algorithm>
#include <set>

#include "roomwise/image/codec.h"
#include "roomwise/objects/center_point.h"

namespace roomwise::pipeline {
namespace {

std::map<home::KeyframeId, home::KeyframePose> poses_by_id(
    std::span<const home::Keyframe> keyframes) {
  std::map<home::KeyframeId, home::KeyframePose> poses;
  for (const home::Keyframe& keyframe : keyframes) poses[keyframe.id] = keyframe.pose;
  return poses;
}

// Those before which the walk went on from an earlier key-frame than the last: their first step
// leads to that one.
std::set<home::KeyframeId> after_known_ground(std::span<const mapping::PoseGraphEdge> edges) {
  std::set<home::KeyframeId> after;
  for (const mapping::PoseGraphEdge& edge : edges) {
    if (!edge.is_loop && edge.from + 1 != edge.to) after.insert(edge.to);
  }
  return after;
}

}  // namespace

Expected<mapping::MapSolution> solve_stored_map(home::Home& home,
                                                const mapping::MapSolverOptions& options) {
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  ROOMWISE_TRY(const auto edges, home.edges());
  ROOMWISE_TRY(mapping::MapSolution solution, mapping::solve_map(keyframes.size(), edges, options));
  std::map<home::KeyframeId, home::KeyframePose> poses;
  for (std::size_t id = 0; id < keyframes.size(); ++id) {
    poses[id] = {solution.world_from_keyframe[id], solution.piece[id]};
  }
  ROOMWISE_CHECK_OK(home.replace_poses(poses));
  return solution;
}

Expected<mapping::PoseGraph> stored_pose_graph(const home::Home& home,
                                               const mapping::MapSolverOptions& options) {
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  mapping::PoseGraph graph;
  for (const home::Keyframe& keyframe : keyframes) {
    graph.world_from_node[keyframe.id] = keyframe.pose.world_from_keyframe;
  }
  ROOMWISE_TRY(const auto edges, home.edges());
  graph.edges = mapping::doubt_steps(keyframes.size(), edges);
  std::erase_if(graph.edges, [&](const mapping::PoseGraphEdge& edge) {
    return mapping::is_contradicted(graph, edge, options);
  });
  return graph;
}

Expected<std::uint64_t> update_objects(home::Home& home, const objects::ObjectRules& rules) {
  ROOMWISE_CHECK_OK(rules.validate());
  ROOMWISE_TRY(const rooms::Concepts concepts, home.concepts());
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  ROOMWISE_TRY(const auto recordings, home.recordings());
  ROOMWISE_TRY(const auto networks, home.networks());

  // The first network that names things is the one that is asked.
  std::map<home::KeyframeId, network::Prediction> predictions;
  std::vector<std::string> labels;
  for (const auto& [id, network] : networks) {
    if (network.labels.empty()) continue;
    labels = network.labels;
    ROOMWISE_TRY(predictions, home.predictions(id));
    break;
  }

  ROOMWISE_TRY(const auto edges, home.edges());
  const std::set<home::KeyframeId> not_continuous = after_known_ground(edges);

  std::vector<objects::KeyframeView> views;
  for (const home::Keyframe& keyframe : keyframes) {
    objects::KeyframeView& view = views.emplace_back();
    view.keyframe_id = keyframe.id;
    view.is_continuous = !not_continuous.contains(keyframe.id);
    if (const auto found = predictions.find(keyframe.id); found != predictions.end()) {
      view.sightings = objects::sightings_in(found->second.scores, labels, concepts.vocabulary,
                                             rules.least_score);
    }
    if (view.sightings.empty()) continue;
    ROOMWISE_TRY(const home::KeyframeImages images, home.images(keyframe.id));
    ROOMWISE_TRY(const image::DepthImage depth, image::decode_depth(images.depth));
    const auto recording =
        std::ranges::find(recordings, keyframe.recording, &home::StoredRecording::id);
    view.center_point = objects::center_point(depth, recording->recording.camera);
  }
  // Pieces of the map that nothing joined have nothing to do with each other.
  std::map<std::uint64_t, std::vector<objects::KeyframeView>> views_of_piece;
  for (std::size_t i = 0; i < keyframes.size(); ++i)
    views_of_piece[keyframes[i].pose.piece].push_back(views[i]);
  const std::map<home::KeyframeId, home::KeyframePose> poses = poses_by_id(keyframes);
  std::vector<objects::MapObject> found;
  for (const auto& [piece, views_there] : views_of_piece) {
    const auto there = objects::confirm_objects(
        views_there, rules, [&](std::uint64_t id) { return poses.at(id).world_from_keyframe; });
    found.insert(found.end(), there.begin(), there.end());
  }
  ROOMWISE_CHECK_OK(home.atomically([&]() -> Expected<void> {
    for (const objects::KeyframeView& view : views) {
      ROOMWISE_CHECK_OK(home.put_sightings(view.keyframe_id, view.sightings));
    }
    return home.replace_objects(found);
  }));
  return found.size();
}

Expected<recording::Trajectory> stored_trajectory(const home::Home& home) {
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  ROOMWISE_TRY(const auto recordings, home.recordings());
  const std::map<home::KeyframeId, home::KeyframePose> poses = poses_by_id(keyframes);
  recording::Trajectory trajectory;
  for (const home::StoredRecording& recording : recordings) {
    ROOMWISE_TRY(const auto frames, home.frames(recording.id));
    for (const home::Frame& frame : frames) {
      if (!frame.place || poses.at(frame.place->keyframe).piece != 0) continue;
      trajectory.push_back(
          {frame.timestamp_ns, poses.at(frame.place->keyframe).world_from_keyframe *
                                   frame.place->keyframe_from_camera});
    }
  }
  return trajectory;
}

}  // namespace roomwise::pipeline
