#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "roomwise/mapping/frontend/keyframe.h"
#include "roomwise/motion/frame_locator.h"
#include "roomwise/motion/lens_estimate.h"

namespace roomwise::mapping {

// What speaks for a pose that features give without a depth image to check it by.
inline constexpr std::array kPoseEvidenceNames{"log inliers", "log inlier ratio", "log coverage",
                                               "log rival ratio"};
using PoseEvidence = std::array<double, kPoseEvidenceNames.size()>;

// How probable it is that such a pose is right: a logistic regression, fitted by roomwise-lab
// fit-localizer on pictures of other walks and of other homes, each left out of the fit that
// measures it (docs/experiments/localizer-fitted.md).
struct PoseModel {
  double bias = 0;
  PoseEvidence weights{};
  double min_probability = 1;  // of an answer

  [[nodiscard]] double probability(const PoseEvidence& evidence) const;
  [[nodiscard]] static PoseModel fitted();
};

struct LocalizerOptions {
  LocalizerOptions();

  // ---- by features ----
  std::size_t similar = 16;  // key-frames that look most like the picture
  std::size_t places = 4;    // groups of these that are tried, those with the most votes first
  std::size_t together = 3;  // key-frames of a group whose points are matched together
  // Key-frames no further apart and no further turned than this may show the same, m and rad.
  double place_m = 1.2;
  double place_rad = 0.8;
  motion::MotionOptions features;
  // With fewer inliers a pose is doubtful, unless the depth images agree to `sure_agreeing` over an
  // overlap of `sure_overlap`.
  int sure_inliers = 40;
  double sure_overlap = 0.4;
  double sure_agreeing = 0.8;
  // Without a depth image all of that is left to the model.
  PoseModel color_only = PoseModel::fitted();
  // Even fewer inliers, down to so many, are a weak hypothesis: an answer if what the key-frames
  // around show is like the picture in pattern and depth. `min_confirmation` is likeness *
  // agreeing^4, over an overlap of `confirmed_overlap`, of which no more than
  // `max_confirmed_through` is seen through.
  int min_hypothesis_inliers = 5;
  double min_confirmation = 0.35;
  double confirmed_overlap = 0.35;
  double max_confirmed_through = 0.05;
  // Of two poses from different places the one with this many times the inliers is taken.
  double clearly_more_inliers = 1.5;

  // ---- by shape and pattern, where features say nothing ----
  std::size_t similar_shapes = 20;  // key-frames whose depth images look most like the picture's
  // How far from such a key-frame the picture may have been taken, m and rad (standard deviation).
  double shape_sigma_m = 0.3;
  double shape_sigma_rad = 0.2;
  motion::ViewAlignmentOptions shape_views;  // brightness hardly counts
  // Less support (Localization::support) leaves a doubt; and so does another pose with more than
  // this share of it.
  double sure_support = 0.6;
  double max_rival_share = 0.6;
  // A pattern as much like the map's (Localization::pattern_correlation) says that the picture did
  // not slide along a wall. Without it the surfaces must hold the picture in place: the mean square
  // of their normals along each direction is not below this.
  double sure_pattern_correlation = 0.25;
  double min_normal_eigenvalue = 0.001;

  // ---- both ----
  // Light is another on another day, so brightness says less than between the frames of a walk.
  motion::ViewAlignmentOptions views;
  // A pose that is not known better than this is no answer, m and rad.
  double max_position_sigma_m = 0.05;
  double max_rotation_sigma_rad = 0.03;
  // Answers no further apart than these are the same, m and rad.
  double same_m = 0.3;
  double same_rad = 0.2;
  std::uint64_t seed = 1;

  [[nodiscard]] Expected<void> validate() const;
};

enum class LocalizationStatus {
  kNothingSimilar,  // no key-frame looks like it
  kNoMotion,        // too little of it is on the map
  kUnconfirmed,     // a few features hint at a pose, and nothing confirms it
  kContradicted,    // by the depth images
  kDegenerate,      // features and patterns say nothing, and its shape is that of a bare wall
  kDoubtful,        // a pose, but too little speaks for it
  kVague,           // a pose, but not known well enough
  kAmbiguous,       // two poses, and nearly as much speaks for the one as for the other
  kFound,
};
[[nodiscard]] std::string_view to_string(LocalizationStatus status);

// Where a picture was taken, or why that is not known.
struct Localization {
  LocalizationStatus status = LocalizationStatus::kNothingSimilar;
  int matches = 0;
  int inliers = 0;  // different features of the picture
  // The share of the cells of a grid over the picture that hold an inlier.
  double coverage = 0;
  int rival_inliers = 0;  // of the pose from elsewhere that has most
  // The rest means something where there is a pose.
  KeyframeId keyframe = 0;  // that shows the same
  geometry::RigidTransform world_from_camera;
  // Inverse covariance of the pose, in the order and the parameters of an edge of the pose graph.
  geometry::Matrix6d information = geometry::Matrix6d::Zero();
  // With the key-frames around the pose: the largest overlap, the shares of all that overlaps.
  motion::ViewAgreement agreement;
  int supporting_keyframes = 0;  // by shape: key-frames whose alignment led there
  // By shape or a weak hypothesis: of its pattern and theirs around the pose, -1 to 1.
  double pattern_correlation = 0;
  double support = 0;  // by shape: what speaks for the pose; 3 at most
  // Where the camera was not calibrated: what is known of its lens, this picture counted.
  std::optional<motion::IntrinsicsEstimate> lens;

  // By a weak hypothesis that was confirmed: the place is right, if this is the home.
  bool is_weak_hypothesis = false;
  // By the motion from an earlier picture's place: what speaks for it was that picture's evidence.
  bool is_carried = false;

  [[nodiscard]] bool found() const { return status == LocalizationStatus::kFound; }
  // Found, or with something against it.
  [[nodiscard]] bool has_pose() const { return status >= LocalizationStatus::kDoubtful; }
  [[nodiscard]] PoseEvidence evidence() const;  // of features; there must be inliers
  // Standard deviation along the direction that is known worst.
  [[nodiscard]] double position_sigma_m() const;
  [[nodiscard]] double rotation_sigma_rad() const;
};

// Where two pictures were taken, one shortly after the other: the first by itself, the second by
// both.
struct PairLocalization {
  Localization first;
  Localization second;
  bool contradictory = false;  // by the motion between them they cannot both be right
};

}  // namespace roomwise::mapping
