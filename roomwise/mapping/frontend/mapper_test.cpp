#include "roomwise/mapping/frontend/mapper.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>
#include <utility>

#include "roomwise/base/testing/testing.h"
#include "roomwise/mapping/backend/map_solver.h"
#include "roomwise/motion/testing/test_scenes.h"

namespace roomwise::mapping {
namespace {

using geometry::RigidTransform;
using motion::testing::kCamera;
using ::testing::HasSubstr;

// A room of points on the walls of a cylinder, each with a descriptor of its own: what a camera at
// a pose sees, with noise. Stands in for images, so that mapping is tested alone. The combined
// method's views show the same walls.
class RoomOfPoints {
 public:
  explicit RoomOfPoints(std::uint64_t seed, double radius_m = 3)
      : seed_(seed), radius_m_(radius_m) {
    RandomStream random(seed);
    for (int i = 0; i < kPoints; ++i) {
      const double angle = 2 * std::numbers::pi * random.uniform();
      points_.emplace_back(radius_m * std::sin(angle), 2 * random.uniform() - 1,
                           radius_m * std::cos(angle));
      descriptors_.row(i) = Eigen::RowVectorXf::NullaryExpr(
          64, [&](Eigen::Index) { return static_cast<float>(random.normal()); });
      descriptors_.row(i).normalize();
    }
  }

  [[nodiscard]] motion::MeasuredFeatures seen_from(const RigidTransform& world_from_camera,
                                                   std::uint64_t frame) const {
    RandomStream random(seed_, {frame});
    motion::MeasuredFeatures seen;
    std::vector<int> ids;
    for (int i = 0; i < kPoints; ++i) {
      const Eigen::Vector3d point =
          world_from_camera.inverse() * points_[static_cast<std::size_t>(i)];
      if (point.z() < 0.5) continue;
      const Eigen::Vector2d pixel = kCamera.project_undistorted(point);
      if (pixel.x() < 0 || pixel.y() < 0 || pixel.x() > 639 || pixel.y() > 479) continue;
      const Eigen::Vector2d noisy = pixel + 0.5 * Eigen::Vector2d(random.normal(), random.normal());
      ids.push_back(i);
      seen.pixels.push_back(noisy);
      seen.points.push_back(
          kCamera.unproject_undistorted(noisy, point.z() * (1 + 0.003 * random.normal())));
      seen.features.keypoints.emplace_back();
    }
    features::FloatDescriptors descriptors(static_cast<Eigen::Index>(ids.size()), 64);
    for (std::size_t k = 0; k < ids.size(); ++k) {
      descriptors.row(static_cast<Eigen::Index>(k)) = descriptors_.row(ids[k]);
    }
    seen.features.descriptors = descriptors;
    return seen;
  }
  [[nodiscard]] motion::RgbdPyramid view_from(const RigidTransform& world_from_camera) const {
    const auto walls = [this](const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
      const double a = direction.x() * direction.x() + direction.z() * direction.z();
      const double b = origin.x() * direction.x() + origin.z() * direction.z();
      const double c = origin.x() * origin.x() + origin.z() * origin.z() - radius_m_ * radius_m_;
      const double length = (-b + std::sqrt(b * b - a * c)) / a;
      return motion::testing::Sight{length, motion::testing::marbled(origin + length * direction)};
    };
    return motion::testing::view_of(walls, world_from_camera);
  }

 private:
  static constexpr int kPoints = 1500;
  std::uint64_t seed_;
  double radius_m_;
  std::vector<Eigen::Vector3d> points_;
  features::FloatDescriptors descriptors_{kPoints, 64};
};

// Turning about the vertical with a little sway: frame i of a walk that looks around the room.
RigidTransform pose_at(int frame, double step_rad = 0.06) {
  const double angle = step_rad * frame;
  return {Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY())),
          {0.4 * std::sin(angle), 0.05 * std::sin(3 * angle), 0.4 * std::cos(angle) - 0.4}};
}

motion::MeasuredFeatures nothing_seen() {
  motion::MeasuredFeatures nothing;
  nothing.features.descriptors = features::FloatDescriptors(0, 64);
  return nothing;
}

