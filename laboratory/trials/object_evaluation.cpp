// Objects of a home against those of the simulated home that it was mapped in, or against what
// people marked in a real recording.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "laboratory/labelling/recording_truth.h"
#include "laboratory/simulation/home/ground_truth.h"
#include "laboratory/trials/naive_objects.h"
#include "laboratory/trials/true_objects.h"
#include "laboratory/trials/truth_evaluation.h"
#include "roomwise/pipeline/objects/stored_detections.h"
#include "roomwise/pipeline/stored/keyframe_images.h"

namespace roomwise::trials {
namespace {

using evaluation::FoundObject;
using evaluation::TrueObject;

constexpr double kWellSeenFrom_m = 2;
constexpr std::ptrdiff_t kWellSeenIn = 4;  // key-frames
constexpr double kMinShare = 0.005;        // of the picture
constexpr double kMinFill = 0.15;          // of the rectangle about its box

// The rectangle about a box as a camera without a rim would see it, px; absent where a corner lies
// behind the camera.
std::optional<Eigen::AlignedBox2d> rectangle_about(
    const geometry::OrientedBox& box, const geometry::RigidTransform& world_from_camera,
    const geometry::PinholeCamera& camera) {
  Eigen::AlignedBox2d rectangle;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d side((corner & 1) != 0 ? 0.5 : -0.5, (corner & 2) != 0 ? 0.5 : -0.5,
                               (corner & 4) != 0 ? 0.5 : -0.5);
    const Eigen::Vector3d point =
        world_from_camera.inverse() * (box.world_from_box * side.cwiseProduct(box.size_m));
    if (point.z() < 0.05) return std::nullopt;
    rectangle.extend(camera.project_undistorted(point));
  }
  return rectangle;
}

// A thing in a true key-frame, with its share of the picture and its pixels there.
struct TruthObservation {
  const home::Keyframe* keyframe = nullptr;
  const simulation::ObjectObservation* seen = nullptr;
};
std::vector<TruthObservation> truth_observations(const simulation::ObjectTruth& object,
                                                 std::span<const home::Keyframe> true_poses) {
  std::vector<TruthObservation> observations;
  for (const home::Keyframe& keyframe : true_poses) {
    const auto seen = std::ranges::lower_bound(object.seen, keyframe.frame_index, {},
                                               &simulation::ObjectObservation::frame);
    if (seen != object.seen.end() && seen->frame == keyframe.frame_index)
      observations.push_back({&keyframe, &*seen});
  }
  return observations;
}

using Cameras = std::map<home::RecordingId, geometry::PinholeCamera>;

bool is_seen_well(const simulation::ObjectTruth& object,
                  std::span<const TruthObservation> observations, const Cameras& cameras) {
  const geometry::OrientedBox box = box_of(object);
  const auto shows_well = [&](const TruthObservation& observation) {
    const geometry::RigidTransform& pose = observation.keyframe->pose.world_from_keyframe;
    if (observation.seen->share < kMinShare || box.distance_m(pose.translation) > kWellSeenFrom_m)
      return false;
    const auto about = rectangle_about(box, pose, cameras.at(observation.keyframe->recording));
    return about &&
           static_cast<double>(observation.seen->pixels) >= kMinFill * about->sizes().prod();
  };
  return std::ranges::count_if(observations, shows_well) >= kWellSeenIn;
}

// Where it is largest.
std::optional<ShownIn> shown_best(const simulation::ObjectTruth& object,
                                  std::span<const TruthObservation> observations,
                                  const Cameras& cameras) {
  if (observations.empty()) return std::nullopt;
  const TruthObservation& best = *std::ranges::max_element(
      observations, {},
      [](const TruthObservation& observation) { return observation.seen->share; });
  ShownIn shown{best.keyframe->id, std::nullopt};
  const geometry::PinholeCamera& camera = cameras.at(best.keyframe->recording);
  if (auto about =
          rectangle_about(box_of(object), best.keyframe->pose.world_from_keyframe, camera)) {
    *about = about->intersection(
        Eigen::AlignedBox2d(Eigen::Vector2d::Zero(), Eigen::Vector2d(camera.width, camera.height)));
    if (about->isEmpty()) return shown;
    shown.box = {static_cast<float>(about->min().x()), static_cast<float>(about->min().y()),
                 static_cast<float>(about->max().x()), static_cast<float>(about->max().y())};
  }
  return shown;
}

// The truth in the home's words: what it has no word for, nor one like it, is left out.
Expected<void> add_nameable(const home::Home& home, const std::filesystem::path& recording,
                            HomeTruth& result) {
  ROOMWISE_TRY(const auto objects, simulation::read_objects_truth(recording / "objects.json"));
  ROOMWISE_TRY(const rooms::Concepts concepts, home.concepts());
  ROOMWISE_TRY(auto keyframes, home.keyframes());
  ROOMWISE_TRY(const auto true_poses, at_true_poses(std::move(keyframes), result.walk, recording));
  ROOMWISE_TRY(const auto cameras, pipeline::recording_cameras(home));
  for (const simulation::ObjectTruth& object : objects) {
    if (object.seen.empty()) continue;
    auto entry = in_words(object, concepts.vocabulary);
    if (!entry) continue;
    const std::vector<TruthObservation> observations = truth_observations(object, true_poses);
    entry->is_expected = entry->is_expected && is_seen_well(object, observations, cameras);
    result.things.push_back(*std::move(entry));
    result.shown.push_back(shown_best(object, observations, cameras));
  }
  return {};
}

// The key-frame from the nearest place whose picture holds the middle of a thing, and where.
std::optional<ShownIn> shown_nearest(const geometry::OrientedBox& box,
                                     std::span<const home::Keyframe> true_poses,
                                     const Cameras& cameras) {
  std::optional<ShownIn> shown;
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const home::Keyframe& keyframe : true_poses) {
    const geometry::RigidTransform& pose = keyframe.pose.world_from_keyframe;
    const geometry::PinholeCamera& camera = cameras.at(keyframe.recording);
    const Eigen::AlignedBox2d picture(Eigen::Vector2d::Zero(),
                                      Eigen::Vector2d(camera.width, camera.height));
    const double distance_m = (box.center() - pose.translation).norm();
    const auto about = rectangle_about(box, pose, camera);
    if (!about || !picture.contains(about->center()) || distance_m >= nearest_m) continue;
    nearest_m = distance_m;
    const Eigen::AlignedBox2d in_picture = about->intersection(picture);
    shown = ShownIn{keyframe.id, network::PixelBox{static_cast<float>(in_picture.min().x()),
                                                   static_cast<float>(in_picture.min().y()),
                                                   static_cast<float>(in_picture.max().x()),
                                                   static_cast<float>(in_picture.max().y())}};
  }
  return shown;
}

