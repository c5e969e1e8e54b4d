#include "roomwise/rooms/learning/visit_learning.h"

#include <gmock/gmock.h>

#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/rooms/learning/room_learner.h"
#include "roomwise/rooms/testing/test_rooms.h"

namespace roomwise::rooms {
namespace {

using ::testing::ElementsAre;
using ::testing::Optional;
using ::testing::SizeIs;

LocalizationEvidence place_in(double bath, double hall, double kitchen,
                              double log_likelihood_ratio = 5) {
  return {Eigen::Vector3d(bath, hall, kitchen), log_likelihood_ratio, ""};
}

// Of the first picture of a walk.
RoomAgreement agreement(const PictureEvidence& picture, const LocalizationEvidence& place) {
  const RoomDecision along_walk = decide(picture, kRooms, test_model());
  return {room_by_picture(picture, along_walk, kRooms), room_by_place(place, {})};
}

TEST(RoomAgreement, TakesPictureAndPlaceThatBothAreSure) {
  const RoomAgreement both = agreement(evidence(0.02, 0.9, 0.08), place_in(0.005, 0.99, 0.005));
  EXPECT_TRUE(both.is_agreed());
  EXPECT_FALSE(both.is_contradictory());
  EXPECT_THAT(both.by_place, Optional(std::size_t{1}));
}

TEST(RoomAgreement, WhatContradictsItsPlaceIsNotAgreed) {
  const RoomAgreement both = agreement(evidence(0.02, 0.9, 0.08), place_in(0.005, 0.005, 0.99));
  EXPECT_FALSE(both.is_agreed());
  EXPECT_TRUE(both.is_contradictory());
}

TEST(RoomAgreement, WhatIsUnsureIsNeitherAgreedNorContradictory) {
  const PictureEvidence sure = evidence(0.02, 0.9, 0.08);
  const LocalizationEvidence deep = place_in(0.005, 0.99, 0.005);
  for (const RoomAgreement& one :
       {agreement(evidence(0.05, 0.7, 0.25), deep),         // two rooms by the picture
        agreement(evidence(0.02, 0.9, 0.08, -1.5), deep),   // hardly known
        agreement(sure, place_in(0.005, 0.9, 0.095)),       // near a doorway
        agreement(sure, place_in(0.005, 0.99, 0.005, 0)),   // a place that fits other homes, too
        agreement(sure, place_in(1. / 3, 1. / 3, 1. / 3)),  // in no room
        agreement(evidence(0.1, 0.2, 0.7), place_in(1. / 3, 1. / 3, 1. / 3, -3))}) {
    EXPECT_FALSE(one.is_agreed());
    EXPECT_FALSE(one.is_contradictory());
  }
}

TEST(RoomAgreement, APictureMustShowTheRoomThatTheWalkIsIn) {
  const RoomDecision in_hall = decide(evidence(0.02, 0.96, 0.02), kRooms, test_model());
  const auto room = [&](const PictureEvidence& picture) {
    return room_by_picture(picture, in_hall, kRooms);
  };
  EXPECT_THAT(room(evidence(0.3, 0.5, 0.2)), Optional(std::size_t{1})) << "the walk makes it sure";
  EXPECT_EQ(room(evidence(0.5, 0.3, 0.2)), std::nullopt) << "it looks more like the bath";
  EXPECT_EQ(room(evidence(0.3, 0.5, 0.2, -1.5)), std::nullopt) << "it is hardly known";
}

// Two rooms that were learned from pictures around an axis of each; a light of a later day lies
// along further axes.
class ChoosePictures : public ::testing::Test {
 protected:
  static std::vector<float> picture(std::size_t room, double light, std::uint64_t seed) {
    RandomStream random(seed);
    std::vector<float> features(8, 0.05F);
    features[room] = 4;
    features[2 + room] = static_cast<float>(light);
    for (float& value : features) value += static_cast<float>(0.3 * random.uniform());
    return features;
  }
  static RoomClassifier classifier() {
    std::vector<RoomSample> samples;
    // Four pictures of each of five views of a room: neighbours on the walk.
    for (std::uint64_t i = 0; i < 40; ++i) {
      samples.push_back({picture(i % 2, 0, i / 8), i % 2 == 0 ? "bath" : "kitchen"});
    }
    return learn_rooms(samples, {"net", "abc"})->classifier;
  }
};

TEST_F(ChoosePictures, TakesWhatIsLeastKnownAndNothingThatIsKnownWell) {
  const RoomClassifier known = classifier();
  const std::vector<RoomPicture> agreed{{picture(0, 0, 2), "bath"},      // one it was learned from
                                        {picture(0, 0.6, 103), "bath"},  //
                                        {picture(0, 1.5, 104), "bath"},
                                        {picture(1, 0, 4), "kitchen"}};  // another
  EXPECT_THAT(*choose_pictures(known, agreed, {.max_of_visit = 1}), ElementsAre(2))
      << "the strangest light of the bath, and nothing of the kitchen";
  const auto more = choose_pictures(known, agreed, {});
  ASSERT_OK(more);
  EXPECT_THAT(*more, ::testing::Not(::testing::Contains(0)));
  EXPECT_THAT(*more, ::testing::Not(::testing::Contains(3)));
}

TEST_F(ChoosePictures, TakesNoMoreOfARoomThanItMay) {
  std::vector<RoomPicture> agreed;
  for (std::uint64_t i = 0; i < 30; ++i) {
    agreed.push_back({picture(i % 2, 1.5, 200 + i), i % 2 == 0 ? "bath" : "kitchen"});
  }
  const auto chosen = choose_pictures(classifier(), agreed, {.max_of_visit = 3, .max_of_room = 9});
  ASSERT_OK(chosen);
  EXPECT_THAT(*chosen, SizeIs(6));
  EXPECT_TRUE(std::ranges::is_sorted(*chosen));
}

TEST_F(ChoosePictures, OnceTheyAreRememberedTheVisitIsKnownBetter) {
  const RoomClassifier known = classifier();
  std::vector<RoomPicture> agreed;
  for (std::uint64_t i = 0; i < 12; ++i) agreed.push_back({picture(0, 1.5, 300 + i), "bath"});
  const auto chosen = choose_pictures(known, agreed, {.max_of_visit = 4});
  ASSERT_OK(chosen);
  std::vector<RoomPicture> learned;
  for (const std::size_t i : *chosen) learned.push_back(agreed[i]);
  const auto knowing = known.with(learned);
  ASSERT_OK(knowing);
  const std::vector<float> like_them = picture(0, 1.5, 999);
  EXPECT_GT(knowing->evidence(like_them)->familiarity,
            known.evidence(like_them)->familiarity + 0.5);
}

TEST_F(ChoosePictures, RefusesOptionsThatMakeNoSense) {
  EXPECT_ERROR(choose_pictures(classifier(), {}, {.min_inside = 1}), "min_inside is 1");
  EXPECT_ERROR(choose_pictures(classifier(), {}, {.max_of_visit = 0}), "max_of_visit is 0");
  EXPECT_ERROR(choose_pictures(classifier(), {}, {.max_of_visit = 9, .max_of_room = 5}),
               "max_of_room is 5");
}

}  // namespace
}  // namespace roomwise::rooms
