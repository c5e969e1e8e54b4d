#include "roomwise/mapping/localization/localizer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "roomwise/base/testing/testing.h"
#include "roomwise/mapping/localization/place_track.h"
#include "roomwise/motion/testing/test_scenes.h"

namespace roomwise::mapping {
namespace {

using geometry::RigidTransform;
using motion::FrameMeasurements;
using motion::MeasuredFeatures;
using motion::RgbdPyramid;
using motion::testing::box_room;
using motion::testing::kCamera;
using motion::testing::marbled;
using motion::testing::motion_by;
using motion::testing::plain;
using motion::testing::Scene;
using motion::testing::Sight;
using motion::testing::Texture;
using motion::testing::view_of;
using motion::testing::wall;

// The box room with a cupboard, without which it looks the same from in front and from behind.
Scene furnished_room(const Texture& texture = marbled) {
  return [=, room = box_room(texture)](const Eigen::Vector3d& origin,
                                       const Eigen::Vector3d& direction) {
    Sight sight = room(origin, direction);
    const Eigen::Vector3d low(0.5, -0.4, 1.1), high(1.6, 1.1, 1.8);
    const Eigen::Array3d a = (low - origin).array() / direction.array();
    const Eigen::Array3d b = (high - origin).array() / direction.array();
    const double enters = a.min(b).maxCoeff(), leaves = a.max(b).minCoeff();
    if (enters > 0 && enters < leaves && enters < sight.ray_lengths) {
      sight = {enters, texture(origin + enters * direction)};
    }
    return sight;
  };
}

// Points on a scene's surfaces that every camera recognises by their descriptors.
class Landmarks {
 public:
  // With `without_every` n the n-th, 2n-th ... are left out.
  Landmarks(const Scene& scene, int count, std::uint64_t seed, int without_every = 0) {
    RandomStream random(seed);
    descriptors_ = features::FloatDescriptors::NullaryExpr(
        count, 64, [&](Eigen::Index, Eigen::Index) { return static_cast<float>(random.normal()); });
    descriptors_.rowwise().normalize();
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector3d direction(random.normal(), random.normal(), random.normal());
      const bool is_left_out = without_every > 0 && i % without_every == 0;
      points_.push_back(is_left_out
                            ? Eigen::Vector3d(0, 0, 1e6)  // too far to be seen as one
                            : Eigen::Vector3d(scene({0, 0, 0}, direction).ray_lengths * direction));
    }
  }

  // What a camera in a room sees of them; the room may stand elsewhere in the world.
  [[nodiscard]] MeasuredFeatures seen_from(const RigidTransform& room_from_camera,
                                           double noise_px = 0.3, bool has_depth = true) const {
    MeasuredFeatures seen;
    std::vector<Eigen::Index> rows;
    RandomStream random(static_cast<std::uint64_t>(1e6 * room_from_camera.angle_rad()));
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Eigen::Vector3d point = room_from_camera.inverse() * points_[i];
      if (!(point.z() > 0.3)) continue;
      const Eigen::Vector2d noise(random.normal(), random.normal());
      const Eigen::Vector2d pixel = kCamera.project_undistorted(point) + noise_px * noise;
      if (!(pixel.minCoeff() >= 0 && pixel.x() < 639 && pixel.y() < 479)) continue;
      rows.push_back(static_cast<Eigen::Index>(i));
      seen.pixels.push_back(pixel);
      seen.points.push_back(has_depth ? point : Eigen::Vector3d(0, 0, 0));
      seen.features.keypoints.emplace_back();
    }
    seen.features.descriptors = features::FloatDescriptors(descriptors_(rows, Eigen::all));
    return seen;
  }

 private:
  std::vector<Eigen::Vector3d> points_;
  features::FloatDescriptors descriptors_;
};

// What shows the features of both.
MeasuredFeatures joined(MeasuredFeatures all, const MeasuredFeatures& more) {
  auto& rows = std::get<features::FloatDescriptors>(all.features.descriptors);
  const auto& more_rows = std::get<features::FloatDescriptors>(more.features.descriptors);
  features::FloatDescriptors both(rows.rows() + more_rows.rows(), 64);
  both << rows, more_rows;
  rows = both;
  all.pixels.insert(all.pixels.end(), more.pixels.begin(), more.pixels.end());
  all.points.insert(all.points.end(), more.points.begin(), more.points.end());
  all.features.keypoints.resize(all.points.size());
  return all;
}