class MapperTest : public ::testing::Test {
 protected:
  // Features stand alone here, without views.
  static MapperOptions paper() { return MapperOptions::of(MappingMethod::kPaper); }
  static void add(Mapper& mapper, int frame) {
    ASSERT_OK(mapper.add_frame(static_cast<std::uint64_t>(frame), frame * 33'000'000LL,
                               kRoom.seen_from(pose_at(frame), static_cast<std::uint64_t>(frame))));
  }
  static double worst_error_m(const Mapper& mapper, const MapSolution& solution) {
    double worst = 0;
    for (const Frame& frame : mapper.frames()) {
      if (!frame.place) continue;
      const RigidTransform pose =
          solution.world_from_keyframe[frame.place->keyframe] * frame.place->keyframe_from_camera;
      worst = std::max(
          worst, (pose.translation - pose_at(static_cast<int>(frame.index)).translation).norm());
    }
    return worst;
  }
  static void expect_all_placed(const Mapper& mapper) {
    for (const Frame& frame : mapper.frames()) {
      EXPECT_TRUE(frame.place.has_value()) << frame.index << ": " << frame.no_pose_reason;
    }
  }
  static void expect_one_component_within(const Mapper& mapper, double max_error_m) {
    const auto solution = solve_map(mapper.keyframes().size(), mapper.edges());
    ASSERT_OK(solution);
    EXPECT_EQ(solution->components, 1U);
    EXPECT_LT(worst_error_m(mapper, *solution), max_error_m);
  }
  static void expect_a_loop_over(const Mapper& mapper, KeyframeId keyframes) {
    EXPECT_TRUE(std::ranges::any_of(mapper.edges(),
                                    [&](const PoseGraphEdge& edge) {
                                      return edge.is_robust && edge.to > edge.from + keyframes;
                                    }))
        << "no loop over " << keyframes << " key-frames";
  }
  static void expect_same_edges(const Mapper& mapper, const Mapper& expected) {
    ASSERT_EQ(mapper.edges().size(), expected.edges().size());
    for (std::size_t i = 0; i < expected.edges().size(); ++i) {
      EXPECT_EQ(mapper.edges()[i].from_from_to.translation,
                expected.edges()[i].from_from_to.translation);
      EXPECT_EQ(mapper.edges()[i].information, expected.edges()[i].information);
    }
  }
  // As if all that the one mapped had been stored.
  static void restore(Mapper& mapper, Mapper& from) {
    for (const KeyframeStamp& keyframe : from.keyframes()) {
      const auto measurements = from.measurements(keyframe.id);
      ASSERT_OK(measurements);
      ASSERT_OK(mapper.restore_keyframe({keyframe, **measurements}));
    }
    mapper.restore(from.edges(), std::vector<Frame>(from.frames().begin(), from.frames().end()));
  }
  static inline const RoomOfPoints kRoom{1};
};

TEST_F(MapperTest, MapsAFullTurnAndClosesTheLoop) {
  Mapper mapper(kCamera, paper());
  for (int frame = 0; frame < 120; ++frame) add(mapper, frame);
  expect_all_placed(mapper);
  // A turn of 0.14 rad is substantial: every third frame of 0.06 rad.
  EXPECT_NEAR(static_cast<double>(mapper.keyframes().size()), 40, 8);
  expect_a_loop_over(mapper, 25);  // the turn ends where it began
  expect_one_component_within(mapper, 0.02);
}

TEST_F(MapperTest, SurvivesAShortBlackout) {
  Mapper mapper(kCamera, paper());
  for (int frame = 0; frame < 20; ++frame) add(mapper, frame);
  ASSERT_OK(mapper.add_frame(20, 20 * 33'000'000LL, nothing_seen()));
  for (int frame = 21; frame < 30; ++frame) add(mapper, frame);
  EXPECT_FALSE(mapper.frames()[20].place.has_value());
  EXPECT_THAT(mapper.frames()[20].no_pose_reason, HasSubstr("too few features"));
  EXPECT_TRUE(mapper.frames()[21].place.has_value());
  EXPECT_EQ(solve_map(mapper.keyframes().size(), mapper.edges())->components, 1U);
}

TEST_F(MapperTest, KeepsTheFrameBeforeAGapAsABridge) {
  // The step from 1 to 3 is small, but too large from 0: only frame 1, no key-frame by its own
  // motion, links them.
  MapperOptions options = paper();
  options.keyframe_rotation_rad = 1.0;
  options.keyframe_translation_m = 5;
  options.locator.features.max_rotation_rad = 0.5;
  Mapper mapper(kCamera, options);
  const auto add_at = [&](std::uint64_t index, int angle_frame) {
    ASSERT_OK(mapper.add_frame(index, static_cast<TimestampNs>(index),
                               kRoom.seen_from(pose_at(angle_frame), index)));
  };
  add_at(0, 0);
  add_at(1, 5);
  EXPECT_EQ(mapper.keyframes().size(), 1U);
  add_at(2, 11);  // 0.66 rad from frame 0, 0.36 rad from frame 1
  ASSERT_EQ(mapper.keyframes().size(), 2U);
  EXPECT_EQ(mapper.keyframes()[1].frame_index, 1U);
  ASSERT_TRUE(mapper.frames()[2].place.has_value());
  EXPECT_EQ(mapper.frames()[2].place->keyframe, 1U);
}

