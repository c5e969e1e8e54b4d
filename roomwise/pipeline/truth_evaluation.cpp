#include "roomwise/pipeline/truth_evaluation.h"

#include <algorithm>
#include <utility>

#include "roomwise/evaluation/trajectory_error.h"
#include "roomwise/pipeline/map_cloud.h"
#include "roomwise/pipeline/stored_map.h"
#include "roomwise/recording/trajectory_file.h"
#include "roomwise/simulation/ground_truth.h"
#include "roomwise/simulation/simulation_file.h"
#include "roomwise/simulation/true_surfaces.h"

namespace roomwise::pipeline {
namespace {

constexpr double kFarFromEverything_m = 0.5;

// What is called so by the home and was shown by the walk.
std::vector<evaluation::TrueObject> nameable(const std::vector<simulation::ObjectTruth>& objects,
                                             const rooms::Concepts& concepts) {
  std::vector<evaluation::TrueObject> truth;
  for (const simulation::ObjectTruth& object : objects) {
    if (object.seen.empty() || !concepts.vocabulary.objects().contains(object.label)) continue;
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(object.yaw_rad, Eigen::Vector3d::UnitZ()));
    truth.push_back({object.label, {{turn, object.center_m}, object.size_m}});
  }
  return truth;
}

}  // namespace

Expected<geometry::RigidTransform> truth_from_map(const home::Home& home,
                                                  const std::filesystem::path& recording) {
  const std::filesystem::path file = recording / "groundtruth.txt";
  ROOMWISE_TRY(const recording::Trajectory truth, recording::read_trajectory(file));
  ROOMWISE_TRY(const recording::Trajectory estimate, stored_trajectory(home));
  const auto error = evaluation::absolute_trajectory_error(truth, estimate);
  if (!error) return fail("{} and {}: {}", home.file(), file.string(), error.error().message);
  return error->truth_from_estimate;
}

Expected<ObjectEvaluation> evaluate_objects(const home::Home& home,
                                            const std::filesystem::path& recording,
                                            double most_distance_m) {
  ROOMWISE_TRY(const auto true_objects, simulation::read_objects_truth(recording / "objects.json"));
  ROOMWISE_TRY(const geometry::RigidTransform truth_from_world, truth_from_map(home, recording));
  ROOMWISE_TRY(const rooms::Concepts concepts, home.concepts());
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  ROOMWISE_TRY(const auto objects, home.objects());

  ObjectEvaluation result;
  result.truth = nameable(true_objects, concepts);
  for (const objects::MapObject& object : objects) {
    const home::KeyframePose& pose = keyframes.at(object.keyframe_id).pose;
    if (!object.position_keyframe || pose.piece != 0) {
      ++result.without_place;
      continue;
    }
    result.found.push_back(
        {object.name, truth_from_world * (pose.world_from_keyframe * *object.position_keyframe)});
  }
  ROOMWISE_TRY(result.errors,
               evaluation::object_errors(result.truth, result.found, most_distance_m));
  return result;
}

Expected<evaluation::CloudError> evaluate_map(const home::Home& home,
                                              const std::filesystem::path& recording,
                                              const std::filesystem::path& furniture,
                                              double voxel_size_m, RunContext& run) {
  ROOMWISE_TRY(const auto made_up, simulation::read_simulation(recording / "simulation.json"));
  ROOMWISE_TRY(const auto catalogue, simulation::FurnitureCatalogue::open(furniture));
  ROOMWISE_TRY(const simulation::HomeModel model, simulation::make_home(made_up, catalogue));
  const auto load = [&](const std::string& id) { return catalogue.load(id); };
  ROOMWISE_TRY(const auto surfaces, simulation::TrueSurfaces::create(model, load));
  ROOMWISE_TRY(const geometry::RigidTransform truth_from_world, truth_from_map(home, recording));
  ROOMWISE_TRY(const MapCloud map, build_map_cloud(home, voxel_size_m, run));

  const std::vector<Eigen::Vector3f>& points = map.cloud.points;
  std::vector<double> distances_m(points.size());
  constexpr std::size_t kBlock = 4096;
  run.pool.parallel_for((points.size() + kBlock - 1) / kBlock, [&](std::size_t block) {
    const std::size_t end = std::min(points.size(), (block + 1) * kBlock);
    for (std::size_t i = block * kBlock; i < end; ++i) {
      const Eigen::Vector3d point_truth = truth_from_world * points[i].cast<double>();
      distances_m[i] = surfaces.distance_m(point_truth.cast<float>(), kFarFromEverything_m);
    }
  });
  return evaluation::cloud_error(distances_m);
}

}  // namespace roomwise::pipeline
