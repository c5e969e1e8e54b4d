#include "roomwise/pipeline/mapping/map_recording.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <array>
#include <csignal>

#include "roomwise/base/testing/testing.h"
#include "roomwise/evaluation/errors/trajectory_error.h"
#include "roomwise/mapping/backend/walk_joins.h"
#include "roomwise/pipeline/mapping/map_cloud.h"
#include "roomwise/pipeline/report/home_report.h"
#include "roomwise/pipeline/rooms/room_learning.h"
#include "roomwise/pipeline/rooms/room_recognizer.h"
#include "roomwise/pipeline/rooms/walk_into_home.h"
#include "roomwise/pipeline/stored/lost_pictures.h"
#include "roomwise/pipeline/stored/stored_keyframes.h"
#include "roomwise/pipeline/stored/stored_map.h"
#include "roomwise/pipeline/testing/fake_finder.h"
#include "roomwise/pipeline/testing/interrupted_at.h"
#include "roomwise/pipeline/testing/synthetic_walk.h"
#include "roomwise/recording/trajectory_file.h"

namespace roomwise::pipeline {
namespace {

using testing::ColorNetwork;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::SyntheticWalk;

// Finds a couch in the middle of every picture.
class MiddleFinder final : public testing::FakeFinder {
 public:
  MiddleFinder() : FakeFinder("middle", {"zebra", "couch"}) {}

  [[nodiscard]] Expected<std::vector<network::Detection>> find(
      const image::ColorImage& picture) const override {
    const auto width = static_cast<float>(picture.width());
    const auto height = static_cast<float>(picture.height());
    return std::vector<network::Detection>{
        {1, 0.8F, {width / 3, height / 3, 2 * width / 3, 2 * height / 3}}};
  }
};

// Stops as a user does, after so many frames.
class InterruptAfter final : public Progress {
 public:
  explicit InterruptAfter(std::uint64_t frames) : frames_(frames) {}
  void begin(std::string_view, std::optional<std::uint64_t>) override {}
  void advance(std::uint64_t done, std::string_view) override { done_ = done; }
  void end() override {}
  [[nodiscard]] bool interrupted() const override { return done_ >= frames_; }

 private:
  std::uint64_t frames_;
  std::uint64_t done_ = 0;
};

class MapRecording : public ::testing::Test {
 protected:
  static constexpr int kFrames = 45;

  // Maps a walk into the home file; the networks are two, one that names and one that does not.
  Expected<MapSummary> map(const std::filesystem::path& file, recording::FrameSource& walk,
                           std::size_t threads, Progress* progress = nullptr) {
    ROOMWISE_TRY(home::Home home,
                 std::filesystem::exists(file) ? home::Home::open(file) : create_home(file));
    Networks networks;
    networks.push_back(std::make_unique<ColorNetwork>());
    networks.push_back(
        std::make_unique<ColorNetwork>(std::vector<std::string>{"studio couch", "wolf"}));
    ThreadPool pool(threads);
    StageClock clock;
    RunContext run{pool, progress != nullptr ? *progress : silent_, clock, working_set_bytes_,
                   lost_};
    return map_recording(
        walk, {walk.info().name, "made up", walk.info().camera, walk.info().frames_remaining}, home,
        networks, settings_, run, finders_,
        [&] { return name_rooms_ ? name_rooms_(home) : Expected<void>(); }, inertial_);
  }
  void SetUp() override { finders_.in_pictures.push_back(std::make_unique<MiddleFinder>()); }
  static std::string digest(const std::filesystem::path& file) {
    return home::Home::open_read_only(file)->content_digest().value();
  }
  // A walk that is mapped in two runs, the first stopped after some frames, and one that is mapped
  // without a break.
  template <typename Walk>
  void expect_alike_where_stopped() {
    Walk whole(kFrames);
    ASSERT_OK(map(folder_ / "whole.home", whole, 2));
    for (const std::uint64_t stop : {12U, 23U, 30U}) {
      const auto file = folder_ / fmt::format("{}.home", stop);
      Walk first(kFrames);
      InterruptAfter interrupt(stop);
      ASSERT_OK(map(file, first, 2, &interrupt));
      Walk second(kFrames);
      ASSERT_OK(map(file, second, 2));
      EXPECT_EQ(digest(file), digest(folder_ / "whole.home")) << stop;
    }
  }

  roomwise::testing::ScratchFolder folder_;
  objects::ObjectFinders finders_;
  std::function<Expected<void>(home::Home&)> name_rooms_;
  MapSettings settings_;
  std::size_t working_set_bytes_ = std::size_t{128} << 20U;
  std::shared_ptr<LostPictures> lost_;
  geometry::InertialTrack inertial_;
  SilentProgress silent_;
};

TEST_F(MapRecording, MapsAWalkIntoAHome) {
  SyntheticWalk walk(kFrames);
  const auto summary = map(folder_ / "a.home", walk, 2);
  ASSERT_OK(summary);
  EXPECT_TRUE(summary->finished);
  EXPECT_EQ(summary->frames, static_cast<std::uint64_t>(kFrames));
  EXPECT_EQ(summary->placed, static_cast<std::uint64_t>(kFrames));
  EXPECT_EQ(summary->components, 1U);
  EXPECT_GT(summary->keyframes, 10U);

  const home::Home home = *home::Home::open_read_only(folder_ / "a.home");
  const auto trajectory = stored_trajectory(home);
  ASSERT_OK(trajectory);
  const auto error = evaluation::absolute_trajectory_error(walk.truth(), *trajectory);
  ASSERT_OK(error);
  EXPECT_LT(error->error_m.rmse, 0.015);

  // Every key-frame was seen by both networks; "studio couch" means bed.
  EXPECT_EQ(home.predictions(1)->size(), summary->keyframes);
  EXPECT_EQ(home.predictions(2)->size(), summary->keyframes);
  ASSERT_EQ(summary->objects, home.confirmed_objects()->size());
  EXPECT_EQ(summary->instances, home.instances()->size());
  const auto looks = home.detections(1);
  ASSERT_OK(looks);
  ASSERT_EQ(looks->size(), summary->keyframes) << "the finder has looked at every key-frame, too";
  EXPECT_EQ(looks->at(0).detections.at(0).label, "couch");
  EXPECT_GT(looks->at(0).detections.at(0).surface.points.size(), 20U);
  ASSERT_GT(summary->objects, 0U);
  EXPECT_EQ(home.confirmed_objects()->front().name, "bed");
}

// The same pictures, by who takes the camera for another.
class TakenForAnother final : public recording::FrameSource {
 public:
  TakenForAnother(SyntheticWalk& walk, double focal_ratio) : walk_(walk), info_(walk.info()) {
    info_.camera.fx *= focal_ratio;
    info_.camera.fy *= focal_ratio;
  }
  [[nodiscard]] const recording::SourceInfo& info() const override { return info_; }
  [[nodiscard]] Expected<std::optional<image::RgbdFrame>> next() override { return walk_.next(); }
  void skip_before(std::uint64_t index) override { walk_.skip_before(index); }

