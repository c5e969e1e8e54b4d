#include "roomwise/pipeline/room_recognizer.h"

#include <gmock/gmock.h>

#include "roomwise/home/sample_home.h"
#include "roomwise/pipeline/room_learning.h"
#include "roomwise/pipeline/synthetic_walk.h"

namespace roomwise::pipeline {
namespace {

using rooms::PictureEvidence;
using rooms::PlaceEvidence;
using rooms::Verdict;
using ::testing::HasSubstr;
using ::testing::Not;

// A recognizer of a hall and a kitchen. What pictures and places say is made up here.
class RoomRecognizerPlaces : public ::testing::Test {
 protected:
  void SetUp() override {
    networks_.push_back(std::make_unique<testing::ColorNetwork>());
    const std::string& fingerprint = networks_.front()->fingerprint();
    home::Home home = home::Home::create(folder_ / "a.home").value();
    ROOMWISE_MUST(home.add_recording(home::testing::sample_recording()));
    ROOMWISE_MUST(home.add_network({"colors", fingerprint, {}, 12}));
    for (home::KeyframeId id = 0; id < 40; ++id) {
      home::Step step = home::testing::sample_step(1, 1, id);
      RandomStream random(id);
      std::vector<float> features(12);
      for (float& value : features) value = static_cast<float>(random.uniform());
      features[id < 20 ? 0 : 1] += 4;
      step.keyframes[0].predictions = {{1, {features, {}}}};
      step.keyframes[0].sightings.clear();
      ROOMWISE_MUST(home.commit_step(step));
    }
    ROOMWISE_MUST(
        home.replace_rooms(std::vector<rooms::Room>{{"hall", "hall"}, {"kitchen", "kitchen"}}));
    ROOMWISE_MUST(home.replace_room_ranges(1, {{0, 59, "hall", 1}, {60, 119, "kitchen", 1}}));
    ThreadPool pool(1);
    SilentProgress progress;
    StageClock clock;
    RunContext run{pool, progress, clock};
    ASSERT_OK(learn_rooms_from_keyframes(home, 1, {}, {}, {}, run));
    auto made = RoomRecognizer::create(home, networks_);
    ASSERT_OK(made);
    recognizer_.emplace(*std::move(made));
  }

  static PictureEvidence picture(double hall, double known) {
    return {Eigen::Vector2d(hall, 1 - hall), known};
  }
  // Well known, and sure enough to be named.
  static PictureEvidence sure_hall() { return picture(0.999, 3); }
  static PictureEvidence open_question() { return picture(0.5, 3); }

  // Says what it was told to, and counts how often it was asked.
  RoomRecognizer::FindPlace place(double hall, double home_log_ratio) {
    return [=, this]() -> Expected<PlaceEvidence> {
      ++asked_;
      return PlaceEvidence{Eigen::Vector2d(hall, 1 - hall), home_log_ratio, "its place is told"};
    };
  }
  RoomRecognizer::FindPlace broken_place() {
    return []() -> Expected<PlaceEvidence> { return fail("the depth image is damaged"); };
  }
  Expected<rooms::RoomDecision> decide(const PictureEvidence& picture,
                                       const RoomRecognizer::FindPlace& find_place) {
    return recognizer_->decide(std::span(&picture, 1), {}, find_place);
  }

  roomwise::testing::ScratchFolder folder_;
  Networks networks_;
  std::optional<RoomRecognizer> recognizer_;
  int asked_ = 0;
};

TEST_F(RoomRecognizerPlaces, IsNotAskedWhereThePictureTellsTheRoom) {
  const auto decision = decide(sure_hall(), place(0.01, 5));
  ASSERT_OK(decision);
  EXPECT_EQ(asked_, 0);
  EXPECT_EQ(decision->room(), "hall");
  EXPECT_THAT(decision->why, Not(HasSubstr("its place")));
}

TEST_F(RoomRecognizerPlaces, DecidesWhereThePictureLeavesRoomsOpen) {
  EXPECT_EQ(decide(open_question(), {})->verdict, Verdict::kNotSure);
  const auto decision = decide(open_question(), place(0.01, 5));
  ASSERT_OK(decision);
  EXPECT_EQ(asked_, 1);
  EXPECT_EQ(decision->room(), "kitchen");
  EXPECT_THAT(decision->why, HasSubstr("; its place is told"));
}

TEST_F(RoomRecognizerPlaces, MakesAHardlyKnownPictureKnown) {
  const PictureEvidence dark = picture(0.999, recognizer_->calibration().none_below - 1);
  EXPECT_EQ(decide(dark, {})->verdict, Verdict::kNoneOfThem);
  EXPECT_EQ(decide(dark, place(0.99, 5))->room(), "hall");
  EXPECT_EQ(asked_, 1);
}

TEST_F(RoomRecognizerPlaces, ThatThereIsNoneSpeaksAgainstThisHome) {
  const PictureEvidence hardly = picture(0.999, recognizer_->calibration().known_from + 0.1);
  EXPECT_EQ(decide(hardly, {})->room(), "hall");
  const auto decision = decide(hardly, place(0.5, -3));
  ASSERT_OK(decision);
  EXPECT_NE(decision->verdict, Verdict::kRoom);
  EXPECT_THAT(decision->why, HasSubstr("its place is told"));
}

TEST_F(RoomRecognizerPlaces, ThatContradictsAHardlyKnownPictureLeavesNoRoom) {
  const PictureEvidence hardly = picture(0.99, recognizer_->calibration().known_from + 0.1);
  EXPECT_EQ(decide(hardly, place(0.01, 5))->verdict, Verdict::kNotSure);
}

TEST_F(RoomRecognizerPlaces, WhatGoesWrongWhileLookingIsSaid) {
  EXPECT_ERROR(decide(open_question(), broken_place()), "depth image is damaged");
  EXPECT_OK(decide(sure_hall(), broken_place())) << "it is not asked";
  rooms::RoomStream stream = recognizer_->stream().value();
  EXPECT_ERROR(recognizer_->see(stream, open_question(), 1, broken_place()),
               "depth image is damaged");
}

TEST_F(RoomRecognizerPlaces, IsJoinedWithEveryPictureOfAWalkThatNeedsIt) {
  rooms::RoomStream stream = recognizer_->stream().value();
  auto decision = recognizer_->see(stream, open_question(), 1, place(0.01, 5));
  ASSERT_OK(decision);
  EXPECT_EQ(asked_, 1);
  EXPECT_EQ(decision->room(), "kitchen");
  EXPECT_THAT(decision->why, HasSubstr("; its place is told"));
  decision = recognizer_->see(stream, picture(0.001, 3), 1, place(0.99, 5));
  ASSERT_OK(decision);
  EXPECT_EQ(asked_, 1);
  EXPECT_EQ(decision->room(), "kitchen");
  EXPECT_THAT(decision->why, Not(HasSubstr("its place")));
}

}  // namespace
}  // namespace roomwise::pipeline
