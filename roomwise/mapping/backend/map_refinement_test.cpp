#include "roomwise/mapping/backend/map_refinement.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "roomwise/base/testing/testing.h"
#include "roomwise/mapping/testing/feature_walk.h"

namespace roomwise::mapping {
namespace {

using geometry::RigidTransform;
using geometry::Vector6d;
using testing::SceneOptions;
using testing::SyntheticScene;

constexpr TimestampNs kStep_ns = 200'000'000;
constexpr TimestampNs kBetweenFrames_ns = 30'000'000;

// A map of the scene: steps between neighbours that err, features, and frames just before and after
// each key-frame that tell its motion.
struct Map {
  explicit Map(const SceneOptions& scene_options, double step_error_m)
      : scene(scene_options), camera(scene.truth().models[0].camera) {
    RandomStream random(9);
    const Bundle& truth = scene.truth();
    has_landmarks.assign(truth.cameras.size(), true);
    features = testing::small_features(testing::feature_walk(truth), camera);
    edges = truth.edges;
    for (PoseGraphEdge& edge : edges) {
      edge.from_from_to =
          edge.from_from_to * testing::random_transform(random, step_error_m, step_error_m);
    }
    for (std::size_t id = 0; id < truth.cameras.size(); ++id) {
      times.push_back(kStep_ns * static_cast<TimestampNs>(id + 1));
      const Vector6d step = kBetweenFrames_ns * kSecondsPerNs * truth.cameras[id].velocity;
      for (const int side : {-1, 0, 1}) {
        frames.push_back({3 * id + static_cast<std::uint64_t>(side + 1),
                          times.back() + side * kBetweenFrames_ns,
                          FramePlace{id, RigidTransform::exp(side * step)},
                          {}});
      }
    }
  }

  [[nodiscard]] MapSolution solution() const { return solve_map(times.size(), edges).value(); }
  [[nodiscard]] Expected<MapRefinement> refined(const RefinementOptions& options = {}) const {
    SilentProgress silent;
    const std::vector<RefinedWalk> walks{{0, frames, camera}};
    const auto find = [&](std::span<const KeyframeId> ids) {
      std::vector<KeyframeFeatures> found;
      max_at_once = std::max(max_at_once, ids.size());
      for (const KeyframeId id : ids)
        if (id < features.size()) found.push_back(features[id]);
      return Expected<std::vector<KeyframeFeatures>>(std::move(found));
    };
    return refine_map(solution(), {edges, find, has_landmarks, times, walks}, {}, options, silent);
  }
  [[nodiscard]] double worst_error_m(const std::vector<RigidTransform>& poses) const {
    const auto truth = testing::poses_of(scene.truth());
    double worst = 0;
    for (std::size_t id = 0; id < poses.size(); ++id) {
      const RigidTransform expected = truth[0].inverse() * truth[id];
      worst = std::max(worst, (poses[id].translation - expected.translation).norm());
    }
    return worst;
  }

  // Of a key-frame as the one before it sees it.
  [[nodiscard]] double mean_step_error_m(const std::vector<RigidTransform>& poses) const {
    const auto truth = testing::poses_of(scene.truth());
    double sum = 0;
    for (std::size_t id = 1; id < poses.size(); ++id) {
      const RigidTransform expected = truth[id - 1].inverse() * truth[id];
      sum += ((poses[id - 1].inverse() * poses[id]).translation - expected.translation).norm();
    }
    return sum / static_cast<double>(poses.size() - 1);
  }