TEST_F(MapperTest, GoesOnInANewComponentAndJoinsItWhenTheyMeet) {
  const RoomOfPoints other_room(2);
  MapperOptions options = paper();
  options.loops.random = 30;
  Mapper mapper(kCamera, options);
  for (int frame = 0; frame < 20; ++frame) add(mapper, frame);
  for (int frame = 20; frame < 40; ++frame) {
    ASSERT_OK(
        mapper.add_frame(static_cast<std::uint64_t>(frame), frame * 33'000'000LL,
                         other_room.seen_from(pose_at(frame), static_cast<std::uint64_t>(frame))));
  }
  const auto apart = solve_map(mapper.keyframes().size(), mapper.edges());
  ASSERT_OK(apart);
  EXPECT_EQ(apart->components, 2U);
  EXPECT_FALSE(mapper.frames()[20].place.has_value());
  EXPECT_TRUE(mapper.frames()[39].place.has_value()) << "mapping went on";

  for (int frame = 40; frame < 50; ++frame)
    add(mapper, frame - 40);  // back in the first room: recognised
  EXPECT_TRUE(mapper.frames().back().place.has_value());
  const auto recognized = std::ranges::find_if(mapper.edges(), [](const PoseGraphEdge& edge) {
    return edge.to > edge.from + 1 && edge.from < 10 && edge.to > 10;
  });
  ASSERT_NE(recognized, mapper.edges().end()) << "an edge leads back to the first room";
  EXPECT_TRUE(recognized->is_robust) << "it may be wrong, and must be open to rejection";
}

TEST_F(MapperTest, RestoredAtAKeyframeGoesOnAsIfNeverStopped) {
  Mapper whole(kCamera, paper());
  for (int frame = 0; frame < 60; ++frame) add(whole, frame);

  Mapper first(kCamera, paper());
  int frame = 0;
  while (first.keyframes().size() < 10) add(first, frame++);
  ASSERT_EQ(first.keyframes().back().frame_index, static_cast<std::uint64_t>(frame - 1));
  Mapper second(kCamera, paper());
  restore(second, first);
  for (; frame < 60; ++frame) add(second, frame);

  expect_same_edges(second, whole);
}

class CombinedMapperTest : public MapperTest {
 protected:
  enum class Shows { kAll, kViewOnly, kNothing };
  motion::FrameMeasurements measure(int frame, Shows shows = Shows::kAll) {
    motion::RgbdPyramid view = kSmallRoom.view_from(pose_at(frame));
    if (shows == Shows::kNothing) {
      for (motion::PyramidLevel& level : view.levels) std::ranges::fill(level.depth.pixels(), 0);
    }
    return {std::move(view), [this, frame, shows] {
              ++frames_asked_for_features_;
              return shows == Shows::kAll
                         ? kSmallRoom.seen_from(pose_at(frame), static_cast<std::uint64_t>(frame))
                         : nothing_seen();
            }};
  }
  static MapperOptions reuses_all() {
    MapperOptions options;
    options.reuse.min_age = 0;
    return options;
  }
  // The frame's place in a walk to and fro over the first frames of the turn.
  static int to_and_fro(int index, int frames = 25) {
    const int within = index % (2 * frames);
    return within < frames ? within : 2 * frames - 1 - within;
  }
  MapUpdate add_at(Mapper& mapper, int index, int frame) {
    const auto step =
        mapper.add_frame(static_cast<std::uint64_t>(index), index * 33'000'000LL, measure(frame));
    EXPECT_OK(step);
    return step.value_or(MapUpdate());
  }
  static void expect_same_frames(const Mapper& mapper, const Mapper& expected) {
    ASSERT_EQ(mapper.frames().size(), expected.frames().size());
    for (std::size_t i = 0; i < expected.frames().size(); ++i) {
      const auto& place = mapper.frames()[i].place;
      const auto& expected_place = expected.frames()[i].place;
      ASSERT_EQ(place.has_value(), expected_place.has_value()) << i;
      if (!place) continue;
      EXPECT_EQ(place->keyframe, expected_place->keyframe) << i;
      EXPECT_EQ(place->keyframe_from_camera.translation,
                expected_place->keyframe_from_camera.translation)
          << i;
    }
  }
  void add(Mapper& mapper, int frame, Shows shows = Shows::kAll) {
    ASSERT_OK(mapper.add_frame(static_cast<std::uint64_t>(frame), frame * 33'000'000LL,
                               measure(frame, shows)));
  }
  static inline const RoomOfPoints kSmallRoom{1, 1.5};
  std::size_t frames_asked_for_features_ = 0;
};