 private:
  SyntheticWalk& walk_;
  recording::SourceInfo info_;
};

TEST_F(MapRecording, TellsWhichFocalLengthThePicturesFit) {
  for (const double named : {1.0, 0.85}) {
    SyntheticWalk walk(100);
    TakenForAnother named_wrongly(walk, named);
    const auto summary = map(folder_ / fmt::format("{}.home", named), named_wrongly, 2);
    ASSERT_OK(summary);
    ASSERT_TRUE(summary->focal_length);
    EXPECT_NEAR(summary->focal_length->ratio * named, 1, 0.03);
    EXPECT_EQ(summary->focal_length->contradicts(), named != 1);
  }
}

TEST_F(MapRecording, GivesTheSameHomeAtAnyNumberOfThreads) {
  SyntheticWalk one(kFrames);
  SyntheticWalk three(kFrames);
  ASSERT_OK(map(folder_ / "one.home", one, 1));
  ASSERT_OK(map(folder_ / "three.home", three, 3));
  EXPECT_EQ(digest(folder_ / "one.home"), digest(folder_ / "three.home"));

  SyntheticWalk other(kFrames);
  settings_.mapper.seed = 99;
  ASSERT_OK(map(folder_ / "other.home", other, 1));
  EXPECT_NE(digest(folder_ / "one.home"), digest(folder_ / "other.home"))
      << "the digest sees the map";
}

TEST_F(MapRecording, AdjustsTheBundleUnlessToldNotTo) {
  const auto error_m = [&](const char* name) {
    SyntheticWalk walk(kFrames);
    const auto summary = map(folder_ / name, walk, 2);
    EXPECT_OK(summary);
    EXPECT_EQ(summary->landmarks > 0, settings_.adjusts_bundle());
    EXPECT_GE(summary->landmark_views, 2 * summary->landmarks);
    EXPECT_LT(std::abs(summary->readout_s.value_or(0)), 0.003)
        << "the walk exposes all rows at once";
    const auto trajectory = stored_trajectory(*home::Home::open_read_only(folder_ / name));
    return evaluation::absolute_trajectory_error(walk.truth(), trajectory.value())->error_m.rmse;
  };
  EXPECT_LT(error_m("adjusted.home"), 0.006);
  settings_.bundle_adjustment = false;
  EXPECT_LT(error_m("graph.home"), 0.006);
  EXPECT_NE(digest(folder_ / "adjusted.home"), digest(folder_ / "graph.home"));
  settings_.bundle_adjustment = true;
  settings_.mapper = mapping::MapperOptions::of(mapping::MappingMethod::kPaper);
  EXPECT_FALSE(settings_.adjusts_bundle());
  error_m("paper.home");
}

TEST_F(MapRecording, OptimisingAgainFindsTheSameMap) {
  for (const std::size_t max_keyframes : {1000, 6}) {  // at once, and in windows of two
    settings_.refinement.max_keyframes = max_keyframes;
    SyntheticWalk walk(kFrames);
    const auto file = folder_ / fmt::format("{}.home", max_keyframes);
    ASSERT_OK(map(file, walk, 2));
    const std::string before = digest(file);
    {
      home::Home home = *home::Home::open(file);
      const auto poses = home.keyframes().value();
      EXPECT_GT(poses.size(), 6U);
      std::map<home::KeyframeId, home::KeyframePose> away;
      for (const home::Keyframe& keyframe : poses)
        away[keyframe.id] = {{}, keyframe.pose.component};
      ASSERT_OK(home.replace_poses(away));
      ThreadPool pool(3);
      StageClock clock;
      RunContext run{pool, silent_, clock};
      const auto features = stored_keyframe_features(home, settings_, run);
      ASSERT_OK(features);
      ASSERT_OK(solve_stored_map(home, settings_, *features, silent_));
    }
    EXPECT_EQ(digest(file), before) << "from features found again in stored images";
  }
}

TEST_F(MapRecording, WhereNothingIsHeldUprightNoNormalsAreWorkedOut) {
  SyntheticWalk walk(10);
  ASSERT_OK(map(folder_ / "a.home", walk, 2));
  const home::Home home = *home::Home::open_read_only(folder_ / "a.home");
  ThreadPool pool(2);
  StageClock clock;
  RunContext run{pool, silent_, clock};
  for (const bool upright : {true, false}) {
    settings_.refinement.uses_gravity = upright;
    const auto features = stored_keyframe_features(home, settings_, run);
    ASSERT_OK(features);
    const auto found = (*features)(std::vector<home::KeyframeId>{0});
    ASSERT_OK(found);
    EXPECT_GT(found->at(0).size(), 0U);
    EXPECT_EQ(found->at(0).normals.empty(), !upright);
  }
}

TEST_F(MapRecording, InterruptedAndResumedEndsAsIfNeverStopped) {
  SyntheticWalk whole(kFrames);
  ASSERT_OK(map(folder_ / "whole.home", whole, 2));

  SyntheticWalk first(kFrames);
  InterruptAfter interrupt(20);
  const auto stopped = map(folder_ / "resumed.home", first, 2, &interrupt);
  ASSERT_OK(stopped);
  EXPECT_FALSE(stopped->finished);
  SyntheticWalk second(kFrames);
  const auto resumed = map(folder_ / "resumed.home", second, 2);
  ASSERT_OK(resumed);
  EXPECT_TRUE(resumed->finished);
  EXPECT_EQ(digest(folder_ / "resumed.home"), digest(folder_ / "whole.home"));
}

// A walk whose device tells where it is, in a level world (y up) that is a little tilted for the
// walk's, and which is dark for a while.
class WalkOfADevice final : public recording::FrameSource {
 public:
  static constexpr std::uint64_t kDark = 20, kLit = 26;

  explicit WalkOfADevice(int frames) : walk_(frames) {}
  [[nodiscard]] const recording::SourceInfo& info() const override { return walk_.info(); }
  void skip_before(std::uint64_t index) override { walk_.skip_before(index); }
  [[nodiscard]] Expected<std::optional<image::RgbdFrame>> next() override {
    ROOMWISE_TRY(auto frame, walk_.next());
    if (!frame) return frame;
    const auto& pose = walk_.truth()[frame->index].world_from_camera;
    frame->device_motion =
        geometry::DeviceMotion{kDeviceFromWorld * pose, pose.rotation.conjugate() * kUp};
    if (frame->index >= kDark && frame->index < kLit) {
      frame->color = image::ColorImage(frame->color.width(), frame->color.height());
      frame->depth = image::DepthImage(frame->depth.width(), frame->depth.height());
      frame->encoded_color.clear();
      frame->encoded_depth.clear();
    }
    return frame;
  }

  static inline const Eigen::Vector3d kUp = Eigen::Vector3d(0.1, -1, 0).normalized();