  SyntheticScene scene;
  geometry::PinholeCamera camera;
  std::vector<PoseGraphEdge> edges;
  std::vector<KeyframeFeatures> features;
  std::vector<TimestampNs> times;
  std::vector<Frame> frames;
  std::vector<bool> has_landmarks;
  mutable std::size_t max_at_once = 0;  // key-frames whose features were asked for
};

double farthest_apart_m(const std::vector<RigidTransform>& poses,
                        const std::vector<RigidTransform>& others) {
  double farthest_m = 0;
  for (std::size_t id = 0; id < poses.size(); ++id)
    farthest_m = std::max(farthest_m, (poses[id].translation - others[id].translation).norm());
  return farthest_m;
}

// Windows of five key-frames with five around them.
RefinementOptions small_windows() {
  RefinementOptions options;
  options.max_keyframes = 15;
  return options;
}

TEST(RefineMap, IsBetterThanThePoseGraph) {
  const Map map({.landmarks = 600, .noise_sigmas = 0.5}, 0.004);
  const auto refined = map.refined();
  ASSERT_OK(refined);
  EXPECT_GT(refined->landmarks, 100U);
  EXPECT_GT(refined->views, 3 * refined->landmarks);
  EXPECT_LT(map.worst_error_m(refined->world_from_keyframe),
            0.3 * map.worst_error_m(map.solution().world_from_keyframe));
  EXPECT_LT(std::abs(refined->readout_s.value()), 0.001);
}

TEST(RefineMap, FindsARollingShutter) {
  const Map map({.landmarks = 600, .noise_sigmas = 0.3, .readout_s = 0.02}, 0.002);
  const auto refined = map.refined();
  ASSERT_OK(refined);
  EXPECT_NEAR(refined->readout_s.value(), 0.02, 0.002);
  EXPECT_LT(map.worst_error_m(refined->world_from_keyframe), 0.01);
}

TEST(RefineMap, KeepsComponentsApartAndTheirFirstKeyframesFixed) {
  Map map({.landmarks = 600, .noise_sigmas = 0.5}, 0.002);
  map.edges.erase(map.edges.begin() + 6);  // two components: 0 to 6 and 7 to 11
  const MapSolution solution = map.solution();
  ASSERT_EQ(solution.components, 2U);
  const auto refined = map.refined();
  ASSERT_OK(refined);
  for (const std::size_t first : {0U, 7U}) {
    EXPECT_EQ(refined->world_from_keyframe[first].translation,
              solution.world_from_keyframe[first].translation);
  }
  EXPECT_NE(refined->world_from_keyframe[8].translation,
            solution.world_from_keyframe[8].translation);
}

TEST(RefineMap, WithoutFeaturesThePoseGraphStays) {
  Map map({.landmarks = 50}, 0.002);
  map.features.assign(map.features.size(), {});
  const auto refined = map.refined();
  ASSERT_OK(refined);
  EXPECT_EQ(refined->landmarks, 0U);
  const auto solution = map.solution();
  for (std::size_t id = 0; id < map.times.size(); ++id) {
    EXPECT_LT((refined->world_from_keyframe[id].translation -
               solution.world_from_keyframe[id].translation)
                  .norm(),
              1e-6);
  }
}

TEST(RefineMap, GivesTheSameBitsAgain) {
  const Map map({.noise_sigmas = 0.5, .readout_s = 0.01}, 0.004);
  const auto once = map.refined();
  const auto again = map.refined();
  ASSERT_OK(once);
  ASSERT_OK(again);
  EXPECT_EQ(once->readout_s, again->readout_s);
  for (std::size_t id = 0; id < map.times.size(); ++id) {
    EXPECT_EQ(once->world_from_keyframe[id].translation,
              again->world_from_keyframe[id].translation);
  }
}

TEST(RefineMap, NeedsFeaturesOfAllKeyframes) {
  Map map({.landmarks = 50}, 0);
  map.features.pop_back();
  EXPECT_ERROR(map.refined(), "features of 11");
}

// A walk by bare walls, whose steps bend it upwards a little each: the floor and a wall are all
// that it shows.
Map bent_map() {
  Map map({.cameras = 24, .landmarks = 50}, 0);
  for (PoseGraphEdge& edge : map.edges)
    edge.from_from_to.rotation =
        edge.from_from_to.rotation * Eigen::AngleAxisd(0.004, Eigen::Vector3d::UnitX());
  map.features.assign(map.features.size(), {});
  const auto truth = testing::poses_of(map.scene.truth());
  for (std::size_t id = 0; id < truth.size(); ++id) {
    for (const Eigen::Vector3d& seen : {Eigen::Vector3d(0, -1, 0), Eigen::Vector3d(0, 0, -1)}) {
      const Eigen::Vector3d normal = truth[id].rotation.conjugate() * seen;
      map.features[id].normals.insert(map.features[id].normals.end(), 100, normal.cast<float>());
    }
  }
  return map;
}

double worst_tilt_rad(const Map& map, const std::vector<RigidTransform>& poses) {
  const auto truth = testing::poses_of(map.scene.truth());
  double worst = 0;
  for (std::size_t id = 0; id < poses.size(); ++id) {
    const Eigen::Vector3d up =
        poses[id].rotation *
        (truth[id].rotation.conjugate() * (truth[0].rotation * Eigen::Vector3d(0, -1, 0)));
    worst = std::max(worst, std::acos(std::min(1.0, -up.y())));
  }
  return worst;
}

TEST(RefineMap, FloorsAndWallsHoldItUpright) {
  const Map map = bent_map();
  EXPECT_GT(worst_tilt_rad(map, map.solution().world_from_keyframe), 0.08);
  RefinementOptions without;
  without.uses_gravity = false;
  RefinementOptions windows = small_windows();
  const auto upright = map.refined();
  const auto in_windows = map.refined(windows);
  const auto bent = map.refined(without);
  ASSERT_OK(upright);
  ASSERT_OK(in_windows);
  ASSERT_OK(bent);
  EXPECT_LT(worst_tilt_rad(map, upright->world_from_keyframe), 0.02);
  EXPECT_LT(worst_tilt_rad(map, in_windows->world_from_keyframe), 0.02);
  EXPECT_GT(worst_tilt_rad(map, bent->world_from_keyframe), 0.08);
}

TEST(RefineMap, AWalkOfFewFramesASecondIsHeldUprightByHowItTurnsOnTheWhole) {
  Map slow = bent_map();
  for (Frame& frame : slow.frames) frame.timestamp_ns *= 10;
  for (TimestampNs& time : slow.times) time *= 10;
  EXPECT_GT(worst_tilt_rad(slow, slow.solution().world_from_keyframe), 0.08);
  const auto upright = slow.refined();
  ASSERT_OK(upright);
  EXPECT_LT(worst_tilt_rad(slow, upright->world_from_keyframe), 0.02);
}

TEST(RefineMap, WhereNoFrameTellsHowTheCameraTurnedNothingIsHeldUpright) {
  Map alone = bent_map();
  alone.frames.clear();
  const auto bent = alone.refined();
  ASSERT_OK(bent);
  EXPECT_GT(worst_tilt_rad(alone, bent->world_from_keyframe), 0.08);
}

TEST(RefineMap, ComponentsStandOnGroundsOfTheirOwn) {
  Map map = bent_map();
  map.edges.erase(map.edges.begin() + 11);  // two components: 0 to 11 and 12 to 23
  const auto refined = map.refined();
  ASSERT_OK(refined);
  const auto truth = testing::poses_of(map.scene.truth());
  for (const std::size_t first : {0U, 12U}) {
    for (std::size_t id = first; id < first + 12; ++id) {
      const auto turned = refined->world_from_keyframe[first].rotation.conjugate() *
                          refined->world_from_keyframe[id].rotation;
      const auto expected = truth[first].rotation.conjugate() * truth[id].rotation;
      EXPECT_LT(turned.angularDistance(expected), 0.02) << id;
    }
  }
}

TEST(RefineMap, InWindowsALargeMapIsAsGoodAsAdjustedWhole) {
  const Map map({.cameras = 40, .landmarks = 900, .noise_sigmas = 0.5}, 0.004);
  const auto whole = map.refined();
  const auto in_windows = map.refined(small_windows());
  ASSERT_OK(whole);
  ASSERT_OK(in_windows);
  EXPECT_GT(in_windows->landmarks, 100U);
  EXPECT_LT(map.mean_step_error_m(in_windows->world_from_keyframe),
            1.1 * map.mean_step_error_m(whole->world_from_keyframe));
  EXPECT_LT(map.worst_error_m(in_windows->world_from_keyframe),
            1.1 * map.worst_error_m(whole->world_from_keyframe));
  EXPECT_LT(map.worst_error_m(in_windows->world_from_keyframe),
            0.5 * map.worst_error_m(map.solution().world_from_keyframe));
}

TEST(RefineMap, InWindowsNoMoreFeaturesAreHeldThanTheBoundSays) {
  const Map map({.cameras = 40, .landmarks = 600, .noise_sigmas = 0.5}, 0.002);
  ASSERT_OK(map.refined(small_windows()));
  EXPECT_LE(map.max_at_once, 10U);
}

TEST(RefineMap, InWindowsARollingShutterIsFoundByThemTogether) {
  const Map map({.cameras = 24, .landmarks = 900, .noise_sigmas = 0.3, .readout_s = 0.02}, 0.002);
  const auto refined = map.refined(small_windows());
  ASSERT_OK(refined);
  EXPECT_NEAR(refined->readout_s.value(), 0.02, 0.004);
}

TEST(RefineMap, InWindowsFirstKeyframesOfComponentsStay) {
  Map map({.cameras = 24, .landmarks = 600, .noise_sigmas = 0.5}, 0.002);
  map.edges.erase(map.edges.begin() + 11);  // two components: 0 to 11 and 12 to 23
  const MapSolution solution = map.solution();
  const auto refined = map.refined(small_windows());
  ASSERT_OK(refined);
  for (const std::size_t first : {0U, 12U}) {
    EXPECT_EQ(refined->world_from_keyframe[first].translation,
              solution.world_from_keyframe[first].translation);
  }
  EXPECT_NE(refined->world_from_keyframe[15].translation,
            solution.world_from_keyframe[15].translation);
}

TEST(RefineMap, InWindowsWhatHasNoLandmarksStaysWhereTheGraphSays) {
  Map map({.cameras = 24, .landmarks = 50}, 0.002);
  map.features.assign(map.features.size(), {});
  const auto refined = map.refined(small_windows());
  ASSERT_OK(refined);
  EXPECT_EQ(refined->landmarks, 0U);
  EXPECT_LT(farthest_apart_m(refined->world_from_keyframe, map.solution().world_from_keyframe),
            1e-6);
}

// As a further walk joins a large map: landmarks are looked for in its key-frames, from 14 on,
// alone, and one of them is tied to an early one of the map.
Map further_walk() {
  Map map({.cameras = 24, .landmarks = 900, .noise_sigmas = 0.5}, 0.004);
  PoseGraphEdge tie = map.edges.front();
  const auto truth = testing::poses_of(map.scene.truth());
  tie.from = 3;
  tie.to = 20;
  tie.from_from_to = truth[3].inverse() * truth[20];
  map.edges.push_back(tie);
  std::fill(map.has_landmarks.begin(), map.has_landmarks.begin() + 14, false);
  return map;
}

TEST(RefineMap, InWindowsEdgesBendWhatHasNoLandmarksAsInAMapThatIsAdjustedWhole) {
  const Map map = further_walk();
  const auto whole = map.refined();
  const auto in_windows = map.refined(small_windows());
  ASSERT_OK(whole);
  ASSERT_OK(in_windows);
  ASSERT_GT(in_windows->landmarks, 100U);
  const auto before = map.solution().world_from_keyframe;
  for (std::size_t id = 0; id <= 3; ++id) {  // nothing pulls at these
    EXPECT_LT((in_windows->world_from_keyframe[id].translation - before[id].translation).norm(),
              1e-5)
        << id;
  }
  const auto step = [](const std::vector<RigidTransform>& poses, std::size_t id) {
    return poses[id - 1].inverse() * poses[id];
  };
  for (std::size_t id = 4; id < 14; ++id) {
    const Eigen::Vector3d asked = whole->world_from_keyframe[id].translation;
    const Eigen::Vector3d moved = in_windows->world_from_keyframe[id].translation;
    EXPECT_LT((moved - asked).norm(), (before[id].translation - asked).norm()) << id;
    const auto bent_m = [&](const std::vector<RigidTransform>& poses) {
      return (step(before, id).inverse() * step(poses, id)).distance_m();
    };
    EXPECT_LT(bent_m(in_windows->world_from_keyframe), bent_m(whole->world_from_keyframe)) << id;
  }
}

}  // namespace
}  // namespace roomwise::mapping