MeasuredFeatures no_features() {
  MeasuredFeatures none;
  none.features.descriptors = features::FloatDescriptors(0, 64);
  return none;
}

constexpr int kLandmarks = 3000;  // of which a picture shows some two hundred

class LocalizerTest : public ::testing::Test {
 protected:
  // Key-frames that look all around from near the middle of the room, and a little down or up.
  static void look_around(Localizer& localizer, const Landmarks& landmarks, bool with_views,
                          const RigidTransform& world_from_room = {}) {
    for (int i = 0; i < 48; ++i) {
      const RigidTransform room_from_keyframe =
          motion_by({0, i * std::numbers::pi / 24, 0}, {0.1 * std::sin(i), 0, 0.1 * std::cos(i)}) *
          motion_by({i % 2 == 0 ? 0.3 : -0.2, 0, 0}, {0, 0, 0});
      localizer.add({localizer.size(),
                     localizer.size(),
                     0,
                     {landmarks.seen_from(room_from_keyframe),
                      with_views ? view_of(furnished_room(), room_from_keyframe) : RgbdPyramid()}},
                    world_from_room * room_from_keyframe);
    }
  }
  static void expect_there(const Localization& found, const RigidTransform& truth, double max_m,
                           double max_rad) {
    ASSERT_TRUE(found.found()) << to_string(found.status) << ", " << found.inliers << " of "
                               << found.matches << " matches, support " << found.support;
    const RigidTransform error = truth.inverse() * found.world_from_camera;
    EXPECT_LT(error.distance_m(), max_m);
    EXPECT_LT(error.angle_rad(), max_rad);
  }

  const Landmarks landmarks_{furnished_room(), kLandmarks, 1};
  const RigidTransform pose_ = motion_by({0.3, 0.9, -0.03}, {0.25, 0.05, -0.2});
  const RgbdPyramid view_ = view_of(furnished_room(), pose_);
};

TEST_F(LocalizerTest, FeaturesTellThePose) {
  Localizer localizer({});
  look_around(localizer, landmarks_, false);
  const Localization found = localizer.locate({landmarks_.seen_from(pose_), kCamera});
  expect_there(found, pose_, 0.01, 0.005);
  EXPECT_GT(found.inliers, 40);
  EXPECT_EQ(found.supporting_keyframes, 0);
  EXPECT_LT(found.position_sigma_m(), 0.03);
  EXPECT_LT(found.rotation_sigma_rad(), 0.02);
}

TEST_F(LocalizerTest, ADepthImageIsNotNeeded) {
  Localizer localizer({});
  look_around(localizer, landmarks_, true);
  expect_there(localizer.locate({landmarks_.seen_from(pose_, 0.3, false), kCamera}), pose_, 0.02,
               0.01);
}

TEST_F(LocalizerTest, ADepthImageInWhichNothingWasMeasuredIsAsNone) {
  const Landmarks few(furnished_room(), 400, 1);
  Localizer localizer({});
  look_around(localizer, few, true);
  const MeasuredFeatures seen = few.seen_from(pose_, 0.3, false);
  RgbdPyramid blank = view_;
  for (auto& level : blank.levels)
    level.depth = image::DepthImage(level.depth.width(), level.depth.height());
  const Localization without = localizer.locate({seen, kCamera});
  ASSERT_TRUE(without.found());
  ASSERT_LT(without.inliers, LocalizerOptions{}.sure_inliers);
  expect_there(localizer.locate({{seen, blank}, kCamera}), pose_, 0.03, 0.02);
}

// Nor does the principal point lie in the middle here.
TEST_F(LocalizerTest, ACalibrationIsNotNeeded) {
  Localizer localizer({});
  look_around(localizer, landmarks_, true);
  const MeasuredFeatures seen = landmarks_.seen_from(pose_, 0.3, false);
  const Localization found =
      localizer.locate({seen, kCamera, motion::IntrinsicsEstimate::typical_of_phones()});
  expect_there(found, pose_, 0.06, 0.05);
  ASSERT_TRUE(found.lens);
  EXPECT_NEAR(found.lens->camera(kCamera.width, kCamera.height).fx / kCamera.fx, 1, 0.04);
  EXPECT_LT(found.lens->relative_focal_sigma(), 0.02);
}