TEST_F(CombinedMapperTest, MapsAFullTurnWithFewFeatures) {
  Mapper mapper(kCamera, {});
  for (int frame = 0; frame < 115; ++frame) add(mapper, frame);
  expect_all_placed(mapper);
  EXPECT_LT(frames_asked_for_features_, 60U) << "key-frames and those in doubt, not all";
  expect_a_loop_over(mapper, 25);  // the turn ends where it began
  expect_one_component_within(mapper, 0.02);
}

TEST_F(CombinedMapperTest, ViewsCarryItThroughFramesWithoutFeatures) {
  Mapper mapper(kCamera, {});
  for (int frame = 0; frame < 10; ++frame) add(mapper, frame);
  for (int frame = 10; frame < 16; ++frame) add(mapper, frame, Shows::kViewOnly);
  for (int frame = 16; frame < 24; ++frame) add(mapper, frame);
  expect_all_placed(mapper);
  expect_one_component_within(mapper, 0.03);
}

TEST_F(CombinedMapperTest, SurvivesAShortBlackout) {
  Mapper mapper(kCamera, {});
  for (int frame = 0; frame < 10; ++frame) add(mapper, frame);
  for (int frame = 10; frame < 13; ++frame) add(mapper, frame, Shows::kNothing);
  for (int frame = 13; frame < 20; ++frame) add(mapper, frame);
  for (const Frame& frame : mapper.frames()) {
    const bool is_dark = frame.index >= 10 && frame.index < 13;
    EXPECT_EQ(frame.place.has_value(), !is_dark) << frame.index;
  }
  expect_one_component_within(mapper, 0.02);
}

TEST_F(CombinedMapperTest, RestoredAtAKeyframeGoesOnAsIfNeverStopped) {
  Mapper whole(kCamera, {});
  for (int frame = 0; frame < 30; ++frame) add(whole, frame);

  Mapper first(kCamera, {});
  int frame = 0;
  while (first.keyframes().size() < 5) add(first, frame++);
  ASSERT_EQ(first.keyframes().back().frame_index, static_cast<std::uint64_t>(frame - 1));
  Mapper second(kCamera, {});
  restore(second, first);
  for (; frame < 30; ++frame) add(second, frame);

  expect_same_edges(second, whole);
}

// A walk whose device tells its motion, in a world of its own and one percent too long.
class DeviceMotionTest : public CombinedMapperTest {
 protected:
  using Use = scene::MotionUse;
  static constexpr int kFew = 38;  // enough for a loop, too few against a prior

  static geometry::DeviceMotion device_at(int frame) {
    RigidTransform pose = pose_at(frame);
    pose.translation *= 1.01;
    return {RigidTransform{Eigen::Quaterniond(0.6, 0, 0.8, 0), {1, 2, 3}} * pose};
  }
  // It finds itself aside from this frame on.
  static geometry::DeviceMotion jumped_at(int frame, int jump, double aside_m) {
    geometry::DeviceMotion device = device_at(frame);
    if (frame >= jump) device.world_from_camera.translation.x() += aside_m;
    return device;
  }
  void add(Mapper& mapper, int frame, Shows shows,
           const std::optional<geometry::DeviceMotion>& device) {
    ASSERT_OK(mapper.add_frame(static_cast<std::uint64_t>(frame), frame * 33'000'000LL,
                               measure(frame, shows), device));
  }
  static Shows dark_from_10_to_25(int frame) {
    return frame >= 10 && frame < 25 ? Shows::kNothing : Shows::kAll;
  }
  static Use use_at(const Mapper& mapper, std::size_t frame) {
    return mapper.frames()[frame].motion->use;
  }
};

TEST_F(DeviceMotionTest, CarriesItThroughDarkness) {
  Mapper mapper(kCamera, {});
  for (int frame = 0; frame < 40; ++frame)
    add(mapper, frame, dark_from_10_to_25(frame), device_at(frame));
  expect_all_placed(mapper);
  expect_one_component_within(mapper, 0.03);
  for (std::size_t frame = 0; frame < 40; ++frame) {
    const bool is_dark = frame >= 10 && frame < 25;
    // The first that is lit again shows what no key-frame shows.
    if (frame == 25) continue;
    EXPECT_EQ(use_at(mapper, frame), is_dark ? Use::kAlone : Use::kTaken) << frame;
  }
}