 private:
  static inline const geometry::RigidTransform kDeviceFromWorld{Eigen::Quaterniond(0.6, 0.8, 0, 0),
                                                                {3, 2, 1}};
  SyntheticWalk walk_;
};

TEST_F(MapRecording, TheDevicesMotionCarriesItThroughDarkness) {
  WalkOfADevice walk(kFrames);
  const auto summary = map(folder_ / "a.home", walk, 2);
  ASSERT_OK(summary);
  EXPECT_EQ(summary->placed, static_cast<std::uint64_t>(kFrames));
  EXPECT_EQ(summary->components, 1U);
  EXPECT_EQ(summary->with_device_motion, static_cast<std::uint64_t>(kFrames));
  EXPECT_EQ(summary->motion_alone, WalkOfADevice::kLit - WalkOfADevice::kDark);
  EXPECT_EQ(summary->motion_dropped, 0U);

  const home::Home home = *home::Home::open_read_only(folder_ / "a.home");
  const auto keyframes = home.keyframes().value();
  const auto gravity = stored_gravity(home, keyframes);
  ASSERT_OK(gravity);
  ASSERT_EQ(gravity->size(), keyframes.size());
  const auto& first = SyntheticWalk(1).truth()[0].world_from_camera;
  for (const auto& [id, up] : *gravity)
    EXPECT_GT(up.dot(first.rotation.conjugate() * WalkOfADevice::kUp), 0.999);
}

TEST_F(MapRecording, LeavesTheDevicesMotionAsideWhenToldTo) {
  settings_.mapper.device_motion = false;
  WalkOfADevice walk(kFrames);
  const auto summary = map(folder_ / "a.home", walk, 2);
  ASSERT_OK(summary);
  EXPECT_EQ(summary->with_device_motion, 0U);
  EXPECT_EQ(summary->placed, kFrames - (WalkOfADevice::kLit - WalkOfADevice::kDark));
}

TEST_F(MapRecording, InterruptedWhereTheDeviceCarriesItEndsAsIfNeverStopped) {
  expect_alike_where_stopped<WalkOfADevice>();
}

// What an inertial sensor feels along that walk, which turns evenly from frame to frame, with a
// bias.
geometry::InertialTrack felt_along(const SyntheticWalk& walk) {
  const recording::Trajectory& truth = walk.truth();
  std::vector<geometry::InertialSample> samples;
  for (std::size_t i = 0; i + 1 < truth.size(); ++i) {
    const auto& camera = truth[i].world_from_camera.rotation;
    const TimestampNs step_ns = truth[i + 1].timestamp_ns - truth[i].timestamp_ns;
    const Eigen::Vector3d turning_rad_s =
        geometry::rotation_vector_rad(camera.conjugate() *
                                      truth[i + 1].world_from_camera.rotation) /
        (static_cast<double>(step_ns) * kSecondsPerNs);
    for (int part = 0; part < 8; ++part) {
      samples.push_back({truth[i].timestamp_ns + part * step_ns / 8,
                         turning_rad_s + Eigen::Vector3d(0.02, -0.01, 0.03),
                         camera.conjugate() * (geometry::kGravity_m_s2 * WalkOfADevice::kUp)});
    }
  }
  return {std::move(samples), true};
}

// Frames are dark for a while, and tell no motion themselves.
class DarkWalk final : public recording::FrameSource {
 public:
  explicit DarkWalk(int frames) : walk_(frames) {}
  [[nodiscard]] const recording::SourceInfo& info() const override { return walk_.info(); }
  void skip_before(std::uint64_t index) override { walk_.skip_before(index); }
  [[nodiscard]] Expected<std::optional<image::RgbdFrame>> next() override {
    ROOMWISE_TRY(auto frame, walk_.next());
    if (frame) frame->device_motion.reset();
    return frame;
  }

 private:
  WalkOfADevice walk_;
};

TEST_F(MapRecording, AnInertialSensorTellsTurnsAndUp) {
  inertial_ = felt_along(SyntheticWalk(kFrames));
  DarkWalk walk(kFrames);
  const auto summary = map(folder_ / "a.home", walk, 2);
  ASSERT_OK(summary);
  EXPECT_TRUE(summary->is_by_inertial_sensor);
  EXPECT_EQ(summary->placed, static_cast<std::uint64_t>(kFrames));
  EXPECT_EQ(summary->components, 1U);
  EXPECT_GE(summary->with_device_motion, static_cast<std::uint64_t>(kFrames - 1));
  EXPECT_EQ(summary->motion_alone, WalkOfADevice::kLit - WalkOfADevice::kDark);
  EXPECT_EQ(summary->motion_dropped, 0U);

  settings_.mapper.device_motion = false;
  DarkWalk again(kFrames);
  const auto without = map(folder_ / "b.home", again, 2);
  ASSERT_OK(without);
  EXPECT_FALSE(without->is_by_inertial_sensor);
  EXPECT_EQ(without->with_device_motion + without->felt_up, 0U);
  EXPECT_EQ(without->placed, kFrames - (WalkOfADevice::kLit - WalkOfADevice::kDark));
}

TEST_F(MapRecording, InterruptedWhereTurnsCarryItEndsAsIfNeverStopped) {
  inertial_ = felt_along(SyntheticWalk(kFrames));
  expect_alike_where_stopped<DarkWalk>();
}

// Plays a walk to and fro, the frames numbered on.
class ToAndFro final : public recording::FrameSource {
 public:
  ToAndFro(int frames, int laps) : frames_(frames), laps_(laps), walk_(frames) {
    info_ = walk_.info();
    info_.frames_remaining = static_cast<std::uint64_t>(frames * laps);
  }
  [[nodiscard]] const recording::SourceInfo& info() const override { return info_; }
  void skip_before(std::uint64_t index) override { next_ = static_cast<int>(index); }
  [[nodiscard]] Expected<std::optional<image::RgbdFrame>> next() override {
    if (next_ == frames_ * laps_) return std::nullopt;
    const int within = next_ % frames_;
    const bool is_back = next_ / frames_ % 2 == 1;
    walk_.skip_before(static_cast<std::uint64_t>(is_back ? frames_ - 1 - within : within));
    auto frame = walk_.next();
    (*frame)->index = static_cast<std::uint64_t>(next_);
    (*frame)->timestamp_ns = walk_.begins_ns + next_ * 33'333'333LL;
    ++next_;
    return frame;
  }