// All but every n-th feature are now elsewhere, and lie as deep there as they did. How many stayed.
int move_all_but_every(std::size_t n, MeasuredFeatures& seen) {
  RandomStream random(5);
  int left = 0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (i % n == 0) {
      ++left;
      continue;
    }
    seen.pixels[i] = {639 * random.uniform(), 479 * random.uniform()};
    seen.points[i] = kCamera.unproject_undistorted(seen.pixels[i], seen.points[i].z());
  }
  return left;
}

// Some forty of the features that are seen, of which every fifth is where it was.
MeasuredFeatures few_of(const MeasuredFeatures& seen) {
  MeasuredFeatures few;
  std::vector<Eigen::Index> rows;
  const std::size_t step = std::max<std::size_t>(1, seen.size() / 40);
  for (std::size_t i = 0; i < seen.size(); i += step) {
    rows.push_back(static_cast<Eigen::Index>(i));
    few.pixels.push_back(seen.pixels[i]);
    few.points.push_back(seen.points[i]);
    few.features.keypoints.push_back(seen.features.keypoints[i]);
  }
  const auto& all = std::get<features::FloatDescriptors>(seen.features.descriptors);
  few.features.descriptors = features::FloatDescriptors(all(rows, Eigen::all));
  move_all_but_every(5, few);
  return few;
}

TEST_F(LocalizerTest, MostOfWhatWasThereMayHaveMoved) {
  Localizer localizer({});
  look_around(localizer, landmarks_, true);
  MeasuredFeatures seen = landmarks_.seen_from(pose_);
  const int left = move_all_but_every(10, seen);
  ASSERT_GE(left, 12);
  const Localization found = localizer.locate({{seen, view_}, kCamera});
  expect_there(found, pose_, 0.02, 0.01);
  EXPECT_LE(found.inliers, left + 3);
}

// Nothing is found by shape.
LocalizerOptions without_shape() {
  LocalizerOptions options;
  options.sure_support = 10;
  return options;
}

TEST_F(LocalizerTest, AFewFeaturesAreBelievedWherePatternAndDepthConfirmThem) {
  Localizer localizer(without_shape());
  look_around(localizer, landmarks_, true);
  const MeasuredFeatures seen = few_of(landmarks_.seen_from(pose_));
  const Localization found = localizer.locate({{seen, view_}, kCamera});
  expect_there(found, pose_, 0.02, 0.01);
  EXPECT_TRUE(found.is_weak_hypothesis);
  EXPECT_GE(found.inliers, 5);
  EXPECT_LT(found.inliers, 12);
  EXPECT_GT(found.pattern_correlation, 0.5);
  // Nothing confirms them without depth.
  const Localization alone = localizer.locate({seen, kCamera});
  EXPECT_EQ(alone.status, LocalizationStatus::kUnconfirmed);
  EXPECT_FALSE(alone.has_pose());
}

TEST_F(LocalizerTest, AFewFeaturesAreNotBelievedWhereTooLittleConfirmsThem) {
  const MeasuredFeatures seen = few_of(landmarks_.seen_from(pose_));
  const auto is_found_with = [&](const auto& stricter) {
    LocalizerOptions options = without_shape();
    stricter(options);
    Localizer localizer(options);
    look_around(localizer, landmarks_, true);
    return localizer.locate({{seen, view_}, kCamera}).found();
  };
  EXPECT_TRUE(is_found_with([](LocalizerOptions&) {}));
  EXPECT_FALSE(is_found_with([](LocalizerOptions& options) { options.min_confirmation = 1; }))
      << "pattern and depth";
  EXPECT_FALSE(is_found_with([](LocalizerOptions& options) { options.confirmed_overlap = 1; }))
      << "how much of the picture the map shows";
  EXPECT_FALSE(is_found_with([](LocalizerOptions& options) {
    options.min_hypothesis_inliers = 11;
  })) << "how many inliers";
}

TEST_F(LocalizerTest, WhatShapeFindsTooIsMoreThanAHint) {
  Localizer localizer({});
  look_around(localizer, landmarks_, true);
  const Localization found =
      localizer.locate({{few_of(landmarks_.seen_from(pose_)), view_}, kCamera});
  expect_there(found, pose_, 0.02, 0.01);
  EXPECT_FALSE(found.is_weak_hypothesis);
  EXPECT_GT(found.supporting_keyframes, 0);
}