TEST_F(DeviceMotionTest, LeftAsideIsAsIfThereWereNone) {
  MapperOptions without;
  without.device_motion = false;
  Mapper left_aside(kCamera, without);
  Mapper none(kCamera, {});
  for (int frame = 0; frame < 30; ++frame) {
    add(left_aside, frame, dark_from_10_to_25(frame), device_at(frame));
    add(none, frame, dark_from_10_to_25(frame), std::nullopt);
  }
  EXPECT_FALSE(left_aside.frames()[15].place.has_value());
  expect_same_edges(left_aside, none);
  expect_same_frames(left_aside, none);
}

TEST_F(DeviceMotionTest, IsDroppedWhereThePicturesSaySurelyThatItJumped) {
  Mapper mapper(kCamera, {});
  for (int frame = 0; frame < 30; ++frame)
    add(mapper, frame, Shows::kAll, jumped_at(frame, 15, 0.15));
  expect_all_placed(mapper);
  expect_one_component_within(mapper, 0.02);
  for (std::size_t frame = 0; frame < 30; ++frame)
    EXPECT_EQ(use_at(mapper, frame), frame == 15 ? Use::kDropped : Use::kTaken) << frame;
}

TEST_F(DeviceMotionTest, AStepThatItRefusesDoesNotComeBackAsOdometry) {
  Mapper mapper(kCamera, {});
  for (int frame = 0; frame < 15; ++frame) add(mapper, frame, Shows::kAll, device_at(frame));
  // Too few features to be sure by say that the camera is aside, as where a pattern repeats.
  RigidTransform aside = pose_at(15);
  aside.translation.x() += 0.3;
  const auto few = [&] {
    motion::MeasuredFeatures seen = kSmallRoom.seen_from(aside, 15);
    seen.pixels.resize(kFew);
    seen.points.resize(kFew);
    seen.features.keypoints.resize(kFew);
    auto& descriptors = std::get<features::FloatDescriptors>(seen.features.descriptors);
    descriptors.conservativeResize(kFew, Eigen::NoChange);
    return seen;
  };
  ASSERT_OK(
      mapper.add_frame(15, 15 * 33'000'000LL, {kSmallRoom.view_from(aside), few}, device_at(15)));
  EXPECT_TRUE(mapper.frames().back().place);
  for (const PoseGraphEdge& edge : mapper.edges()) {
    if (edge.is_robust) continue;
    const auto pose_of = [&](KeyframeId id) {
      return pose_at(static_cast<int>(mapper.keyframes()[id].frame_index));
    };
    const RigidTransform truth = pose_of(edge.from).inverse() * pose_of(edge.to);
    EXPECT_LT((edge.from_from_to.translation - truth.translation).norm(), 0.1)
        << edge.from << " to " << edge.to;
  }
}

TEST_F(DeviceMotionTest, AJumpInTheDarkLeavesTheMapInOnePiece) {
  Mapper mapper(kCamera, {});
  for (int frame = 0; frame < 40; ++frame)
    add(mapper, frame, dark_from_10_to_25(frame), jumped_at(frame, 18, 5));
  expect_all_placed(mapper);
  EXPECT_EQ(use_at(mapper, 18), Use::kDropped) << "nobody moves five metres in a thirtieth second";
  expect_one_component_within(mapper, 0.2);
}

TEST_F(DeviceMotionTest, AShortSilenceIsBridged) {
  Mapper mapper(kCamera, {});
  for (int frame = 0; frame < 40; ++frame) {
    const bool is_silent = frame >= 14 && frame < 18;
    const std::optional<geometry::DeviceMotion> device =
        is_silent ? std::nullopt : std::optional(device_at(frame));
    add(mapper, frame, dark_from_10_to_25(frame), device);
  }
  for (const Frame& frame : mapper.frames()) {
    const bool nobody_knows = frame.index >= 14 && frame.index < 18;
    EXPECT_EQ(frame.place.has_value(), !nobody_knows) << frame.index;
  }
  expect_one_component_within(mapper, 0.05);
}

TEST_F(DeviceMotionTest, RestoredGoesOnAsIfNeverStopped) {
  const auto add_all = [&](Mapper& mapper, int from, int to) {
    for (int frame = from; frame < to; ++frame)
      add(mapper, frame, dark_from_10_to_25(frame), jumped_at(frame, 6, 0.15));
  };
  Mapper whole(kCamera, {});
  add_all(whole, 0, 40);
  for (const int stop : {8, 9, 26, 30}) {
    Mapper first(kCamera, {});
    int frame = stop;
    add_all(first, 0, stop);
    while (first.keyframes().back().frame_index != static_cast<std::uint64_t>(frame - 1)) {
      add_all(first, frame, frame + 1);
      ++frame;
    }
    Mapper second(kCamera, {});
    restore(second, first);
    add_all(second, frame, 40);
    expect_same_edges(second, whole);
    expect_same_frames(second, whole);
  }
}