 private:
  int frames_;
  int laps_;
  int next_ = 0;
  SyntheticWalk walk_;
  recording::SourceInfo info_;
};

TEST_F(MapRecording, LapsThroughAKnownRoomAddNothing) {
  settings_.mapper.reuse.min_age = 0;
  constexpr int kLap = 30;
  ToAndFro one(kLap, 1);
  ToAndFro four(kLap, 4);
  const auto first = map(folder_ / "one.home", one, 2);
  const auto all = map(folder_ / "four.home", four, 2);
  ASSERT_OK(first);
  ASSERT_OK(all);
  EXPECT_EQ(all->frames, static_cast<std::uint64_t>(4 * kLap));
  EXPECT_EQ(all->placed, all->frames);
  EXPECT_LE(all->keyframes, first->keyframes + 1);
  EXPECT_LE(all->edges, first->edges + 2 * first->keyframes);
}

TEST_F(MapRecording, IsTheSameMapWhateverStaysInMemory) {
  settings_.mapper.reuse.min_age = 0;
  ToAndFro large(30, 3);
  ToAndFro small(30, 3);
  ASSERT_OK(map(folder_ / "large.home", large, 2));
  working_set_bytes_ = 1;
  ASSERT_OK(map(folder_ / "small.home", small, 2));
  EXPECT_EQ(digest(folder_ / "small.home"), digest(folder_ / "large.home"));
}

TEST_F(MapRecording, ResumedOnKnownGroundWithLittleMemoryEndsAsIfNeverStopped) {
  settings_.mapper.reuse.min_age = 0;
  ToAndFro whole(30, 3);
  ASSERT_OK(map(folder_ / "whole.home", whole, 1));
  working_set_bytes_ = 1;
  ToAndFro first(30, 3);
  InterruptAfter interrupt(75);
  ASSERT_OK(map(folder_ / "resumed.home", first, 2, &interrupt));
  {
    // Frames are stored also where no key-frame was made.
    const auto home = home::Home::open_read_only(folder_ / "resumed.home");
    EXPECT_GT(home->recordings()->back().next_frame_index,
              home->keyframes()->back().frame_index + 10);
  }
  ToAndFro second(30, 3);
  ASSERT_OK(map(folder_ / "resumed.home", second, 2));
  EXPECT_EQ(digest(folder_ / "resumed.home"), digest(folder_ / "whole.home"));
}

TEST_F(MapRecording, IsNotFinishedUntilTheNetworksHaveSeenAll) {
  SyntheticWalk walk(kFrames);
  testing::InterruptedAt interrupt("looking at key-frames");
  const auto stopped = map(folder_ / "a.home", walk, 2, &interrupt);
  ASSERT_OK(stopped);
  EXPECT_FALSE(stopped->finished);
  SyntheticWalk again(kFrames);
  const auto resumed = map(folder_ / "a.home", again, 2);
  ASSERT_OK(resumed);
  EXPECT_TRUE(resumed->finished);
  const home::Home home = *home::Home::open_read_only(folder_ / "a.home");
  EXPECT_EQ(home.predictions(1)->size(), home.keyframes()->size());
}

TEST_F(MapRecording, InWindowsTheSameMapWhateverIsInMemoryAndWhereverItStopped) {
  settings_.refinement.max_keyframes = 12;
  SyntheticWalk walk(kFrames);
  const auto summary = map(folder_ / "whole.home", walk, 2);
  ASSERT_OK(summary);
  ASSERT_GT(summary->keyframes, settings_.refinement.max_keyframes);
  EXPECT_GT(summary->landmarks, 0U);
  const auto trajectory = stored_trajectory(*home::Home::open_read_only(folder_ / "whole.home"));
  EXPECT_LT(evaluation::absolute_trajectory_error(walk.truth(), trajectory.value())->error_m.rmse,
            0.006);

  working_set_bytes_ = 1;
  SyntheticWalk small(kFrames);
  ASSERT_OK(map(folder_ / "small.home", small, 1));
  EXPECT_EQ(digest(folder_ / "small.home"), digest(folder_ / "whole.home"));

  SyntheticWalk first(kFrames);
  testing::InterruptedAt interrupt("adjusting landmarks");
  const auto stopped = map(folder_ / "resumed.home", first, 2, &interrupt);
  ASSERT_OK(stopped);
  ASSERT_FALSE(stopped->finished);
  SyntheticWalk second(kFrames);
  ASSERT_OK(map(folder_ / "resumed.home", second, 2));
  EXPECT_EQ(digest(folder_ / "resumed.home"), digest(folder_ / "whole.home"));
}

TEST_F(MapRecording, InterruptedWhileLandmarksAreAdjustedMovesNothing) {
  SyntheticWalk whole(kFrames);
  ASSERT_OK(map(folder_ / "whole.home", whole, 2));
  SyntheticWalk first(kFrames);
  testing::InterruptedAt interrupt("adjusting landmarks");
  const auto stopped = map(folder_ / "resumed.home", first, 2, &interrupt);
  ASSERT_OK(stopped);
  EXPECT_FALSE(stopped->finished);
  SyntheticWalk second(kFrames);
  const auto resumed = map(folder_ / "resumed.home", second, 2);
  ASSERT_OK(resumed);
  EXPECT_TRUE(resumed->finished);
  EXPECT_EQ(digest(folder_ / "resumed.home"), digest(folder_ / "whole.home"));

  // Optimised again, and stopped.
  home::Home home = *home::Home::open(folder_ / "resumed.home");
  testing::InterruptedAt again("adjusting landmarks");
  ThreadPool pool(2);
  StageClock clock;
  RunContext run{pool, again, clock};
  const auto features = stored_keyframe_features(home, settings_, run);
  ASSERT_OK(features);
  const auto solved = solve_stored_map(home, settings_, *features, again);
  ASSERT_FALSE(solved.has_value());
  EXPECT_EQ(solved.error().code, ErrorCode::kInterrupted);
  EXPECT_EQ(digest(folder_ / "resumed.home"), digest(folder_ / "whole.home"));
}

// A source that kills its process at a frame, as the power or the kernel would.
class KillingSource final : public recording::FrameSource {
 public:
  KillingSource(SyntheticWalk& walk, int at) : walk_(walk), at_(at) {}
  [[nodiscard]] const recording::SourceInfo& info() const override { return walk_.info(); }
  void skip_before(std::uint64_t index) override { walk_.skip_before(index); }
  [[nodiscard]] Expected<std::optional<image::RgbdFrame>> next() override {
    if (at_-- == 0) std::raise(SIGKILL);
    return walk_.next();
  }