TEST_F(LocalizerTest, AHintIsNoMatchForASurePictureAfterIt) {
  Localizer localizer(without_shape());
  look_around(localizer, landmarks_, true);
  // What binds the two is new in the room.
  const MeasuredFeatures added = Landmarks(furnished_room(), 1000, 2).seen_from(pose_);
  const FrameMeasurements hint{joined(few_of(landmarks_.seen_from(pose_)), added), view_};
  ASSERT_TRUE(localizer.locate({hint, kCamera}).is_weak_hypothesis);
  const FrameMeasurements sure{joined(landmarks_.seen_from(pose_), added), view_};
  // At the same place the hint is no more one; elsewhere the sure one stands.
  const PairLocalization same = localizer.locate({sure, kCamera}, {hint, kCamera});
  EXPECT_TRUE(same.second.found());
  EXPECT_FALSE(same.second.is_weak_hypothesis);
  const PairLocalization after = localizer.locate({hint, kCamera}, {sure, kCamera});
  EXPECT_TRUE(after.second.found());
  EXPECT_FALSE(after.second.is_weak_hypothesis);
  EXPECT_FALSE(after.contradictory);
}

TEST_F(LocalizerTest, AFewFeaturesOfElsewhereAreNotBelieved) {
  Localizer localizer({});
  look_around(localizer, landmarks_, true);
  // They say that the camera looks half a metre to the side of where the picture shows that it
  // does.
  const MeasuredFeatures seen =
      few_of(landmarks_.seen_from(pose_ * motion_by({0, 0, 0}, {0.5, 0, 0})));
  const Localization hint = localizer.locate({seen, kCamera});
  ASSERT_EQ(hint.status, LocalizationStatus::kUnconfirmed) << "or nothing hints at anything";
  ASSERT_GE(hint.inliers, 5);
  const Localization found = localizer.locate({{seen, view_}, kCamera});
  if (found.found()) expect_there(found, pose_, 0.02, 0.01);
  EXPECT_FALSE(found.is_weak_hypothesis) << to_string(found.status);
}

TEST_F(LocalizerTest, WithoutFeaturesTheShapeTells) {
  Localizer localizer({});
  look_around(localizer, landmarks_, true);
  const Localization found = localizer.locate({{no_features(), view_}, kCamera});
  expect_there(found, pose_, 0.02, 0.01);
  EXPECT_GE(found.supporting_keyframes, 2);
  EXPECT_EQ(found.inliers, 0);
}

TEST_F(LocalizerTest, TheShapeIsTheSameInAnotherLight) {
  Localizer localizer({});
  look_around(localizer, landmarks_, true);
  const Texture dim = [](const Eigen::Vector3d& p) { return 30 + 0.2 * marbled(p); };
  expect_there(localizer.locate({{no_features(), view_of(furnished_room(dim), pose_)}, kCamera}),
               pose_, 0.03, 0.015);
}

TEST_F(LocalizerTest, ABareWallIsNoAnswer) {
  Localizer localizer({});
  for (int i = 0; i < 12; ++i) {
    const RigidTransform keyframe = motion_by({0, 0, 0}, {0.3 * i, 0, 0});
    localizer.add({localizer.size(), 0, 0, {no_features(), view_of(wall(2), keyframe)}}, keyframe);
  }
  const Localization found = localizer.locate(
      {{no_features(), view_of(wall(2), motion_by({0, 0, 0}, {1.6, 0, 0}))}, kCamera});
  EXPECT_EQ(found.status, LocalizationStatus::kDegenerate);
  EXPECT_FALSE(found.has_pose());
}

