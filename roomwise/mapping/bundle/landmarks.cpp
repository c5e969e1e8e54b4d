#include "roomwise/mapping/bundle/landmarks.h"

#include <algorithm>
#include <cmath>
#include <variant>

#include "roomwise/mapping/bundle/feature_tracks.h"
#include "roomwise/mapping/bundle/guided_matching.h"
#include "roomwise/mapping/graph/up_direction.h"

namespace roomwise::mapping {
namespace {

using geometry::PinholeCamera;
using geometry::RigidTransform;

// Entries of a unit vector in 8 bits; those above a half are rare.
constexpr float kUnit = 254;

std::int8_t in_eight_bits(float entry) {
  return static_cast<std::int8_t>(std::lround(std::clamp(entry * kUnit, -127.0F, 127.0F)));
}

void take_descriptor(const features::FloatDescriptors& all, Eigen::Index from,
                     KeyframeFeatures& taken, Eigen::Index to) {
  for (Eigen::Index k = 0; k < all.cols(); ++k)
    taken.descriptors(to, k) = in_eight_bits(all(from, k));
}
void take_descriptor(const features::BinaryDescriptors& all, Eigen::Index from,
                     KeyframeFeatures& taken, Eigen::Index to) {
  // Of half the length: alike bits differ about as much as alike real descriptors.
  const float entry = 0.5F / std::sqrt(static_cast<float>(8 * all.cols()));
  for (Eigen::Index bit = 0; bit < 8 * all.cols(); ++bit) {
    const bool is_set = ((all(from, bit / 8) >> (bit % 8)) & 1) != 0;
    taken.descriptors(to, bit) = in_eight_bits(is_set ? entry : -entry);
  }
}

Eigen::Index length_of(const features::FloatDescriptors& all) {
  return all.cols();
}
Eigen::Index length_of(const features::BinaryDescriptors& all) {
  return 8 * all.cols();
}

// The share of a key-frame's points that another one's picture holds.
double share_seen(const KeyframeFeatures& from, const RigidTransform& to_from_from,
                  const KeyframeFeatures& to) {
  constexpr std::size_t kStride = 8;  // an eighth of the points tells enough
  int points = 0;
  int seen = 0;
  for (std::size_t i = 0; i < from.size(); i += kStride) {
    if (!from.has_point(i)) continue;
    ++points;
    if (is_in_picture(to_from_from * from.points[i], to.camera)) ++seen;
  }
  return points == 0 ? 0 : static_cast<double>(seen) / points;
}

}  // namespace

Expected<void> LandmarkOptions::validate() const {
  if (max_features < 1) return fail("max_features = {} must be at least 1", max_features);
  if (!(min_overlap >= 0 && min_overlap <= 1))
    return fail("min_overlap = {} must be between 0 and 1", min_overlap);
  if (max_partners < 1) return fail("max_partners = {} must be at least 1", max_partners);
  if (!(search_px > 0)) return fail("search_px = {} must be positive", search_px);
  if (!(max_distance > 0)) return fail("max_distance = {} must be positive", max_distance);
  if (!(max_distance_ratio > 0 && max_distance_ratio <= 1))
    return fail("max_distance_ratio = {} must be above 0 and at most 1", max_distance_ratio);
  return {};
}

KeyframeFeatures keyframe_features(const motion::FrameMeasurements& measurements,
                                   const PinholeCamera& camera, const LandmarkOptions& options,
                                   bool with_normals) {
  const motion::MeasuredFeatures& features = measurements.features();
  KeyframeFeatures taken;
  if (with_normals && !measurements.view().empty()) {
    const motion::PyramidLevel& view = measurements.view().levels.front();
    taken.normals = surface_normals(view.depth, view.camera);
  }
  taken.camera = camera;
  const std::size_t count =
      std::min(features.size(), static_cast<std::size_t>(options.max_features));
  std::visit(
      [&](const auto& descriptors) {
        taken.descriptors.resize(static_cast<Eigen::Index>(count), length_of(descriptors));
        for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(count); ++i)
          take_descriptor(descriptors, i, taken, i);
      },
      features.features.descriptors);
  for (std::size_t i = 0; i < count; ++i) {
    const features::Keypoint& keypoint = features.features.keypoints[i];
    const double row = static_cast<double>(keypoint.position_px.y()) / (camera.height - 1) - 0.5;
    const double depth_m = features.has_point(i) ? features.points[i].z() : 0;
    taken.views.push_back({0, features.pixels[i], depth_m, row});
    taken.points.push_back(features.has_point(i) ? features.points[i] : Eigen::Vector3d::Zero());
    taken.bright.push_back(keypoint.bright);
  }
  return taken;
}

