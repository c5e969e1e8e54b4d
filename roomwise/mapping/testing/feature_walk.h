#pragma once

#include <vector>

#include "roomwise/mapping/bundle/landmarks.h"
#include "roomwise/mapping/testing/synthetic_bundle.h"

namespace roomwise::mapping::testing {

// The scene's views as features that key-frames measured: each landmark has a descriptor of its
// own.
struct FeatureWalk {
  std::vector<motion::MeasuredFeatures> features;     // by camera
  std::vector<std::vector<std::size_t>> landmark_of;  // by camera and feature
};

inline FeatureWalk feature_walk(const Bundle& bundle) {
  constexpr Eigen::Index kLength = 64;
  RandomStream random(77);
  FeatureWalk walk;
  walk.features.resize(bundle.cameras.size());
  walk.landmark_of.resize(bundle.cameras.size());
  std::vector<Eigen::VectorXf> descriptors;
  for (std::size_t i = 0; i < bundle.landmarks.size(); ++i) {
    Eigen::VectorXf descriptor(kLength);
    for (float& entry : descriptor) entry = static_cast<float>(random.normal());
    descriptors.push_back(descriptor.normalized());
    for (const LandmarkView& view : bundle.landmarks[i].views) {
      motion::MeasuredFeatures& seen = walk.features[view.camera];
      features::Keypoint keypoint;
      keypoint.position_px = view.pixel.cast<float>();
      seen.features.keypoints.push_back(keypoint);
      seen.pixels.push_back(view.pixel);
      seen.points.push_back(
          bundle.models[0].camera.unproject_undistorted(view.pixel, view.depth_m));
      walk.landmark_of[view.camera].push_back(i);
    }
  }
  for (std::size_t c = 0; c < walk.features.size(); ++c) {
    features::FloatDescriptors rows(static_cast<Eigen::Index>(walk.landmark_of[c].size()), kLength);
    for (std::size_t i = 0; i < walk.landmark_of[c].size(); ++i)
      rows.row(static_cast<Eigen::Index>(i)) = descriptors[walk.landmark_of[c][i]];
    walk.features[c].features.descriptors = std::move(rows);
  }
  return walk;
}

inline std::vector<KeyframeFeatures> small_features(const FeatureWalk& walk,
                                                    const geometry::PinholeCamera& camera) {
  std::vector<KeyframeFeatures> small;
  for (const motion::MeasuredFeatures& features : walk.features)
    small.push_back(keyframe_features(features, camera));
  return small;
}

inline std::vector<geometry::RigidTransform> poses_of(const Bundle& bundle) {
  std::vector<geometry::RigidTransform> poses;
  for (const RollingShutterCamera& camera : bundle.cameras)
    poses.push_back(camera.world_from_camera);
  return poses;
}

}  // namespace roomwise::mapping::testing