TEST_F(LocalizerTest, WhatIsPaintedOnAWallTellsWhereAlongIt) {
  // By day it was mapped, at night the lamp is at one end.
  const Texture night = [](const Eigen::Vector3d& p) { return (0.15 + 0.1 * p.x()) * marbled(p); };
  Localizer localizer({});
  for (int i = 0; i < 12; ++i) {
    const RigidTransform keyframe = motion_by({0, 0, 0}, {0.3 * i, 0, 0});
    localizer.add({localizer.size(), 0, 0, {no_features(), view_of(wall(2, marbled), keyframe)}},
                  keyframe);
  }
  const RigidTransform there = motion_by({0.02, 0.03, 0}, {1.55, 0, 0.1});
  const Localization same =
      localizer.locate({{no_features(), view_of(wall(2, marbled), there)}, kCamera});
  EXPECT_GT(same.pattern_correlation, 0.8);
  const Localization dark =
      localizer.locate({{no_features(), view_of(wall(2, night), there)}, kCamera});
  EXPECT_GT(dark.pattern_correlation, 0.4);
  // Another wall of the same shape.
  const Texture other = [](const Eigen::Vector3d& p) {
    return marbled({-p.y(), 0.7 * p.x(), 3 * p.z()});
  };
  const Localization elsewhere =
      localizer.locate({{no_features(), view_of(wall(2, other), there)}, kCamera});
  EXPECT_LT(elsewhere.pattern_correlation, LocalizerOptions{}.sure_pattern_correlation);
  EXPECT_EQ(elsewhere.status, LocalizationStatus::kDegenerate);
}

TEST_F(LocalizerTest, APictureOfElsewhereIsNoAnswer) {
  Localizer localizer({});
  look_around(localizer, landmarks_, true);
  const Landmarks others(furnished_room(), kLandmarks, 2);
  EXPECT_FALSE(localizer.locate({others.seen_from(pose_), kCamera}).found());
  // A wall at a slant, nearer than any in the room.
  const RgbdPyramid near_wall = view_of(wall(0.7, marbled), motion_by({0.3, 0.4, 0}, {0, 0, 0}));
  EXPECT_FALSE(localizer.locate({{others.seen_from(pose_), near_wall}, kCamera}).found());
}

TEST_F(LocalizerTest, APosterOfTheRoomIsContradictedByItsDepth) {
  Localizer localizer({});
  look_around(localizer, landmarks_, true);
  MeasuredFeatures flat = landmarks_.seen_from(pose_, 0.3, false);
  const Localization found =
      localizer.locate({{flat, view_of(wall(0.7), motion_by({0, 0, 0}, {0, 0, 0}))}, kCamera});
  EXPECT_FALSE(found.found());
  EXPECT_GT(found.inliers, 40);
}

TEST_F(LocalizerTest, TwinRoomsAreAmbiguous) {
  Localizer localizer({});
  look_around(localizer, landmarks_, true);
  const Localization alone = localizer.locate({{landmarks_.seen_from(pose_), view_}, kCamera});
  expect_there(alone, pose_, 0.01, 0.005);
  look_around(localizer, landmarks_, true, motion_by({0, 0, 0}, {10, 0, 0}));
  EXPECT_EQ(localizer.locate({{landmarks_.seen_from(pose_), view_}, kCamera}).status,
            LocalizationStatus::kAmbiguous);
  EXPECT_EQ(localizer.locate({{no_features(), view_}, kCamera}).status,
            LocalizationStatus::kAmbiguous)
      << "by shape";

  // Two pictures that both show the twins leave it open, though their motion fits.
  const RigidTransform next = pose_ * motion_by({0, 0.1, 0}, {0.05, 0, 0});
  const FrameMeasurements first{landmarks_.seen_from(pose_), view_};
  const FrameMeasurements second{landmarks_.seen_from(next), view_of(furnished_room(), next)};
  EXPECT_EQ(localizer.locate({first, kCamera}, {second, kCamera}).second.status,
            LocalizationStatus::kAmbiguous);
}

TEST_F(LocalizerTest, ATwinOfNearlyAsManyInliersIsARival) {
  Localizer localizer({});
  look_around(localizer, landmarks_, false);
  // The twin shows four fifths of the landmarks, and is not sure by itself.
  const RigidTransform twin = motion_by({0, 0, 0}, {10, 0, 0});
  MeasuredFeatures seen = landmarks_.seen_from(pose_);
  LocalizerOptions strict;
  const int inliers = localizer.locate({seen, kCamera}).inliers;
  strict.sure_inliers = inliers - 1;
  const Landmarks fewer(furnished_room(), kLandmarks, 1, 5);
  Localizer doubled(strict);
  look_around(doubled, landmarks_, false);
  ASSERT_TRUE(doubled.locate({seen, kCamera}).found());
  look_around(doubled, fewer, false, twin);
  EXPECT_EQ(doubled.locate({seen, kCamera}).status, LocalizationStatus::kAmbiguous);
}

