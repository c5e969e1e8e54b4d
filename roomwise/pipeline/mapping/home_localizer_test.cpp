#include "roomwise/pipeline/mapping/home_localizer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/base/testing/testing.h"
#include "roomwise/pipeline/mapping/map_recording.h"
#include "roomwise/pipeline/rooms/room_learning.h"
#include "roomwise/pipeline/testing/synthetic_walk.h"

namespace roomwise::pipeline {
namespace {

using geometry::RigidTransform;
using testing::SyntheticWalk;

class HomeLocalizerTest : public ::testing::Test {
 protected:
  static constexpr int kFrames = 45;
  static constexpr double kStep_rad = 0.05;

  void map(mapping::MappingMethod method) {
    SyntheticWalk walk(kFrames, kStep_rad);
    Expected<home::Home> home = create_home(folder_ / "a.home");
    ASSERT_OK(home);
    MapSettings settings;
    settings.mapper = mapping::MapperOptions::of(method);
    ASSERT_OK(map_recording(walk,
                            {"walk", "made up", walk.info().camera, walk.info().frames_remaining},
                            *home, {}, settings, run_));
  }
  Expected<HomeLocalizer> localizer() {
    ROOMWISE_TRY(const home::Home home, home::Home::open_read_only(folder_ / "a.home"));
    return HomeLocalizer::create(home, {}, run_);
  }
  // How far from the truth a frame of another walk is taken to be, from 0.5 steps beside where the
  // map was made.
  static void expect_found(const HomeLocalizer& localizer, bool with_depth) {
    SyntheticWalk visit(2 * kFrames, kStep_rad / 2);
    visit.skip_before(31);
    const image::RgbdFrame frame = visit.next().value().value();
    const auto measured = localizer.measure(
        {frame.color, with_depth ? std::optional(frame.depth) : std::nullopt, visit.info().camera});
    ASSERT_OK(measured);
    const mapping::Localization found =
        localizer.localizer().locate({*measured, visit.info().camera});
    ASSERT_TRUE(found.found()) << to_string(found.status);
    const RigidTransform error = visit.world_from_camera(31).inverse() * found.world_from_camera;
    EXPECT_LT(error.distance_m(), 0.02);
    EXPECT_LT(error.angle_rad(), 0.02);
  }

  roomwise::testing::ScratchFolder folder_;
  ThreadPool pool_{2};
  SilentProgress progress_;
  StageClock clock_;
  RunContext run_{pool_, progress_, clock_};
};

TEST_F(HomeLocalizerTest, FindsPicturesOfAnotherWalkOnTheMap) {
  map(mapping::MappingMethod::kCombined);
  const auto found = localizer();
  ASSERT_OK(found);
  expect_found(*found, true);
  expect_found(*found, false);
}

TEST_F(HomeLocalizerTest, AMapOfThePapersMethodServesAsWell) {
  map(mapping::MappingMethod::kPaper);
  const auto found = localizer();
  ASSERT_OK(found);
  expect_found(*found, true);
}

TEST_F(HomeLocalizerTest, MeasuresNoKeyframeBeforeAPictureAsksForIt) {
  map(mapping::MappingMethod::kCombined);
  const auto ready = localizer();
  ASSERT_OK(ready);
  EXPECT_FALSE(ready->new_index()) << "map keeps it";
  {
    home::Home home = home::Home::open(folder_ / "a.home").value();
    auto kept = home.derived_data("localizer").value().value();
    kept.data.pop_back();
    ASSERT_OK(home.put_derived_data(kept));
  }
  const auto measured = localizer();
  ASSERT_OK(measured);
  ASSERT_TRUE(measured->new_index()) << "what is damaged is made anew";
  home::Home home = home::Home::open(folder_ / "a.home").value();
  ASSERT_OK(home.put_derived_data(*measured->new_index()));
  EXPECT_FALSE(HomeLocalizer::create(home, {}, run_)->new_index());

  // The same answers, to the bit.
  SyntheticWalk visit(2 * kFrames, kStep_rad / 2);
  visit.skip_before(31);
  const image::RgbdFrame frame = visit.next().value().value();
  const auto place = [&](const HomeLocalizer& localizer) {
    const auto seen = localizer.measure({frame.color, frame.depth, visit.info().camera}).value();
    return localizer.localizer().locate({seen, visit.info().camera});
  };
  const mapping::Localization a = place(*ready), b = place(*measured);
  EXPECT_TRUE(a.found());
  EXPECT_EQ(a.world_from_camera.translation, b.world_from_camera.translation);
  EXPECT_EQ(a.information, b.information);
}

TEST_F(HomeLocalizerTest, DoesWithoutKeyframesThatWereTakenOutMeanwhile) {
  map(mapping::MappingMethod::kCombined);
  const auto found = localizer();
  ASSERT_OK(found);
  home::Home home = home::Home::open(folder_ / "a.home").value();
  ASSERT_OK(home.remove_recording(home.recordings()->front().id));
  SyntheticWalk visit(2 * kFrames, kStep_rad / 2);
  visit.skip_before(31);
  const image::RgbdFrame frame = visit.next().value().value();
  const auto seen = found->measure({frame.color, frame.depth, visit.info().camera});
  ASSERT_OK(seen);
  EXPECT_FALSE(found->localizer().locate({*seen, visit.info().camera}).found());
  EXPECT_FALSE(found->take_failure());
}

TEST_F(HomeLocalizerTest, TellsOnceOfAKeyframeThatCannotBeReadAndGoesOn) {
  map(mapping::MappingMethod::kCombined);
  const auto found = localizer();
  ASSERT_OK(found);
  home::Home home = home::Home::open(folder_ / "a.home").value();
  ASSERT_OK(home.database().run("UPDATE keyframe_images SET color = x'00'"));
  SyntheticWalk visit(2 * kFrames, kStep_rad / 2);
  visit.skip_before(31);
  const image::RgbdFrame frame = visit.next().value().value();
  const PictureToLocate picture{frame.color, frame.depth, visit.info().camera};
  const auto seen = found->measure(picture);
  ASSERT_OK(seen);
  EXPECT_FALSE(found->localizer().locate({*seen, visit.info().camera}).found());
  EXPECT_ERROR(found->measure(picture), "key-frame");
  EXPECT_OK(found->measure(picture)) << "it is asked anew, and told again if it fails again";
}

TEST_F(HomeLocalizerTest, PicturesOfAnotherSizeThanTheCamerasAreRefused) {
  map(mapping::MappingMethod::kCombined);
  const auto found = localizer();
  ASSERT_OK(found);
  const geometry::PinholeCamera camera = SyntheticWalk(1).info().camera;
  EXPECT_ERROR(found->measure({image::ColorImage(640, 480), std::nullopt, camera}),
               "640x480, the camera takes 320x240");
  EXPECT_ERROR(found->measure({image::ColorImage(320, 240), image::DepthImage(160, 120), camera}),
               "depth image is 160x120");
}

TEST_F(HomeLocalizerTest, AHomeWithoutAMapIsRefused) {
  ASSERT_OK(create_home(folder_ / "a.home"));
  EXPECT_ERROR(localizer(), "no map");
}

}  // namespace
}  // namespace roomwise::pipeline