// A walk whose device has an inertial sensor, with a bias, two hundred samples a second.
class InertialMapperTest : public DeviceMotionTest {
 protected:
  static constexpr TimestampNs kFrame_ns = 33'000'000;
  static inline const Eigen::Vector3d kUpWorld = -Eigen::Vector3d::UnitY();

  // Frames as they are in pose_at(), turned evenly in between. `aside_rad_s`: what the sensor feels
  // besides from frame 10 to 20.
  static geometry::InertialTrack felt(double aside_rad_s = 0) {
    std::vector<geometry::InertialSample> samples;
    for (TimestampNs now = 0; now < 60 * kFrame_ns; now += 5'000'000) {
      const int frame = static_cast<int>(now / kFrame_ns);
      const Eigen::Quaterniond step =
          pose_at(frame).rotation.conjugate() * pose_at(frame + 1).rotation;
      Eigen::Vector3d turning_rad_s = geometry::rotation_vector_rad(step) / 0.033;
      if (frame >= 10 && frame < 20) turning_rad_s.y() += aside_rad_s;
      samples.push_back({now, turning_rad_s + Eigen::Vector3d(0.02, 0.03, -0.02),
                         pose_at(frame).rotation.conjugate() * (9.8 * kUpWorld)});
    }
    return {std::move(samples), true};
  }
  void add_all(Mapper& mapper, int from, int to, int dark_from, int dark_to) {
    for (int frame = from; frame < to; ++frame) {
      const bool is_dark = frame >= dark_from && frame < dark_to;
      add(mapper, frame, is_dark ? Shows::kNothing : Shows::kAll, std::nullopt);
    }
  }
};

TEST_F(InertialMapperTest, TurnsCarryItThroughAShortDarkness) {
  Mapper mapper(kCamera, {});
  mapper.feel(felt());
  add_all(mapper, 0, 40, 12, 20);
  expect_all_placed(mapper);
  expect_one_component_within(mapper, 0.1);
  for (std::size_t frame = 1; frame < 40; ++frame) {
    if (frame == 20) continue;  // lit again, it shows what no key-frame shows
    EXPECT_EQ(use_at(mapper, frame), frame >= 12 && frame < 20 ? Use::kAlone : Use::kTaken)
        << frame;
  }
  const auto solved = solve_map(mapper.keyframes().size(), mapper.edges());
  for (const KeyframeStamp& keyframe : mapper.keyframes()) {
    const auto truth = pose_at(0).inverse() * pose_at(static_cast<int>(keyframe.frame_index));
    const auto& pose = solved->world_from_keyframe[keyframe.id];
    EXPECT_LT((truth.inverse() * pose).angle_rad(), 0.05) << keyframe.id;
  }
}

TEST_F(InertialMapperTest, ReleasedFramesMakeNoDifference) {
  Mapper keeps(kCamera, {}), releases(kCamera, {});
  keeps.feel(felt());
  releases.feel(felt());
  for (int frame = 0; frame < 30; ++frame) {
    const Shows shows = frame >= 12 && frame < 22 ? Shows::kNothing : Shows::kAll;
    add(keeps, frame, shows, std::nullopt);
    add(releases, frame, shows, std::nullopt);
    releases.release_frames(0);
  }
  expect_all_placed(keeps);
  expect_same_edges(releases, keeps);
  EXPECT_LT(releases.frames().size(), 8U);
  for (std::size_t back = 1; back <= releases.frames().size(); ++back) {
    const Frame& one = releases.frames()[releases.frames().size() - back];
    const Frame& same = keeps.frames()[keeps.frames().size() - back];
    ASSERT_TRUE(one.place);
    EXPECT_EQ(one.place->keyframe_from_camera.translation,
              same.place->keyframe_from_camera.translation);
  }
}

TEST_F(InertialMapperTest, ButNotThroughALongOne) {
  Mapper mapper(kCamera, {});
  mapper.feel(felt());
  add_all(mapper, 0, 58, 12, 55);
  EXPECT_TRUE(mapper.frames()[41].place) << "less than a second";
  EXPECT_FALSE(mapper.frames()[43].place) << "more: where it walked to nobody knows";
}