TEST_F(LocalizerTest, AnotherCamerasDepthImageIsNotComparedByShape) {
  Localizer localizer({});
  look_around(localizer, landmarks_, true);
  RgbdPyramid other = view_;
  for (motion::PyramidLevel& level : other.levels) level.camera.fx *= 1.2;
  EXPECT_FALSE(localizer.locate({{no_features(), other}, kCamera}).found());
}

TEST_F(LocalizerTest, AnEmptyMapKnowsNothing) {
  const Localizer localizer({});
  EXPECT_EQ(localizer.locate({{landmarks_.seen_from(pose_), view_}, kCamera}).status,
            LocalizationStatus::kNothingSimilar);
}

TEST_F(LocalizerTest, TwoPicturesTellTheSecondsPlace) {
  Localizer localizer({});
  look_around(localizer, landmarks_, true);
  const RigidTransform motion = motion_by({0.01, 0.1, 0}, {0.05, 0, 0.04});
  const FrameMeasurements first{landmarks_.seen_from(pose_), view_};
  const RigidTransform second_pose = pose_ * motion;
  const FrameMeasurements second{landmarks_.seen_from(second_pose),
                                 view_of(furnished_room(), second_pose)};
  const PairLocalization both = localizer.locate({first, kCamera}, {second, kCamera});
  expect_there(both.first, pose_, 0.01, 0.005);
  expect_there(both.second, second_pose, 0.01, 0.005);
  EXPECT_FALSE(both.contradictory);

  // Landmarks that only the two pictures show tie the second to the first.
  const Landmarks new_things(furnished_room(), kLandmarks, 3);
  const FrameMeasurements unknown{new_things.seen_from(second_pose)};
  EXPECT_FALSE(localizer.locate({unknown, kCamera}).found());
  const FrameMeasurements known{joined(landmarks_.seen_from(pose_), new_things.seen_from(pose_)),
                                view_};
  expect_there(localizer.locate({known, kCamera}, {unknown, kCamera}).second, second_pose, 0.03,
               0.02);
}

TEST_F(LocalizerTest, APictureThatAloneTellsNothingIsFollowedFromTheOneBefore) {
  Localizer localizer({});
  look_around(localizer, landmarks_, true);
  const RigidTransform motion = motion_by({0.01, 0.1, 0}, {0.05, 0, 0.04});
  const RigidTransform next_pose = pose_ * motion;
  // What only the two pictures show.
  const Landmarks new_things(furnished_room(), kLandmarks, 3);
  const FrameMeasurements before{joined(landmarks_.seen_from(pose_), new_things.seen_from(pose_)),
                                 view_};
  const FrameMeasurements next{new_things.seen_from(next_pose)};
  ASSERT_FALSE(localizer.locate({next, kCamera}).found());
  const Localization place = localizer.locate({before, kCamera});
  ASSERT_TRUE(place.found());
  const Localization followed = localizer.follow({before, kCamera}, place, {next, kCamera}).place;
  expect_there(followed, next_pose, 0.03, 0.02);
  EXPECT_GT(followed.position_sigma_m(), place.position_sigma_m());
  // And on from there, until the place is no more known well enough.
  Localization further = followed;
  int steps = 0;
  for (; further.found() && steps < 1000; ++steps) {
    further = localizer.follow({next, kCamera}, further, {next, kCamera}).place;
  }
  EXPECT_GT(steps, 3);
  EXPECT_EQ(further.status, LocalizationStatus::kVague);
  // Nothing follows from a picture without a place.
  EXPECT_FALSE(localizer.follow({before, kCamera}, {}, {next, kCamera}).place.found());
}

// Two rooms ten metres apart; in both stands what binds two pictures.
class TwoRoomsLocalizerTest : public LocalizerTest {
 protected:
  TwoRoomsLocalizerTest() {
    look_around(localizer_, landmarks_, true);
    look_around(localizer_, others_, true, motion_by({0, 0, 0}, {10, 0, 0}));
  }
  [[nodiscard]] MeasuredFeatures showing(const Landmarks& landmarks) const {
    return joined(landmarks.seen_from(pose_), common_.seen_from(pose_));
  }

  Localizer localizer_{{}};
  const Landmarks others_{furnished_room(), kLandmarks, 2},
      common_{furnished_room(), kLandmarks, 3};
  const FrameMeasurements here_{showing(landmarks_)}, there_{showing(others_)};
};

