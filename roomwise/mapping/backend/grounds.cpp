#include "roomwise/mapping/backend/grounds.h"

#include <algorithm>

#include "roomwise/mapping/graph/up_direction.h"

namespace roomwise::mapping {
namespace {

using Eigen::Vector3d;
using geometry::RigidTransform;

// The places in `ids` of those of each component.
std::map<std::size_t, std::vector<std::size_t>> by_component(
    std::span<const KeyframeId> ids, std::span<const std::size_t> component) {
  std::map<std::size_t, std::vector<std::size_t>> places;
  for (std::size_t i = 0; i < ids.size(); ++i) places[component[ids[i]]].push_back(i);
  return places;
}

}  // namespace

void Grounds::measure(std::span<const KeyframeId> ids, std::span<const KeyframeId> own,
                      std::span<const KeyframeFeatures> features,
                      std::span<const RigidTransform> world_from_keyframe,
                      std::span<const std::optional<Vector3d>> turning_rad_s) {
  for (const auto& [component, places] : by_component(ids, component_)) {
    UpDirectionEstimator estimator;
    for (const std::size_t i : places) {
      const RigidTransform& pose = world_from_keyframe[ids[i]];
      estimator.add_camera(pose);
      if (const auto felt = gravity_.find(ids[i]); felt != gravity_.end())
        estimator.add_gravity(pose.rotation * felt->second);
      for (const Eigen::Vector3f& normal : features[i].normals)
        estimator.add_normal(pose.rotation * normal.cast<double>());
    }
    const UpDirection up = estimator.estimate();
    const auto felt_at = static_cast<double>(
        std::ranges::count_if(places, [&](std::size_t i) { return gravity_.contains(ids[i]); }));
    for (const std::size_t i : places) {
      const auto [one, is_new] = measured_.try_emplace(ids[i]);
      if (!is_new && !std::ranges::binary_search(own, ids[i])) continue;
      one->second.reset();
      if (up.support > 0 && turning_rad_s[ids[i]]) {
        one->second = measure_up(features[i].normals,
                                 world_from_keyframe[ids[i]].rotation.conjugate() * up.up_world,
                                 *turning_rad_s[ids[i]], options_);
      }
      add_felt(ids[i], one->second, felt_at);
    }
  }
}

void Grounds::add_felt(KeyframeId id, std::optional<UpMeasurement>& level, double felt_at) {
  contradicted_.erase(id);
  const auto gravity = gravity_.find(id);
  if (gravity == gravity_.end()) return;
  UpMeasurement felt = felt_up(gravity->second);
  if (level && contradict(*level, felt)) {
    contradicted_.insert(id);
    return;
  }
  // The sensor errs alike at all of them, which are no surer together than one.
  felt.information /= felt_at;
  if (!level) {
    level = felt;
  } else {
    level = together(*level, felt);
  }
}

std::vector<Ground> Grounds::under(std::span<const KeyframeId> ids,
                                   std::span<const RigidTransform> world_from_keyframe,
                                   NodeId first_node, double kernel_sigmas) const {
  const auto told_by = [&](KeyframeId id) -> std::optional<UpMeasurement> {
    const auto one = measured_.find(id);
    return one == measured_.end() ? std::nullopt : one->second;
  };
  std::vector<Ground> grounds;
  for (const auto& [component, places] : by_component(ids, component_)) {
    Vector3d up_world = Vector3d::Zero();
    for (const std::size_t i : places) {
      if (const auto one = told_by(ids[i]))
        up_world += world_from_keyframe[ids[i]].rotation * one->up_camera;
    }
    if (!(up_world.norm() > 0)) continue;
    const NodeId node = first_node + grounds.size();
    Ground& ground = grounds.emplace_back();
    ground.world_from_ground.rotation =
        Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), up_world);
    for (const std::size_t i : places) {
      const auto one = told_by(ids[i]);
      if (!one) continue;
      ground.edges.push_back(up_edge(node, ground.world_from_ground, ids[i],
                                     world_from_keyframe[ids[i]], *one, kernel_sigmas));
    }
    // Loosely: so that the ground does not turn about up, or go elsewhere, as it may.
    ground.edges.front().information += geometry::Matrix6d::Identity();
  }
  return grounds;
}

}  // namespace roomwise::mapping
