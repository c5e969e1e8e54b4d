#include "laboratory/trials/truth_evaluation.h"

#include <algorithm>
#include <cstdlib>
#include <span>
#include <utility>
#include <vector>

#include "laboratory/simulation/home/ground_truth.h"
#include "laboratory/simulation/recording/simulation_file.h"
#include "roomwise/evaluation/errors/trajectory_error.h"
#include "roomwise/pipeline/mapping/dense_map.h"
#include "roomwise/pipeline/mapping/map_cloud.h"
#include "roomwise/pipeline/stored/keyframe_images.h"
#include "roomwise/pipeline/stored/stored_map.h"
#include "roomwise/recording/open_recording.h"

namespace roomwise::trials {
namespace {

constexpr double kFarFromEverything_m = 0.5;

Expected<std::vector<Eigen::Vector3f>> surface_points(const home::Home& home,
                                                      std::span<const home::Keyframe> keyframes,
                                                      const MapEvaluationOptions& options,
                                                      pipeline::RunContext& run) {
  if (options.surface == MapSurface::kCloud) {
    ROOMWISE_TRY(pipeline::MapCloud map,
                 pipeline::build_map_cloud(home, keyframes, options.voxel_size_m, run));
    return std::move(map.cloud.points);
  }
  ROOMWISE_TRY(
      pipeline::DenseMap map,
      pipeline::build_dense_map(home, keyframes, {.voxel_size_m = options.voxel_size_m}, run));
  ROOMWISE_TRY(const auto surface, extract_mesh(map.field(), fusion::MeshOptions{}, run.pool));
  ROOMWISE_TRY(fusion::TriangleMesh mesh, surface.whole());
  return std::move(mesh.vertices);
}

}  // namespace

std::vector<home::Keyframe> of_walk(std::vector<home::Keyframe> keyframes, home::RecordingId walk) {
  std::erase_if(keyframes, [&](const auto& keyframe) { return keyframe.recording != walk; });
  return keyframes;
}

Expected<std::vector<home::Keyframe>> at_true_poses(std::vector<home::Keyframe> keyframes,
                                                    home::RecordingId walk,
                                                    const std::filesystem::path& recording) {
  constexpr TimestampNs kMaxApart_ns = 20'000'000;
  ROOMWISE_TRY(const recording::Trajectory truth, recording::read_truth(recording));
  std::vector<home::Keyframe> placed;
  for (home::Keyframe keyframe : of_walk(std::move(keyframes), walk)) {
    const auto nearest = std::ranges::min_element(truth, {}, [&](const auto& pose) {
      return std::abs(pose.timestamp_ns - keyframe.timestamp_ns);
    });
    if (nearest == truth.end()) break;
    if (std::abs(nearest->timestamp_ns - keyframe.timestamp_ns) > kMaxApart_ns) continue;
    keyframe.pose.world_from_keyframe = nearest->world_from_camera;
    placed.push_back(keyframe);
  }
  if (placed.empty())
    return fail("{}: has no true pose at the time of a key-frame", recording.string());
  return placed;
}

Expected<home::RecordingId> mapped_walk(const home::Home& home,
                                        const std::filesystem::path& recording) {
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  ROOMWISE_TRY(const auto recordings, home.recordings());
  for (const home::StoredRecording& walk : recordings) {
    const auto of_walk =
        std::ranges::equal_range(keyframes, walk.id, {}, &home::Keyframe::recording);
    if (of_walk.empty()) continue;
    ROOMWISE_TRY(const auto pictures,
                 recording::open_recording(recording, {.camera = walk.recording.camera}));
    const auto is_picture = [&](const home::Keyframe& keyframe) -> Expected<bool> {
      if (pictures->find(keyframe.frame_index) == nullptr) return false;
      ROOMWISE_TRY(const home::KeyframeImages images, home.images(keyframe.id));
      return pictures->read_color_file(keyframe.frame_index).map([&](const Bytes& picture) {
        return picture == images.color;
      });
    };
    ROOMWISE_TRY(const bool has_first, is_picture(of_walk.front()));
    ROOMWISE_TRY(const bool has_last, is_picture(of_walk.back()));
    if (has_first && has_last) return walk.id;
  }
  return fail(
      "{} was not mapped from {}: the key-frames of none of its walks are pictures of it; give a "
      "recording that was mapped",
      home.file(), recording.string());
}

Expected<geometry::RigidTransform> truth_from_map(const home::Home& home,
                                                  const std::filesystem::path& recording) {
  ROOMWISE_TRY(const recording::Trajectory truth, recording::read_truth(recording));
  ROOMWISE_TRY(const home::RecordingId walk, mapped_walk(home, recording));
  ROOMWISE_TRY(const recording::Trajectory estimate, pipeline::stored_trajectory(home, walk));
  const auto error = evaluation::absolute_trajectory_error(truth, estimate);
  if (!error) return fail("{} and {}: {}", home.file(), recording.string(), error.error().message);
  return error->truth_from_estimate;
}

Expected<RecordedHome> recorded_home(const std::filesystem::path& recording,
                                     const simulation::FurnitureCatalogue& catalogue) {
  const std::filesystem::path made_of = recording / "simulation.json";
  ROOMWISE_TRY(const auto made, simulation::read_simulation(made_of));
  ROOMWISE_TRY(simulation::HomeModel model, simulation::make_home(made.options, catalogue));
  const auto load = [&](const std::string& id) { return catalogue.load(id); };
  ROOMWISE_TRY(auto surfaces, simulation::TrueSurfaces::create(model, load));
  if (surfaces.digest() != made.scene_sha256) {
    return fail(
        "{}: tells of another home than this program, with this furniture, makes of its "
        "description; make the recording anew, and map it again",
        made_of.string());
  }
  return RecordedHome{made.options, std::move(model), std::move(surfaces)};
}

Expected<std::string> place_of(const std::filesystem::path& truth) {
  const std::filesystem::path made_of = truth / "simulation.json";
  if (std::filesystem::exists(made_of)) {
    ROOMWISE_TRY(const auto made, simulation::read_simulation(made_of));
    return made.options.home ? fmt::format("home {}", made.options.home->seed) : "reference flat";
  }
  const auto path = (truth / "").lexically_normal().parent_path();  // one that ends in no slash
  const std::string name = path.filename().string();
  constexpr std::string_view kMarked = ".objects.json";
  return name.ends_with(kMarked) ? name.substr(0, name.size() - kMarked.size()) : name;
}

Expected<evaluation::CloudError> evaluate_map(const home::Home& home,
                                              const std::filesystem::path& recording,
                                              const std::filesystem::path& furniture,
                                              const MapEvaluationOptions& options,
                                              pipeline::RunContext& run) {
  ROOMWISE_TRY(const home::RecordingId walk, mapped_walk(home, recording));
  ROOMWISE_TRY(const auto catalogue, simulation::FurnitureCatalogue::open(furniture));
  ROOMWISE_TRY(const RecordedHome recorded, recorded_home(recording, catalogue));
  ROOMWISE_TRY(auto keyframes, pipeline::map_keyframes(home));
  keyframes = of_walk(std::move(keyframes), walk);
  geometry::RigidTransform truth_from_world;
  if (options.at_true_poses) {
    ROOMWISE_TRY(keyframes, at_true_poses(std::move(keyframes), walk, recording));
  } else {
    ROOMWISE_TRY(truth_from_world, truth_from_map(home, recording));
  }
  ROOMWISE_TRY(const std::vector<Eigen::Vector3f> points,
               surface_points(home, keyframes, options, run));

  std::vector<double> distances_m(points.size());
  constexpr std::size_t kBlock = 4096;
  run.pool.parallel_for((points.size() + kBlock - 1) / kBlock, [&](std::size_t block) {
    const std::size_t end = std::min(points.size(), (block + 1) * kBlock);
    for (std::size_t i = block * kBlock; i < end; ++i) {
      const Eigen::Vector3d point_truth = truth_from_world * points[i].cast<double>();
      distances_m[i] =
          recorded.surfaces.distance_m(point_truth.cast<float>(), kFarFromEverything_m);
    }
  });
  return evaluation::cloud_error(distances_m);
}

}  // namespace roomwise::trials
