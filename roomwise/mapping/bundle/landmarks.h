#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/geometry/rigid_transform.h"
#include "roomwise/mapping/bundle/bundle_adjustment.h"
#include "roomwise/motion/frame_measurements.h"

namespace roomwise::mapping {

struct LandmarkOptions {
  int max_features = 400;  // of a key-frame, the strongest
  // Two key-frames are compared where each sees at least this share of the other's points ...
  double min_overlap = 0.4;
  // ... and each with no more than about so many, those of the largest overlap.
  int max_partners = 30;
  double search_px = 10;      // a feature is looked for so far from where the poses expect it
  double max_distance = 0.5;  // between descriptors of unit length
  double max_distance_ratio = 0.85;  // to the second nearest of those looked at

  [[nodiscard]] Expected<void> validate() const;
};

// A key-frame's strongest features, made small: what landmarks are found by. Descriptors are taken
// for vectors of unit length (the bits of binary ones for plus and minus, of half that) in 8-bit
// numbers.
struct KeyframeFeatures {
  geometry::PinholeCamera camera;       // its lens is taken out of the views
  std::vector<LandmarkView> views;      // LandmarkView::camera is left at 0
  std::vector<Eigen::Vector3d> points;  // in the camera frame, m; z = 0: no depth
  std::vector<bool> bright;             // Keypoint::bright: the sign of SURF's Laplacian
  // Of the surfaces seen, camera frame, unit length: which way is up is told by them.
  std::vector<Eigen::Vector3f> normals;
  Eigen::Matrix<std::int8_t, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> descriptors;

  [[nodiscard]] std::size_t size() const { return views.size(); }
  [[nodiscard]] bool has_point(std::size_t i) const { return points[i].z() > 0; }
};
// `with_normals`: where nobody asks which way is up they are not worked out.
[[nodiscard]] KeyframeFeatures keyframe_features(const motion::FrameMeasurements& measurements,
                                                 const geometry::PinholeCamera& camera,
                                                 const LandmarkOptions& options = {},
                                                 bool with_normals = true);

// Further apart than this, features look too different.
inline constexpr double kMaxCovisible_m = 3;
inline constexpr double kMaxCovisible_rad = 1.2;
[[nodiscard]] inline bool may_be_covisible(const geometry::RigidTransform& a_from_b) {
  return a_from_b.distance_m() <= kMaxCovisible_m && a_from_b.angle_rad() <= kMaxCovisible_rad;
}

// Key-frames a < b that see much of the same by their poses, sorted. Those of different groups
// (components of the map) see nothing of each other.
struct Covisible {
  std::uint32_t a = 0;
  std::uint32_t b = 0;
};
[[nodiscard]] std::vector<Covisible> covisible_keyframes(
    std::span<const KeyframeFeatures> keyframes,
    std::span<const geometry::RigidTransform> world_from_keyframe,
    std::span<const std::size_t> groups, const LandmarkOptions& options = {});

// Features that show the same point: each pair of covisible key-frames is compared where their
// poses say that a point should be seen again, and what is each other's nearest belongs together;
// the most alike are joined first, and never two features of one key-frame. Points are where the
// depths of the views say, on average; features that no view with depth is joined to are left out.
[[nodiscard]] std::vector<Landmark> find_landmarks(
    std::span<const KeyframeFeatures> keyframes,
    std::span<const geometry::RigidTransform> world_from_keyframe, std::span<const Covisible> pairs,
    const LandmarkOptions& options = {});

}  // namespace roomwise::mapping