// Somebody stands and turns their head to what looks like another room's.
TEST_F(TwoRoomsLocalizerTest, ATrackBelievesNoPlaceThatItsMotionDoesNotLeadTo) {
  PlaceTrack track;
  expect_there(track.locate(localizer_, here_, kCamera, 0), pose_, 0.03, 0.02);
  // However often it looks the same.
  for (const double t_s : {0.5, 1.0, 2.5, 3.0}) {
    EXPECT_FALSE(track.locate(localizer_, there_, kCamera, t_s).found()) << t_s;
  }
  expect_there(track.locate(localizer_, here_, kCamera, 3.5), pose_, 0.03, 0.02);
  // Also where nothing binds the two, and they stand before it for long.
  track.forget();
  const FrameMeasurements only_here{landmarks_.seen_from(pose_)},
      only_there{others_.seen_from(pose_)};
  ASSERT_TRUE(track.locate(localizer_, only_here, kCamera, 0).found());
  for (double t_s = 0.5; t_s < 20; t_s += 0.5) {
    EXPECT_FALSE(track.locate(localizer_, only_there, kCamera, t_s).found()) << t_s;
  }
  expect_there(track.locate(localizer_, only_here, kCamera, 20.5), pose_, 0.03, 0.02);
  // Where it was the first that deceived, two others from different points of view end it.
  track.forget();
  ASSERT_TRUE(track.locate(localizer_, there_, kCamera, 3.6).found());
  EXPECT_FALSE(track.locate(localizer_, here_, kCamera, 3.7).found());
  EXPECT_FALSE(track.locate(localizer_, here_, kCamera, 3.8).found()) << "the same once more";
  const RigidTransform aside = pose_ * motion_by({0, 0.1, 0}, {0.3, 0, 0});
  const FrameMeasurements moved{joined(landmarks_.seen_from(aside), common_.seen_from(aside))};
  expect_there(track.locate(localizer_, moved, kCamera, 3.9), aside, 0.03, 0.02);
  expect_there(track.locate(localizer_, here_, kCamera, 4.0), pose_, 0.03, 0.02);
  // After a while without pictures anything may have happened.
  EXPECT_TRUE(track.locate(localizer_, there_, kCamera, 13.5).found());
  track.forget();
  EXPECT_TRUE(track.locate(localizer_, here_, kCamera, 13.6).found());
}

TEST_F(TwoRoomsLocalizerTest, TwoPicturesThatContradictEachOtherAreNoAnswer) {
  ASSERT_TRUE(localizer_.locate({here_, kCamera}).found());
  ASSERT_TRUE(localizer_.locate({there_, kCamera}).found());
  const PairLocalization both = localizer_.locate({here_, kCamera}, {there_, kCamera});
  EXPECT_EQ(both.second.status, LocalizationStatus::kAmbiguous);
  EXPECT_TRUE(both.first.found()) << "by itself";
  EXPECT_TRUE(both.contradictory);
}

TEST_F(LocalizerTest, SameBitsTwice) {
  Localizer first({}), second({});
  look_around(first, landmarks_, true);
  look_around(second, landmarks_, true);
  const FrameMeasurements picture{landmarks_.seen_from(pose_, 1), view_};
  const Localization a = first.locate({picture, kCamera}), b = second.locate({picture, kCamera});
  ASSERT_TRUE(a.found());
  EXPECT_EQ(a.world_from_camera.translation, b.world_from_camera.translation);
  EXPECT_EQ(a.information, b.information);
}

TEST(LocalizerOptions, AreChecked) {
  LocalizerOptions hints;
  hints.min_hypothesis_inliers = 3;
  EXPECT_ERROR(hints.validate(), "min_hypothesis_inliers = 3");
  hints = {};
  hints.min_confirmation = 0;
  EXPECT_ERROR(hints.validate(), "min_confirmation = 0");
  EXPECT_OK(LocalizerOptions().validate());
  LocalizerOptions options;
  options.places = 0;
  EXPECT_ERROR(options.validate(), "places");
  options = {};
  options.sure_agreeing = 1.5;
  EXPECT_ERROR(options.validate(), "sure_agreeing");
  options = {};
  options.same_m = std::nan("");
  EXPECT_ERROR(options.validate(), "same_m");
  options = {};
  options.clearly_more_inliers = 0.5;
  EXPECT_ERROR(options.validate(), "clearly_more_inliers");
}

}  // namespace
}  // namespace roomwise::mapping