 private:
  SyntheticWalk& walk_;
  int at_;
};

TEST_F(MapRecording, KilledAndResumedEndsAsIfNeverStopped) {
  SyntheticWalk whole(kFrames);
  ASSERT_OK(map(folder_ / "whole.home", whole, 2));

  const pid_t child = fork();
  if (child == 0) {
    SyntheticWalk walk(kFrames);
    KillingSource source(walk, 25);
    (void)map(folder_ / "killed.home", source, 2);
    _exit(0);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  {
    const auto left = home::Home::open_read_only(folder_ / "killed.home");
    ASSERT_OK(left);
    EXPECT_GT(left->keyframes()->size(), 5U);
  }
  SyntheticWalk rest(kFrames);
  ASSERT_OK(map(folder_ / "killed.home", rest, 2));
  EXPECT_EQ(digest(folder_ / "killed.home"), digest(folder_ / "whole.home"));
}

TEST_F(MapRecording, KilledAtItsEndIsNamedByWhoGoesOn) {
  const auto labels = recording::RoomLabels::from_ranges({{0, kFrames - 1, "hall", 1}}).value();
  const pid_t child = fork();
  if (child == 0) {
    name_rooms_ = [&](home::Home& home) {
      (void)name_rooms_if_unnamed(home, labels);
      std::raise(SIGKILL);
      return Expected<void>();
    };
    SyntheticWalk walk(kFrames);
    (void)map(folder_ / "a.home", walk, 2);
    _exit(0);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status));
  name_rooms_ = [&](home::Home& home) { return name_rooms_if_unnamed(home, labels); };
  SyntheticWalk again(kFrames);
  ASSERT_OK(map(folder_ / "a.home", again, 2));
  const auto home = home::Home::open_read_only(folder_ / "a.home");
  EXPECT_TRUE(home->recordings()->back().finished);
  EXPECT_EQ(home->room_ranges(1)->ranges(), labels.ranges());
}

TEST_F(MapRecording, KeepsWhatCameBeforeADamagedFrame) {
  SyntheticWalk damaged(kFrames);
  damaged.fail_at = 20;
  EXPECT_ERROR(map(folder_ / "a.home", damaged, 2), "frame 20 is damaged");
  // What is there is a map already, if not an optimised one.
  const auto part = stored_trajectory(*home::Home::open_read_only(folder_ / "a.home"));
  ASSERT_OK(part);
  EXPECT_LT(evaluation::absolute_trajectory_error(damaged.truth(), *part)->error_m.rmse, 0.03);
  SyntheticWalk mended(kFrames);
  const auto summary = map(folder_ / "a.home", mended, 2);
  ASSERT_OK(summary);
  EXPECT_EQ(summary->frames, static_cast<std::uint64_t>(kFrames));
}

TEST_F(MapRecording, BeginsAnewWhereNothingWasMapped) {
  SyntheticWalk unreadable(kFrames);
  unreadable.fail_at = 0;
  EXPECT_ERROR(map(folder_ / "a.home", unreadable, 1), "frame 0 is damaged");
  settings_.max_keypoints = 700;  // as a user would who found the mistake
  SyntheticWalk mended(12);
  ASSERT_OK(map(folder_ / "a.home", mended, 1));
}

TEST_F(MapRecording, RefusesOtherSettings) {
  SyntheticWalk walk(12);
  InterruptAfter interrupt(6);
  ASSERT_OK(map(folder_ / "a.home", walk, 1, &interrupt));
  settings_.max_keypoints = 700;
  SyntheticWalk other(12);
  EXPECT_ERROR(map(folder_ / "a.home", other, 1), "other settings");
  settings_.max_keypoints = MapSettings{}.max_keypoints;
  ASSERT_OK(map(folder_ / "a.home", other, 1));
}

// Looks around from elsewhere with another camera, a little later in the same times.
SyntheticWalk further_walk(int frames) {
  SyntheticWalk walk(frames, 0.041, 0.3);
  walk.take_camera({231, 229, 151, 122, 304, 232, {}, 500});
  walk.begins_ns += 100'000'000;
  return walk;
}

class MapFurtherWalks : public MapRecording {
 protected:
  void SetUp() override {
    MapRecording::SetUp();
    SyntheticWalk first(kFrames);
    ASSERT_OK(map(home_, first, 2));
  }
  // How far the stored walk lies from where it was, in the world that the first walk began.
  static double error_m(const home::Home& home, home::RecordingId id, const SyntheticWalk& walk) {
    const auto trajectory = stored_trajectory(home, id);
    EXPECT_OK(trajectory);
    double worst = trajectory->empty() ? 1e9 : 0;
    const auto truth = walk.truth();
    for (const auto& [time_ns, pose] : *trajectory) {
      const auto was = std::ranges::find(truth, time_ns, &recording::StampedPose::timestamp_ns);
      worst = std::max(worst, (pose.translation - was->world_from_camera.translation).norm());
    }
    return worst;
  }

  const std::filesystem::path home_ = folder_ / "a.home";
};

TEST_F(MapFurtherWalks, JoinTheMapWithTheirOwnCamera) {
  const std::string one_walk = digest(home_);
  SyntheticWalk further = further_walk(kFrames);
  const auto summary = map(home_, further, 2);
  ASSERT_OK(summary);
  EXPECT_TRUE(summary->finished);
  EXPECT_TRUE(summary->is_joined);
  EXPECT_EQ(summary->walks, 2U);
  EXPECT_EQ(summary->components, 1U);
  EXPECT_EQ(summary->frames, static_cast<std::uint64_t>(kFrames));
  EXPECT_EQ(summary->placed, static_cast<std::uint64_t>(kFrames));
  EXPECT_GT(summary->keyframes, 10U);
  EXPECT_NE(digest(home_), one_walk);

  const home::Home home = *home::Home::open_read_only(home_);
  EXPECT_LT(error_m(home, 1, SyntheticWalk(kFrames)), 0.03);
  EXPECT_LT(error_m(home, 2, further_walk(kFrames)), 0.03);
  EXPECT_EQ(stored_trajectory(home)->size(), 2U * kFrames);
}

// Of the first walk: the colour of its first key-frame, the depth of another, a page that cannot be
// read is as one that is not there.
class MapOverDamage : public MapFurtherWalks {
 protected:
  static constexpr std::array<home::KeyframeId, 3> kDamaged{0, 3, 6};

  void SetUp() override {
    MapFurtherWalks::SetUp();
    home::Home home = home::Home::open(home_).value();
    before_ = home.keyframes().value();
    seen_ = home.predictions(1).value();
    for (const char* damage :
         {"UPDATE keyframe_images SET color = x'00' WHERE keyframe_id = 0",
          "UPDATE keyframe_images SET depth = x'00' WHERE keyframe_id = 3",
          "UPDATE keyframe_images SET color = x'ffd8ff', depth = x'' WHERE keyframe_id = 6",
          // A network has not seen this one yet, nor can it now.
          "DELETE FROM keyframe_predictions WHERE keyframe_id = 6 AND network_id = 2"})
      ASSERT_OK(home.database().run(damage));
  }
  void go_on_without() {
    lost_ = std::make_shared<LostPictures>(
        true, [this](const Error& why) { told_.push_back(why.message); });
  }
  void expect_that_nothing_is_lost_but_pictures() {
    EXPECT_THAT(told_, ::testing::UnorderedElementsAre(HasSubstr("a.home: key-frame 0: "),
                                                       HasSubstr("a.home: key-frame 3: "),
                                                       HasSubstr("a.home: key-frame 6: ")));
    const home::Home home = *home::Home::open_read_only(home_);
    const auto keyframes = home.keyframes().value();
    ASSERT_GT(keyframes.size(), before_.size());
    for (std::size_t i = 0; i < before_.size(); ++i)
      EXPECT_EQ(keyframes[i].timestamp_ns, before_[i].timestamp_ns);
    const auto seen = home.predictions(1).value();
    for (const home::KeyframeId id : kDamaged) EXPECT_EQ(seen.at(id).scores, seen_.at(id).scores);
    EXPECT_FALSE(home.predictions(2)->contains(6)) << "not seen stays not seen";
    EXPECT_LT(error_m(home, 1, SyntheticWalk(kFrames)), 0.03);
    EXPECT_LT(error_m(home, 2, further_walk(kFrames)), 0.03);
  }

