#include "roomwise/pipeline/rooms/home_places.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/pipeline/mapping/map_recording.h"
#include "roomwise/pipeline/rooms/room_learning.h"
#include "roomwise/pipeline/rooms/room_recognizer.h"
#include "roomwise/pipeline/testing/synthetic_walk.h"

namespace roomwise::pipeline {
namespace {

using testing::ColorNetwork;
using ::testing::HasSubstr;
using testing::SyntheticWalk;

// A home of which a walk was mapped and learned: its first half is the hall, the rest the kitchen.
class HomePlacesTest : public ::testing::Test {
 protected:
  static constexpr int kFrames = 60;
  static constexpr double kStep_rad = 0.05;

  static void SetUpTestSuite() {
    folder_ = std::make_unique<roomwise::testing::ScratchFolder>();
    ThreadPool pool(2);
    SilentProgress progress;
    StageClock clock;
    RunContext run{pool, progress, clock};
    SyntheticWalk walk(kFrames, kStep_rad);
    auto home = create_home(*folder_ / "a.home");
    ASSERT_OK(home);
    networks_.push_back(std::make_unique<ColorNetwork>());
    ASSERT_OK(map_recording(walk,
                            {"walk", "made up", walk.info().camera, walk.info().frames_remaining},
                            *home, networks_, {}, run));
    const auto labels = recording::RoomLabels::from_ranges(
        {{0, kFrames / 2 - 1, "hall", 1}, {kFrames / 2, kFrames - 1, "kitchen", 1}});
    ASSERT_OK(labels);
    ASSERT_OK(name_rooms(*home, home->recordings()->back().id, *labels));
    ASSERT_OK(learn_rooms_from_keyframes(*home, {}, {.variants = 0}, {}, run));
    home_.emplace(*std::move(home));
  }
  static void TearDownTestSuite() {
    home_.reset();
    networks_.clear();
    folder_.reset();
  }

  // A frame of another walk through the home, from beside where the map was made.
  static PictureToLocate at_home(std::uint64_t frame) {
    SyntheticWalk visit(2 * kFrames, kStep_rad / 2);
    visit.skip_before(frame);
    image::RgbdFrame seen = visit.next().value().value();
    return {std::move(seen.color), std::move(seen.depth), visit.info().camera};
  }
  // Blocks of any grey at any distance: nothing that the home has.
  static PictureToLocate elsewhere() {
    PictureToLocate picture = at_home(31);
    RandomStream random(1);
    constexpr int kBlock = 8;
    for (int y = 0; y < picture.color.height(); y += kBlock) {
      for (int x = 0; x < picture.color.width(); x += kBlock) {
        const auto level = static_cast<std::uint8_t>(random.uniform() * 255);
        const auto depth = static_cast<std::uint16_t>(1000 + random.uniform() * 2000);
        for (int i = 0; i < kBlock * kBlock; ++i) {
          picture.color.at(x + i % kBlock, y + i / kBlock) = {level, level, level};
          picture.depth->at(x + i % kBlock, y + i / kBlock) = depth;
        }
      }
    }
    return picture;
  }

  inline static std::unique_ptr<roomwise::testing::ScratchFolder> folder_;
  inline static Networks networks_;
  inline static std::optional<home::Home> home_;
  ThreadPool pool_{2};
  SilentProgress progress_;
  StageClock clock_;
  RunContext run_{pool_, progress_, clock_};
};

TEST_F(HomePlacesTest, APlaceOnTheMapSpeaksForThisHomeAndNoneAgainstIt) {
  const auto places = HomePlaces::create(*home_, {}, run_);
  ASSERT_OK(places);
  const std::vector<std::string> rooms{"hall", "kitchen"};
  const std::vector<PictureToLocate> visit{at_home(29), at_home(31)};
  for (const auto& pictures : {std::span(visit), std::span(visit).first(1)}) {
    const auto here = places->look(pictures, rooms);
    ASSERT_OK(here);
    EXPECT_GT(here->log_likelihood_ratio, 0);
    EXPECT_NEAR(here->probabilities.sum(), 1, 1e-12);
  }
  const PictureToLocate other = elsewhere();
  const auto nowhere = places->look(std::span(&other, 1), rooms);
  ASSERT_OK(nowhere);
  EXPECT_LT(nowhere->log_likelihood_ratio, 0);
  EXPECT_THAT(nowhere->why, HasSubstr("no place on the map"));
}

TEST_F(HomePlacesTest, TheRecognizerAsksForThePlaceWhereItMayTell) {
  const auto places = HomePlaces::create(*home_, {}, run_);
  ASSERT_OK(places);
  const auto recognizer = RoomRecognizer::create(*home_, networks_);
  ASSERT_OK(recognizer);
  int asked = 0;
  const auto recognize = [&](const PictureToLocate& picture) {
    return recognizer
        ->recognize(std::vector{picture.color},
                    [&] {
                      ++asked;
                      return places->look(std::span(&picture, 1), recognizer->rooms());
                    })
        .value();
  };
  const PictureToLocate other = elsewhere();
  const rooms::RoomDecision decision = recognize(other);
  EXPECT_EQ(asked, 1) << "it is not known well enough";
  EXPECT_THAT(decision.why, HasSubstr("no place on the map"));
  const auto alone = recognizer->recognize(std::vector{other.color});
  ASSERT_OK(alone);
  EXPECT_LT(decision.familiarity, alone->familiarity);
  // Whatever is sure enough by its looks alone has the same answer without its place.
  for (std::uint64_t frame = 1; frame < 2 * kFrames; frame += 6) {
    const PictureToLocate picture = at_home(frame);
    const int before = asked;
    const rooms::RoomDecision with_place = recognize(picture);
    if (asked > before) continue;
    EXPECT_EQ(with_place.why, recognizer->recognize(std::vector{picture.color})->why);
    EXPECT_EQ(with_place.verdict, rooms::Verdict::kRoom);
  }
  EXPECT_LT(asked, 2 + kFrames / 3) << "some are sure enough";
}

TEST_F(HomePlacesTest, AHomeWithoutAMapHasNoPlaces) {
  const auto empty = create_home(*folder_ / "empty.home");
  ASSERT_OK(empty);
  EXPECT_ERROR(HomePlaces::create(*empty, {}, run_), "no map");
}

}  // namespace
}  // namespace roomwise::pipeline
