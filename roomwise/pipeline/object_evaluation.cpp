// Objects of a home against those of the simulated home that it was mapped in.

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "roomwise/pipeline/keyframe_images.h"
#include "roomwise/pipeline/true_objects.h"
#include "roomwise/pipeline/truth_evaluation.h"
#include "roomwise/simulation/ground_truth.h"

namespace roomwise::pipeline {
namespace {

using evaluation::FoundObject;
using evaluation::TrueObject;

constexpr double kWellSeenFrom_m = 2;
constexpr std::size_t kWellSeenIn = 4;  // key-frames
constexpr double kLeastShare = 0.005;   // of the picture
constexpr double kLeastFill = 0.15;     // of the rectangle about its box

// The area of the rectangle about a box as a camera without a rim would see it, px; infinite where
// a corner lies behind the camera.
double rectangle_px(const geometry::OrientedBox& box,
                    const geometry::RigidTransform& world_from_camera,
                    const geometry::PinholeCamera& camera) {
  Eigen::AlignedBox2d rectangle;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d side((corner & 1) != 0 ? 0.5 : -0.5, (corner & 2) != 0 ? 0.5 : -0.5,
                               (corner & 4) != 0 ? 0.5 : -0.5);
    const Eigen::Vector3d point =
        world_from_camera.inverse() * (box.world_from_box * side.cwiseProduct(box.size_m));
    if (point.z() < 0.05) return std::numeric_limits<double>::infinity();
    rectangle.extend(camera.project_undistorted(point));
  }
  return rectangle.sizes().prod();
}

bool is_seen_well(const simulation::ObjectTruth& object, std::span<const home::Keyframe> true_poses,
                  const std::map<home::RecordingId, geometry::PinholeCamera>& cameras) {
  const geometry::OrientedBox box = box_of(object);
  std::size_t well_seen = 0;
  for (const home::Keyframe& keyframe : true_poses) {
    const auto seen = std::ranges::lower_bound(object.seen, keyframe.frame_index, {},
                                               &simulation::ObjectSighting::frame);
    if (seen == object.seen.end() || seen->frame != keyframe.frame_index) continue;
    const geometry::RigidTransform& pose = keyframe.pose.world_from_keyframe;
    if (seen->share < kLeastShare || box.distance_m(pose.translation) > kWellSeenFrom_m) continue;
    const double whole_px = rectangle_px(box, pose, cameras.at(keyframe.recording));
    if (static_cast<double>(seen->pixels) >= kLeastFill * whole_px) ++well_seen;
  }
  return well_seen >= kWellSeenIn;
}

// The truth in the home's words: what it has no word for, nor one like it, is left out.
Expected<std::vector<TrueObject>> nameable(const home::Home& home,
                                           const std::filesystem::path& recording) {
  ROOMWISE_TRY(const auto objects, simulation::read_objects_truth(recording / "objects.json"));
  ROOMWISE_TRY(const rooms::Concepts concepts, home.concepts());
  ROOMWISE_TRY(auto keyframes, home.keyframes());
  ROOMWISE_TRY(const auto true_poses, at_true_poses(std::move(keyframes), recording));
  ROOMWISE_TRY(const auto cameras, recording_cameras(home));
  std::vector<TrueObject> truth;
  for (const simulation::ObjectTruth& object : objects) {
    if (object.seen.empty()) continue;
    auto entry = in_words(object, concepts.vocabulary);
    if (!entry) continue;
    entry->is_expected = entry->is_expected && is_seen_well(object, true_poses, cameras);
    truth.push_back(*std::move(entry));
  }
  return truth;
}

// The share of a found box's axes along which the truth lies within two standard deviations.
struct SigmaCount {
  std::size_t axes = 0, within = 0;
};
void count_sigma(SigmaCount& count, const geometry::OrientedBox& found_truth,
                 const Eigen::Vector3d& sigma_m, const Eigen::Vector3d& true_center) {
  const Eigen::Vector3d error = found_truth.world_from_box.inverse() * true_center;
  for (int axis = 0; axis < 3; ++axis) {
    ++count.axes;
    if (std::abs(error[axis]) <= 2 * sigma_m[axis]) ++count.within;
  }
}

}  // namespace

Expected<ObjectEvaluation> evaluate_objects(const home::Home& home,
                                            const std::filesystem::path& recording,
                                            double most_distance_m) {
  ROOMWISE_CHECK_OK(check_mapped_from(home, recording));
  ObjectEvaluation result;
  ROOMWISE_TRY(result.truth, nameable(home, recording));
  ROOMWISE_TRY(const geometry::RigidTransform truth_from_world, truth_from_map(home, recording));
  ROOMWISE_TRY(const auto keyframes, home.keyframes());

  ROOMWISE_TRY(const auto objects, home.objects());
  for (const objects::MapObject& object : objects) {
    const home::KeyframePose& pose = keyframes.at(object.keyframe_id).pose;
    if (!object.position_keyframe || pose.piece != 0) {
      ++result.by_rules.without_place;
      continue;
    }
    result.by_rules.found.push_back(
        {object.name, truth_from_world * (pose.world_from_keyframe * *object.position_keyframe)});
  }
  ROOMWISE_TRY(result.by_rules.errors,
               evaluation::object_errors(result.truth, result.by_rules.found, most_distance_m));

  ROOMWISE_TRY(const auto instances, home.instances());
  std::vector<std::pair<geometry::OrientedBox, Eigen::Vector3d>> boxes;  // with sigma
  for (const objects::Instance& instance : instances) {
    const home::KeyframePose& pose = keyframes.at(instance.keyframe_id).pose;
    if (pose.piece != 0) {
      ++result.instances.without_place;
      continue;
    }
    boxes.emplace_back(instance.box_world(truth_from_world * pose.world_from_keyframe),
                       instance.sigma_m);
    result.instances.found.push_back({instance.name, boxes.back().first.center()});
  }
  ROOMWISE_TRY(result.instances.errors,
               evaluation::object_errors(result.truth, result.instances.found, most_distance_m));
  SigmaCount count;
  for (const evaluation::ObjectMatch& match : result.instances.errors.matches) {
    count_sigma(count, boxes[match.found].first, boxes[match.found].second,
                result.truth[match.truth].box.center());
  }
  if (count.axes > 0) {
    result.within_two_sigma = static_cast<double>(count.within) / static_cast<double>(count.axes);
  }
  return result;
}

}  // namespace roomwise::pipeline