  std::vector<home::Keyframe> before_;
  std::map<home::KeyframeId, network::Prediction> seen_;
  std::vector<std::string> told_;
};

TEST_F(MapOverDamage, AFurtherWalkJoinsWithoutThePicturesThatCannotBeRead) {
  go_on_without();
  SyntheticWalk further = further_walk(kFrames);
  const auto summary = map(home_, further, 2);
  ASSERT_OK(summary);
  EXPECT_TRUE(summary->finished);
  EXPECT_TRUE(summary->is_joined);
  EXPECT_EQ(summary->components, 1U);
  EXPECT_EQ(summary->placed, static_cast<std::uint64_t>(kFrames));
  EXPECT_TRUE(summary->unread.empty()) << "each is told once";
  expect_that_nothing_is_lost_but_pictures();
}

TEST_F(MapOverDamage, SoItDoesWhereNothingOfTheMapWasKeptReady) {
  ASSERT_OK(home::Home::open(home_)->database().run("DELETE FROM derived_data"));
  go_on_without();
  SyntheticWalk further = further_walk(kFrames);
  const auto summary = map(home_, further, 2);
  ASSERT_OK(summary);
  EXPECT_TRUE(summary->is_joined);
  expect_that_nothing_is_lost_but_pictures();
}

TEST_F(MapOverDamage, AWalkMoreIsMappedAndCulledAndLookedThroughCloser) {
  finders_.of_proposals = std::make_unique<testing::RedProposalClassifier>();
  go_on_without();
  SyntheticWalk further = further_walk(kFrames);
  ASSERT_OK(map(home_, further, 2));
  SyntheticWalk third(kFrames, 0.043, 0.2);
  third.begins_ns += 200'000'000;
  const auto summary = map(home_, third, 2);
  ASSERT_OK(summary);
  EXPECT_TRUE(summary->finished);
  EXPECT_TRUE(summary->is_joined);
  EXPECT_THAT(told_, ::testing::SizeIs(3)) << "not again";
}

TEST_F(MapOverDamage, TheSameWalkOnceMoreIsNoticedThoughItsFirstPictureIsDamaged) {
  go_on_without();
  const std::string before = digest(home_);
  SyntheticWalk again(kFrames);
  EXPECT_ERROR(map(home_, again, 2), "holds this recording already, as synthetic walk");
  EXPECT_EQ(digest(home_), before);
}

TEST_F(MapOverDamage, WithoutLeaveTheErrorNamesTheKeyframeAndTheMend) {
  lost_ = std::make_shared<LostPictures>(false);
  SyntheticWalk further = further_walk(kFrames);
  const auto summary = map(home_, further, 2);
  ASSERT_FALSE(summary);
  EXPECT_THAT(summary.error().message, HasSubstr("a.home: key-frame "));
  EXPECT_TRUE(lost_->is_stopped());
  go_on_without();
  SyntheticWalk again = further_walk(kFrames);
  const auto resumed = map(home_, again, 2);
  ASSERT_OK(resumed);
  EXPECT_TRUE(resumed->is_joined);
}

TEST_F(MapFurtherWalks, OfAnotherHomeStaysAComponentOfItsOwn) {
  SyntheticWalk elsewhere = further_walk(30);
  elsewhere.home = 1;
  const auto summary = map(home_, elsewhere, 2);
  ASSERT_OK(summary);
  EXPECT_FALSE(summary->is_joined);
  EXPECT_EQ(summary->components, 2U);
  EXPECT_EQ(summary->placed, 0U) << "on the map that is there";
  const home::Home home = *home::Home::open_read_only(home_);
  EXPECT_LT(error_m(home, 1, SyntheticWalk(kFrames)), 0.03) << "the map is what it was";
}

TEST_F(MapFurtherWalks, OfAnotherHomeIsNotTheMapThoughItIsLonger) {
  SyntheticWalk elsewhere = further_walk(2 * kFrames);
  elsewhere.home = 1;
  const auto summary = map(home_, elsewhere, 2);
  ASSERT_OK(summary);
  EXPECT_EQ(summary->components, 2U);
  EXPECT_EQ(summary->placed, 0U) << "on the map that is there";
  home::Home home = *home::Home::open(home_);
  std::map<home::RecordingId, std::size_t> keyframes, of_map;
  const auto all = home.keyframes().value();
  for (const home::Keyframe& one : all) {
    ++keyframes[one.recording];
    if (one.pose.component == 0) ++of_map[one.recording];
  }
  EXPECT_GT(keyframes[2], keyframes[1]);
  EXPECT_EQ(of_map[1], keyframes[1]);
  EXPECT_EQ(of_map[2], 0U);
  ASSERT_OK(forget_walk(home, 1));
  const auto left = home.keyframes().value();
  for (const home::Keyframe& one : left) {
    EXPECT_EQ(one.pose.component, 0U) << "once the other is gone";
  }
}

// As a bookcase of one make in two homes would.
TEST_F(MapFurtherWalks, OfAnotherHomeThatSharesOneThingStaysAComponentOfItsOwn) {
  constexpr int kAhead = 5;
  SyntheticWalk elsewhere = further_walk(kFrames);
  elsewhere.home = 1;
  elsewhere.wall_of_first_home = kAhead;
  elsewhere.half_m.x() = 3.6;
  const auto summary = map(home_, elsewhere, 2);
  ASSERT_OK(summary);
  EXPECT_FALSE(summary->is_joined);
  EXPECT_EQ(summary->components, 2U);
  const home::Home home = *home::Home::open_read_only(home_);
  EXPECT_LT(error_m(home, 1, SyntheticWalk(kFrames)), 0.03) << "the map is what it was";
  const auto keyframes = home.keyframes().value();
  std::vector<std::size_t> walk_of;
  for (const home::Keyframe& one : keyframes)
    walk_of.push_back(static_cast<std::size_t>(one.recording));
  const auto believed = mapping::without_unsupported_joins(walk_of, home.edges().value());
  ASSERT_OK(believed);
  EXPECT_TRUE(std::ranges::any_of(*believed, [&](const mapping::PoseGraphEdge& edge) {
    return walk_of[edge.from] != walk_of[edge.to];
  })) << "by its edges alone it would have joined";
}

TEST_F(MapFurtherWalks, InterruptedEndAsIfNeverStopped) {
  std::filesystem::copy(home_, folder_ / "whole.home");
  SyntheticWalk whole = further_walk(kFrames);
  ASSERT_OK(map(folder_ / "whole.home", whole, 1));
  for (const std::uint64_t stop : {1U, 27U, 36U}) {  // the first while the map is loaded
    const auto file = folder_ / fmt::format("{}.home", stop);
    std::filesystem::copy(home_, file);
    SyntheticWalk first = further_walk(kFrames);
    InterruptAfter interrupt(stop);
    const auto stopped = map(file, first, 2, &interrupt);
    ASSERT_FALSE(stopped && stopped->finished) << stop;
    SyntheticWalk second = further_walk(kFrames);
    ASSERT_OK(map(file, second, 2));
    EXPECT_EQ(digest(file), digest(folder_ / "whole.home")) << stop;
  }
}

TEST_F(MapFurtherWalks, OfWhatTheHomeHoldsAlreadyAddNothing) {
  const std::string before = digest(home_);
  SyntheticWalk again(kFrames);
  EXPECT_ERROR(map(home_, again, 2), "holds this recording already, as synthetic walk");
  EXPECT_EQ(digest(home_), before);
}

TEST_F(MapFurtherWalks, WhoseFirstFrameIsDamagedAddNothing) {
  const std::string before = digest(home_);
  SyntheticWalk damaged = further_walk(kFrames);
  damaged.fail_at = 0;
  EXPECT_ERROR(map(home_, damaged, 2), "frame 0 is damaged");
  EXPECT_EQ(digest(home_), before);
}

TEST_F(MapFurtherWalks, OfWhichNothingWasMappedTakeTheirNamesAlong) {
  {
    home::Home home = *home::Home::open(home_);
    const SyntheticWalk begun = further_walk(kFrames);
    ASSERT_OK(home.add_recording({"begun", "made up", begun.info().camera, kFrames}));
    home::Edit named;
    named.what = "name frames";
    named.change = R"({"name":"begun","room":"bath"})";
    named.before = R"({"ranges":{"2":[[0,5,"hall",1]]}})";
    ASSERT_OK(home.add_edit(named));
  }
  SyntheticWalk further = further_walk(kFrames);
  ASSERT_OK(map(home_, further, 2));
  const auto edits = home::Home::open_read_only(home_)->edits().value();
  ASSERT_EQ(edits.size(), 1U);
  EXPECT_THAT(edits[0].before, Not(HasSubstr("hall"))) << "the number is another walk's now";
  EXPECT_THAT(edits[0].change, Not(HasSubstr("begun")));
}

TEST_F(MapFurtherWalks, TogetherTeachRoomsThatOneAloneDoesNotName) {
  SyntheticWalk further = further_walk(kFrames);
  ASSERT_OK(map(home_, further, 2));
  home::Home home = *home::Home::open(home_);
  const auto name = [&](home::RecordingId walk, const std::string& room) {
    const auto labels = recording::RoomLabels::from_ranges({{0, kFrames - 1, room, 1}});
    ASSERT_OK(name_rooms(home, walk, labels.value()));
  };
  name(1, "bath");
  ThreadPool pool(2);
  StageClock clock;
  RunContext run{pool, silent_, clock};
  EXPECT_ERROR(learn_rooms_from_keyframes(home, {}, {}, {}, run), "bath alone");
  name(2, "hall");
  const auto learned = learn_rooms_from_keyframes(home, {{}, {"bath", "hall"}}, {}, {}, run);
  ASSERT_OK(learned);
  EXPECT_EQ(learned->rooms.size(), 2U);
  EXPECT_ERROR(learn_rooms_from_keyframes(home, {}, {.walks = {1}}, {}, run), "bath alone");
  EXPECT_ERROR(learn_rooms_from_keyframes(home, {{}, {"attic"}}, {}, {}, run), "no room 'attic'");
}

TEST_F(MapFurtherWalks, StandWhereTheFirstIsTakenOut) {
  SyntheticWalk further = further_walk(kFrames);
  ASSERT_OK(map(home_, further, 2));
  {
    home::Home home = *home::Home::open(home_);
    ASSERT_OK(forget_walk(home, 1));
    ASSERT_OK(home.verify());
    EXPECT_EQ(home.keyframes()->front().pose.world_from_keyframe.translation,
              Eigen::Vector3d::Zero());
    EXPECT_EQ(stored_trajectory(home)->size(), static_cast<std::size_t>(kFrames));
    EXPECT_FALSE(home.confirmed_objects()->empty()) << "what it shows is still there";
  }
  SyntheticWalk first(kFrames);
  const auto summary = map(home_, first, 2);
  ASSERT_OK(summary);
  EXPECT_TRUE(summary->is_joined);
  EXPECT_EQ(summary->walks, 2U);
  EXPECT_EQ(summary->components, 1U);
}

TEST_F(MapFurtherWalks, AreForgottenAlthoughAPictureOfAnotherIsDamaged) {
  SyntheticWalk further = further_walk(kFrames);
  ASSERT_OK(map(home_, further, 2));
  home::Home home = *home::Home::open(home_);
  ASSERT_OK(
      home.database().run("UPDATE keyframe_images SET depth = x'00' WHERE keyframe_id = "
                          "(SELECT max(keyframe_id) FROM keyframes)"));
  ASSERT_OK(forget_walk(home, 1));
  EXPECT_EQ(home.recordings()->size(), 1U);
  EXPECT_FALSE(home.confirmed_objects()->empty()) << "by the other pictures";
}

TEST_F(MapRecording, RefusesToGoOnWithAnotherRecording) {
  SyntheticWalk walk(kFrames);
  InterruptAfter interrupt(20);
  ASSERT_OK(map(folder_ / "a.home", walk, 1, &interrupt));
  const std::string before = digest(folder_ / "a.home");
  SyntheticWalk later(kFrames);
  later.begins_ns = 5'000'000'000;
  EXPECT_ERROR(map(folder_ / "a.home", later, 1), "is another recording");
  SyntheticWalk shorter(4);
  EXPECT_ERROR(map(folder_ / "a.home", shorter, 1), "is another recording");
  SyntheticWalk elsewhere(kFrames);
  elsewhere.home = 1;
  EXPECT_ERROR(map(folder_ / "a.home", elsewhere, 1), "is another recording");
  EXPECT_EQ(digest(folder_ / "a.home"), before);
}

TEST_F(MapRecording, LearnsAndRecognisesItsRooms) {
  SyntheticWalk walk(100);
  ASSERT_OK(map(folder_ / "a.home", walk, 2));
  home::Home home = *home::Home::open(folder_ / "a.home");
  const auto labels =
      recording::RoomLabels::from_ranges({{0, 30, "bedroom", 1}, {31, 70, "kitchen", 1}});
  ASSERT_OK(name_rooms(home, 1, *labels));
  ThreadPool pool(2);
  StageClock clock;
  RunContext run{pool, silent_, clock};
  ASSERT_OK(learn_rooms_from_keyframes(home, {}, {}, {}, run));
  EXPECT_EQ(home.keyframe_rooms()->size(), home.keyframes()->size())
      << "every key-frame has a room";

  Networks networks;
  networks.push_back(std::make_unique<ColorNetwork>());
  const auto recognizer = RoomRecognizer::create(home, networks);
  ASSERT_OK(recognizer);
  SyntheticWalk again(100);
  again.skip_before(15);
  const image::ColorImage in_bedroom = again.next().value()->color;
  again.skip_before(50);
  const image::ColorImage in_kitchen = again.next().value()->color;
  EXPECT_EQ(recognizer->recognize(std::vector{in_bedroom})->room(), "bedroom");
  EXPECT_EQ(recognizer->recognize(std::vector{in_kitchen, in_kitchen})->room(), "kitchen");
  EXPECT_ERROR(recognizer->recognize({}), "at least one");
  EXPECT_EQ(recognizer->paper_recognize(in_bedroom, std::nullopt)->room, "bedroom");
  EXPECT_EQ(recognizer->paper_recognize(in_kitchen, in_kitchen)->reason,
            rooms::Reason::kFramesAgree);
  EXPECT_EQ(recognizer->topology().transition_counts()(0, 1), 1)
      << "from the bedroom to the kitchen";
  const auto learned_from = learned_keyframes(home).value();
  EXPECT_FALSE(learned_from.empty());

  Networks others;
  others.push_back(std::make_unique<ColorNetwork>(std::vector<std::string>{"a", "b"}));
  EXPECT_ERROR(RoomRecognizer::create(home, others), "is not the one that this home was made with");
  EXPECT_ERROR(learn_rooms_from_keyframes(home, {.stays = {}, .rooms = {"attic"}}, {}, {}, run),
               "no room 'attic'");
  EXPECT_ERROR(learn_rooms_from_keyframes(home, {}, {.variants = 2}, others, run),
               "give its file by --network");

  // With varied pictures; what the network made of them goes with its key-frames.
  ASSERT_OK(learn_rooms_from_keyframes(home, {}, {.variants = 2}, networks, run));
  const auto kept = [&] {
    return home.database().get<int>("SELECT count(*) FROM picture_features").value();
  };
  EXPECT_GT(kept(), 10);

  // Of pictures that cannot be read again only the network's word from before counts.
  ASSERT_OK(home.database().run("UPDATE keyframe_images SET color = x'00' WHERE keyframe_id = 2"));
  const auto damaged = learn_rooms_from_keyframes(home, {}, {.variants = 3}, networks, run);
  ASSERT_OK(damaged);
  EXPECT_THAT(damaged->warnings,
              ::testing::Contains(::testing::AllOf(HasSubstr("cannot be read again: 1"),
                                                   HasSubstr("a.home: key-frame 2: "))));
  EXPECT_EQ(learned_keyframes(home).value(), learned_from) << "the damaged one among them";
  ASSERT_OK(home.remove_recording(1));
  EXPECT_EQ(kept(), 0);
}

TEST_F(MapRecording, BuildsTheCloudOfTheRoom) {
  SyntheticWalk walk(kFrames);
  ASSERT_OK(map(folder_ / "a.home", walk, 2));
  ThreadPool pool(2);
  StageClock clock;
  RunContext run{pool, silent_, clock};
  const auto cloud = build_map_cloud(*home::Home::open_read_only(folder_ / "a.home"), 0.05, run);
  ASSERT_OK(cloud);
  ASSERT_GT(cloud->cloud.size(), 1000U);
  // Every point lies on a wall of the box, whose middle is where the walk began.
  std::size_t on_wall = 0;
  for (const Eigen::Vector3f& point : cloud->cloud.points) {
    const Eigen::Array3f from_wall = (point.array().abs() - Eigen::Array3f(2.4F, 1.4F, 2.1F)).abs();
    on_wall += from_wall.minCoeff() < 0.06F ? 1 : 0;
  }
  EXPECT_GT(static_cast<double>(on_wall), 0.95 * static_cast<double>(cloud->cloud.size()));
  EXPECT_LT(std::acos(-cloud->up.up_world.y()), 0.03) << "the floor is level";
}

TEST_F(MapRecording, ReportsTheHome) {
  SyntheticWalk walk(kFrames);
  ASSERT_OK(map(folder_ / "a.home", walk, 2));
  // A finder looked at this home: its instances are the objects, not what the rules confirmed.
  objects::Instance sofa;
  sofa.name = "sofa";
  sofa.observations = 3;
  sofa.box_keyframe.world_from_box.translation = {0.1, 0.2, 1.5};
  ASSERT_OK(home::Home::open(folder_ / "a.home")->replace_instances(std::span(&sofa, 1)));
  ThreadPool pool(2);
  StageClock clock;
  RunContext run{pool, silent_, clock};
  ReportExtras extras;
  extras.name = "a";
  extras.truth = walk.truth();
  const auto content = report_content(*home::Home::open_read_only(folder_ / "a.home"), extras, run);
  ASSERT_OK(content);
  EXPECT_TRUE(content->map.has_value());
  EXPECT_TRUE(content->trajectory_error.has_value());
  ASSERT_EQ(content->objects.size(), 1U);
  EXPECT_EQ(content->objects.front().object.name, "sofa");
  EXPECT_EQ(content->objects.front().observations, 3U);
  // The first key-frame's camera is the map's world.
  EXPECT_LT((content->objects.front().object.place_world - Eigen::Vector3d(0.1, 0.2, 1.5)).norm(),
            0.02);
  EXPECT_FALSE(content->stages.empty());
}

TEST(MapSettings, SurviveTheHome) {
  MapSettings settings;
  settings.features = features::FeatureKind::kOrb;
  settings.mapper.seed = 12345678901234ULL;
  settings.mapper.keyframe_translation_m = 0.1 + 0.2;  // no short decimal
  const auto again = map_settings_from_json(to_json(settings));
  ASSERT_OK(again);
  EXPECT_EQ(to_json(*again), to_json(settings));
  EXPECT_EQ(again->mapper.keyframe_translation_m, 0.1 + 0.2);
  EXPECT_TRUE(again->bundle_adjustment);
  settings.mapper.device_motion = false;
  EXPECT_FALSE(map_settings_from_json(to_json(settings))->mapper.device_motion);
  EXPECT_TRUE(again->refinement.uses_gravity);
  settings.refinement.uses_gravity = false;
  EXPECT_FALSE(map_settings_from_json(to_json(settings))->refinement.uses_gravity);
  settings.bundle_adjustment = false;
  EXPECT_FALSE(map_settings_from_json(to_json(settings))->bundle_adjustment);
  EXPECT_ERROR(map_settings_from_json("{}"), "cannot be read");
}

}  // namespace
}  // namespace roomwise::pipeline