TEST_F(InertialMapperTest, IsDroppedWhereThePicturesSaySurelyThatItDidNotTurnSo) {
  Mapper mapper(kCamera, {}), right(kCamera, {});
  mapper.feel(felt(3));
  right.feel(felt());
  add_all(mapper, 0, 30, 0, 0);
  add_all(right, 0, 30, 0, 0);
  expect_all_placed(mapper);
  expect_one_component_within(mapper, 0.02);
  for (std::size_t frame = 1; frame < 30; ++frame) {
    // At its ends it may be out of step only.
    const bool is_wrong = frame > 11 && frame < 20;
    if (is_wrong || frame < 10 || frame > 21) {
      EXPECT_EQ(use_at(mapper, frame), is_wrong ? Use::kDropped : Use::kTaken) << frame;
    }
    EXPECT_EQ(use_at(right, frame), Use::kTaken) << frame;
  }
}

TEST_F(InertialMapperTest, LeftAsideIsAsIfThereWereNone) {
  MapperOptions without;
  without.device_motion = false;
  Mapper left_aside(kCamera, without), none(kCamera, {});
  left_aside.feel(felt());
  add_all(left_aside, 0, 30, 12, 18);
  add_all(none, 0, 30, 12, 18);
  EXPECT_FALSE(left_aside.frames()[15].place.has_value());
  expect_same_edges(left_aside, none);
  expect_same_frames(left_aside, none);
}

TEST_F(InertialMapperTest, AnAccelerometerAloneTellsUpAndChangesNoPlace) {
  std::vector<geometry::InertialSample> samples;
  for (TimestampNs now = 0; now < 60 * kFrame_ns; now += 5'000'000)
    samples.push_back({now, Eigen::Vector3d::Zero(), 9.8 * kUpWorld});
  Mapper mapper(kCamera, {}), none(kCamera, {});
  mapper.feel({std::move(samples), false});
  add_all(mapper, 0, 30, 12, 18);
  add_all(none, 0, 30, 12, 18);
  expect_same_edges(mapper, none);
  expect_same_frames(mapper, none);
  ASSERT_TRUE(mapper.frames()[10].motion);
  EXPECT_LT((*mapper.frames()[10].motion->device.up_camera - kUpWorld).norm(), 1e-9);
}

TEST_F(InertialMapperTest, RestoredGoesOnAsIfNeverStopped) {
  const auto restored = [&](Mapper& mapper, Mapper& from) {
    mapper.feel(felt());
    restore(mapper, from);
  };
  Mapper whole(kCamera, {});
  whole.feel(felt());
  add_all(whole, 0, 40, 14, 20);
  for (const int stop : {5, 12, 16, 24}) {
    Mapper first(kCamera, {});
    first.feel(felt());
    int frame = stop;
    add_all(first, 0, stop, 14, 20);
    while (first.keyframes().back().frame_index != static_cast<std::uint64_t>(frame - 1)) {
      add_all(first, frame, frame + 1, 14, 20);
      ++frame;
    }
    Mapper second(kCamera, {});
    restored(second, first);
    add_all(second, frame, 40, 14, 20);
    expect_same_edges(second, whole);
    expect_same_frames(second, whole);
  }
}

TEST_F(CombinedMapperTest, GoesOnFromKeyframesThatItKnows) {
  Mapper mapper(kCamera, reuses_all());
  for (int i = 0; i < 25; ++i) add_at(mapper, i, to_and_fro(i));
  const std::size_t keyframes = mapper.keyframes().size();
  EXPECT_GT(keyframes, 7U);
  for (int i = 25; i < 100; ++i) add_at(mapper, i, to_and_fro(i));
  EXPECT_LE(mapper.keyframes().size(), keyframes + 1) << "three more ways over the same ground";
  expect_all_placed(mapper);
  // Every pair of key-frames is joined once at most.
  std::set<std::pair<KeyframeId, KeyframeId>> pairs;
  for (const PoseGraphEdge& edge : mapper.edges()) {
    EXPECT_LT(edge.from, edge.to);
    EXPECT_TRUE(pairs.emplace(edge.from, edge.to).second) << edge.from << " to " << edge.to;
  }
  const auto solution = solve_map(mapper.keyframes().size(), mapper.edges());
  ASSERT_OK(solution);
  EXPECT_EQ(solution->components, 1U);
  for (const Frame& frame : mapper.frames()) {
    const RigidTransform pose =
        solution->world_from_keyframe[frame.place->keyframe] * frame.place->keyframe_from_camera;
    const RigidTransform truth = pose_at(to_and_fro(static_cast<int>(frame.index)));
    EXPECT_LT((pose.translation - truth.translation).norm(), 0.02) << frame.index;
  }

  MapperOptions never;
  never.reuse.max_motion_ratio = 0;
  Mapper without(kCamera, never);
  for (int i = 0; i < 100; ++i) add_at(without, i, to_and_fro(i));
  EXPECT_GT(without.keyframes().size(), 3 * keyframes);
}