std::vector<Covisible> covisible_keyframes(std::span<const KeyframeFeatures> keyframes,
                                           std::span<const RigidTransform> world_from_keyframe,
                                           std::span<const std::size_t> groups,
                                           const LandmarkOptions& options) {
  struct Partner {
    double overlap;
    std::uint32_t id;
  };
  std::vector<std::vector<Partner>> partners(keyframes.size());
  for (std::uint32_t a = 0; a < keyframes.size(); ++a) {
    for (std::uint32_t b = a + 1; b < keyframes.size(); ++b) {
      if (groups[a] != groups[b]) continue;
      const RigidTransform a_from_b = world_from_keyframe[a].inverse() * world_from_keyframe[b];
      if (!may_be_covisible(a_from_b)) continue;
      double overlap = share_seen(keyframes[a], a_from_b.inverse(), keyframes[b]);
      if (overlap < options.min_overlap) continue;
      overlap = std::min(overlap, share_seen(keyframes[b], a_from_b, keyframes[a]));
      if (overlap < options.min_overlap) continue;
      partners[a].push_back({overlap, b});
      partners[b].push_back({overlap, a});
    }
  }
  std::vector<Covisible> pairs;
  for (std::uint32_t a = 0; a < keyframes.size(); ++a) {
    std::ranges::stable_sort(partners[a], std::greater<>(), &Partner::overlap);
    const std::size_t count =
        std::min(partners[a].size(), static_cast<std::size_t>(options.max_partners));
    for (std::size_t i = 0; i < count; ++i)
      pairs.push_back({std::min(a, partners[a][i].id), std::max(a, partners[a][i].id)});
  }
  const auto by_ids = [](const Covisible& pair) { return std::pair(pair.a, pair.b); };
  std::ranges::sort(pairs, {}, by_ids);
  const auto repeated = std::ranges::unique(pairs, {}, by_ids);
  pairs.erase(repeated.begin(), repeated.end());
  return pairs;
}

std::vector<Landmark> find_landmarks(std::span<const KeyframeFeatures> keyframes,
                                     std::span<const RigidTransform> world_from_keyframe,
                                     std::span<const Covisible> pairs,
                                     const LandmarkOptions& options) {
  const GuidedMatcher matcher(keyframes,
                              {options.search_px, kUnit * static_cast<float>(options.max_distance),
                               static_cast<float>(options.max_distance_ratio)});
  std::vector<FeatureMatch> matches;
  for (const Covisible& pair : pairs) {
    matcher.match(pair.a, pair.b,
                  world_from_keyframe[pair.b].inverse() * world_from_keyframe[pair.a], matches);
  }
  std::vector<std::size_t> sizes;
  for (const KeyframeFeatures& keyframe : keyframes) sizes.push_back(keyframe.size());
  std::vector<Landmark> landmarks;
  for (const FeatureTrack& track : join_tracks(sizes, std::move(matches))) {
    Landmark landmark;
    double weights = 0;
    for (const FeatureId& feature : track) {
      const KeyframeFeatures& keyframe = keyframes[feature.keyframe];
      LandmarkView& view = landmark.views.emplace_back(keyframe.views[feature.index]);
      view.camera = feature.keyframe;
      if (view.depth_m == 0) continue;
      const double weight = std::pow(view.depth_m, -4);  // the noise grows with the square
      landmark.point_world +=
          weight * (world_from_keyframe[feature.keyframe] * keyframe.points[feature.index]);
      weights += weight;
    }
    if (weights == 0) continue;
    landmark.point_world /= weights;
    landmarks.push_back(std::move(landmark));
  }
  return landmarks;
}

}  // namespace roomwise::mapping