// What readers marked, in the home's words: what it has no word for is left out.
Expected<void> add_marked(const home::Home& home, const labelling::RecordingTruth& truth,
                          const std::filesystem::path& recording, HomeTruth& result) {
  ROOMWISE_TRY(const rooms::Concepts concepts, home.concepts());
  ROOMWISE_TRY(auto keyframes, home.keyframes());
  ROOMWISE_TRY(const auto true_poses, at_true_poses(std::move(keyframes), result.walk, recording));
  ROOMWISE_TRY(const auto cameras, pipeline::recording_cameras(home));
  for (const labelling::TrueThing& thing : truth.things) {
    auto entry = in_words(thing, concepts.vocabulary);
    if (!entry) continue;
    result.things.push_back(*std::move(entry));
    result.shown.push_back(shown_nearest(thing.box_world, true_poses, cameras));
  }
  return {};
}

// The folder of the recording that a home was mapped from, as the user gave it then.
Expected<std::filesystem::path> recording_of(const home::Home& home) {
  ROOMWISE_TRY(const auto recordings, home.recordings());
  if (recordings.empty()) return fail("{}: nothing was mapped into it yet", home.file());
  const std::filesystem::path folder = recordings.back().recording.folder;
  std::error_code ignored;
  if (!std::filesystem::exists(folder, ignored)) {
    return fail(
        "{} was mapped from {}, where there is nothing now; give its recording by "
        "--recording",
        home.file(), folder.string());
  }
  return folder;
}

// What was found, with what is kept of it until it is known whether it counts.
struct PlacedObject {
  FoundObject found;
  bool is_of_walk = true;  // a key-frame of the walk that the truth is of shows it best
};
struct PlacedInstance : PlacedObject {
  geometry::OrientedBox box;
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();
  double probability = 0;
  ShownIn shown;
};

template <typename Placed>
Expected<FoundObjectErrors> compare(std::span<const TrueObject> truth,
                                    std::span<const Placed> placed, double max_distance_m) {
  FoundObjectErrors result;
  for (const Placed& one : placed) result.found.push_back(one.found);
  ROOMWISE_TRY(result.errors, evaluation::object_errors(truth, result.found, max_distance_m));
  return result;
}

// Compares what counts, and leaves that alone in `placed`: what other walks show may be another
// thing than those that the truth tells of.
template <typename Placed>
Expected<FoundObjectErrors> compare_counted(std::span<const TrueObject> truth,
                                            std::vector<Placed>& placed, double max_distance_m) {
  ROOMWISE_TRY(const FoundObjectErrors all,
               compare(truth, std::span<const Placed>(placed), max_distance_m));
  std::vector<bool> is_matched(placed.size());
  for (const evaluation::ObjectMatch& match : all.errors.matches) is_matched[match.found] = true;
  std::vector<Placed> counted;
  for (std::size_t i = 0; i < placed.size(); ++i) {
    if (is_matched[i] || placed[i].is_of_walk) counted.push_back(std::move(placed[i]));
  }
  placed = std::move(counted);
  return compare(truth, std::span<const Placed>(placed), max_distance_m);
}

}  // namespace