TEST_F(CombinedMapperTest, ASmallComponentMakesNewKeyframesThatMayJoinIt) {
  const RoomOfPoints other_room(2, 2.5);
  Mapper mapper(kCamera, reuses_all());
  for (int i = 0; i < 10; ++i) add_at(mapper, i, to_and_fro(i));
  std::size_t keyframes_in_other = 0;
  for (int i = 10; i < 70; ++i) {
    const RigidTransform pose = pose_at(to_and_fro(i, 15));
    const auto seen = [&, i] { return other_room.seen_from(pose, static_cast<std::uint64_t>(i)); };
    const auto step = mapper.add_frame(static_cast<std::uint64_t>(i), i * 33'000'000LL,
                                       {other_room.view_from(pose), seen});
    ASSERT_OK(step);
    keyframes_in_other += step->new_keyframes.size();
  }
  ASSERT_EQ(solve_map(mapper.keyframes().size(), mapper.edges())->components, 2U);
  EXPECT_GT(keyframes_in_other, 12U) << "four ways over the same ground, each with its own";
}

TEST_F(CombinedMapperTest, RestoredOnKnownGroundGoesOnAsIfNeverStopped) {
  constexpr int kFrames = 90;
  Mapper whole(kCamera, reuses_all());
  for (int i = 0; i < kFrames; ++i) add_at(whole, i, to_and_fro(i));

  Mapper first(kCamera, reuses_all());
  int next = 0;
  for (MapUpdate step; next < 45 || !step.is_checkpoint || !step.new_keyframes.empty(); ++next) {
    ASSERT_LT(next, 70) << "no key-frame was gone on from";
    step = add_at(first, next, to_and_fro(next));
  }
  ASSERT_NE(first.frames().back().place->keyframe, first.keyframes().back().id);
  Mapper second(kCamera, reuses_all());
  restore(second, first);
  for (; next < kFrames; ++next) add_at(second, next, to_and_fro(next));

  expect_same_edges(second, whole);
  expect_same_frames(second, whole);
}

TEST_F(CombinedMapperTest, IsTheSameWhateverStaysInMemory) {
  roomwise::testing::ScratchFolder folder;
  Mapper all_in_memory(kCamera, reuses_all());
  Mapper nearly_none(kCamera, reuses_all(), {1, folder.path()});
  for (int i = 0; i < 45; ++i) {
    add_at(all_in_memory, i, to_and_fro(i));
    add_at(nearly_none, i, to_and_fro(i));
  }
  expect_same_edges(nearly_none, all_in_memory);
  expect_same_frames(nearly_none, all_in_memory);
}

TEST_F(CombinedMapperTest, GoesOnWhenFramesAreReleased) {
  Mapper keeps(kCamera, reuses_all());
  Mapper releases(kCamera, reuses_all());
  for (int i = 0; i < 45; ++i) {
    add_at(keeps, i, to_and_fro(i));
    add_at(releases, i, to_and_fro(i));
    releases.release_frames(0);
    EXPECT_LT(releases.frames().size(), 6U);
  }
  EXPECT_EQ(releases.frame_count(), 45U);
  expect_same_edges(releases, keeps);
}

TEST(MapperOptions, SaysWhichFieldIsWrong) {
  MapperOptions options;
  EXPECT_OK(options.validate());
  options.reuse.max_motion_ratio = 1.5;
  EXPECT_ERROR(options.validate(), "max_motion_ratio = 1.5");
  options.reuse = {.max_motion_ratio = 0.5, .min_age = -1};
  EXPECT_ERROR(options.validate(), "min_age = -1");
}

TEST(MappingMethod, IsReadByItsName) {
  for (const MappingMethod method : {MappingMethod::kPaper, MappingMethod::kCombined}) {
    const auto parsed = parse_mapping_method(to_string(method));
    ASSERT_OK(parsed);
    EXPECT_EQ(*parsed, method);
  }
  EXPECT_EQ(to_string(MappingMethod::kPaper), "paper");
  EXPECT_EQ(to_string(MappingMethod::kCombined), "combined");
  EXPECT_ERROR(parse_mapping_method("Paper"), "'Paper' is not a mapping method");
  EXPECT_ERROR(parse_mapping_method(""), "there are combined and paper");
}

}  // namespace
}  // namespace roomwise::mapping