Expected<HomeTruth> home_truth(const home::Home& home, const ObjectTruthFiles& truth) {
  if (!std::filesystem::exists(truth.truth)) {
    return fail(
        "{}: there is nothing; give the folder of a simulated recording or a "
        "RECORDING.objects.json",
        truth.truth.string());
  }
  const bool is_simulated = std::filesystem::is_directory(truth.truth);
  std::filesystem::path recording = is_simulated ? truth.truth : truth.recording;
  std::optional<labelling::RecordingTruth> marked;
  if (!is_simulated) {
    ROOMWISE_TRY(marked, labelling::read_recording_truth(truth.truth));
    if (recording.empty()) {
      ROOMWISE_TRY(recording, recording_of(home));
    }
  }
  HomeTruth result;
  ROOMWISE_TRY(result.walk, mapped_walk(home, recording));
  if (marked) {
    ROOMWISE_RETURN_IF_ERROR(add_marked(home, *marked, recording, result));
  } else {
    ROOMWISE_RETURN_IF_ERROR(add_nameable(home, recording, result));
  }
  ROOMWISE_TRY(result.truth_from_world, truth_from_map(home, recording));
  return result;
}

Expected<ObjectEvaluation> evaluate_objects(const home::Home& home, const ObjectTruthFiles& truth,
                                            double max_distance_m) {
  ObjectEvaluation result;
  result.max_distance_m = max_distance_m;
  ROOMWISE_TRY(HomeTruth there, home_truth(home, truth));
  result.truth = std::move(there.things);
  result.truth_shown = std::move(there.shown);
  const geometry::RigidTransform& truth_from_world = there.truth_from_world;
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  const auto is_of_walk = [&](home::KeyframeId id) {
    return keyframes.at(id).recording == there.walk;
  };

  ROOMWISE_TRY(const auto objects, home.confirmed_objects());
  std::vector<PlacedObject> by_rules;
  std::size_t without_place = 0;
  for (const objects::ConfirmedObject& object : objects) {
    const home::KeyframePose& pose = keyframes.at(object.keyframe_id).pose;
    if (!object.position_keyframe || pose.component != 0) {
      ++without_place;
      continue;
    }
    by_rules.push_back(
        {{object.name, truth_from_world * (pose.world_from_keyframe * *object.position_keyframe)},
         is_of_walk(object.keyframe_id)});
  }
  ROOMWISE_TRY(result.by_rules,
               compare_counted<PlacedObject>(result.truth, by_rules, max_distance_m));
  result.by_rules.without_place = without_place;

  ROOMWISE_TRY(auto observed, pipeline::observed_keyframes(home));
  if (const auto main_component = observed.find(0); main_component != observed.end()) {
    std::erase_if(main_component->second,
                  [&](const auto& keyframe) { return !is_of_walk(keyframe.keyframe_id); });
    result.naive.found = naive_objects(main_component->second);
  }
  for (evaluation::FoundObject& found : result.naive.found) {
    found.position = truth_from_world * found.position;
  }
  ROOMWISE_TRY(result.naive.errors,
               evaluation::object_errors(result.truth, result.naive.found, max_distance_m));

  ROOMWISE_TRY(const auto instances, home.instances());
  std::vector<PlacedInstance> placed;
  without_place = 0;
  for (const objects::Instance& instance : instances) {
    const home::KeyframePose& pose = keyframes.at(instance.keyframe_id).pose;
    if (pose.component != 0) {
      ++without_place;
      continue;
    }
    const auto box = instance.box_world(truth_from_world * pose.world_from_keyframe);
    const bool is_of_map = instance.visit == 0;
    placed.push_back(
        {{{instance.name, box.center()}, is_of_map && is_of_walk(instance.keyframe_id)},
         box,
         instance.sigma_m,
         instance.probability,
         {instance.keyframe_id, is_of_map ? std::optional(instance.picture_box) : std::nullopt}});
  }
  ROOMWISE_TRY(result.instances,
               compare_counted<PlacedInstance>(result.truth, placed, max_distance_m));
  result.instances.without_place = without_place;
  std::vector<double> probabilities;
  for (const PlacedInstance& one : placed) {
    probabilities.push_back(one.probability);
    result.instances_shown.push_back(one.shown);
  }
  for (const evaluation::ObjectMatch& match : result.instances.errors.matches) {
    const PlacedInstance& one = placed[match.found];
    result.coverage.add(one.box.world_from_box.inverse() * result.truth[match.truth].box.center(),
                        one.sigma_m);
  }
  result.forecasts = evaluation::forecasts_of(result.instances.errors, result.truth, probabilities);
  return result;
}

}  // namespace roomwise::trials
