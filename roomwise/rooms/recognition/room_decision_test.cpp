#include "roomwise/rooms/recognition/room_decision.h"

#include <gmock/gmock.h>

#include <cmath>
#include <stdexcept>

#include "roomwise/rooms/testing/test_rooms.h"

namespace roomwise::rooms {
namespace {

using objects::ObjectScore;
using ::testing::HasSubstr;

const std::vector<Room> kLearned = {{"bath", "toilet"}, {"hall", "hall"}, {"kitchen", "kitchen"}};

TEST(Decide, NamesAProbableRoom) {
  const RoomDecision decision = decide(evidence(0.05, 0.05, 0.9), kRooms, test_model());
  EXPECT_EQ(decision.verdict, Verdict::kRoom);
  EXPECT_EQ(decision.room(), "kitchen");
  EXPECT_DOUBLE_EQ(decision.rooms[0].score, 0.9);
  EXPECT_EQ(decision.rooms[1].room, "bath") << "equal ones in the order of rooms";
  EXPECT_THAT(decision.why, HasSubstr("looks like kitchen (0.90)"));
}

TEST(Decide, IsNotSureBelowTheThreshold) {
  const RoomDecision decision = decide(evidence(0.25, 0.36, 0.39), kRooms, test_model());
  EXPECT_EQ(decision.verdict, Verdict::kNotSure);
  EXPECT_EQ(decision.room(), std::nullopt);
  EXPECT_FALSE(decision.allows("kitchen"));
  EXPECT_THAT(decision.why, HasSubstr("kitchen (0.39) or hall (0.36)"));
}

TEST(Decide, SaysTheTwoRoomsThatItMayBe) {
  const RoomDecision decision = decide(evidence(0.02, 0.2, 0.78), kRooms, test_model());
  EXPECT_EQ(decision.verdict, Verdict::kEither);
  EXPECT_EQ(decision.room(), std::nullopt);
  EXPECT_TRUE(decision.allows("kitchen"));
  EXPECT_TRUE(decision.allows("hall"));
  EXPECT_FALSE(decision.allows("bath"));
  EXPECT_THAT(decision.why, HasSubstr("kitchen (0.78) or hall (0.20)"));
  EXPECT_EQ(decide(evidence(0.01, 0.18, 0.81), kRooms, test_model()).verdict, Verdict::kRoom);
}

TEST(Decide, ARoomIsAsProbableAsThatItIsOneOfThemAtAll) {
  // Log odds of log 4: 0.8 that it is one of the rooms.
  const RoomDecision unsure = decide(evidence(0, 0.04, 0.96, std::log(4)), kRooms, test_model());
  EXPECT_EQ(unsure.verdict, Verdict::kEither) << "0.77 for the kitchen, 0.8 for both";
  const RoomDecision decision = decide(evidence(0, 0.01, 0.99, -1.5), kRooms, test_model());
  EXPECT_EQ(decision.verdict, Verdict::kNotSure);
  EXPECT_THAT(decision.why, HasSubstr("looks like what was learned by 0.18"));
}

TEST(Decide, KnowsNoRoomThatLooksLikeThis) {
  const RoomDecision decision = decide(evidence(0, 0.01, 0.99, -2.1), kRooms, test_model());
  EXPECT_EQ(decision.verdict, Verdict::kNoneOfThem);
  EXPECT_EQ(decision.room(), std::nullopt);
  EXPECT_THAT(decision.why, HasSubstr("nothing that was learned"));
}

TEST(Combine, OnePictureStaysAsItIs) {
  const auto one = evidence(0.1, 0.2, 0.7, 0.4);
  const PictureEvidence combined = combine(std::span(&one, 1));
  EXPECT_TRUE(combined.probabilities.isApprox(one.probabilities));
  EXPECT_DOUBLE_EQ(combined.familiarity, 0.4);
}

TEST(Combine, TwoPicturesCountAsFourThirds) {
  const std::vector<PictureEvidence> two = {evidence(0.2, 0.2, 0.6, 1), evidence(0.2, 0.2, 0.6, 2)};
  const PictureEvidence combined = combine(two);
  EXPECT_NEAR(combined.probabilities[2] / combined.probabilities[0], std::pow(3, 4.0 / 3), 1e-9);
  EXPECT_DOUBLE_EQ(combined.familiarity, (1 + 2) / 2.0 * 4 / 3);
  EXPECT_NEAR(combined.probabilities.sum(), 1, 1e-12);
}

TEST(Combine, TheSurerPictureCountsMore) {
  const std::vector<PictureEvidence> two = {evidence(0.5, 0.3, 0.2), evidence(0.01, 0.01, 0.98)};
  Eigen::Index best = 0;
  combine(two).probabilities.maxCoeff(&best);
  EXPECT_EQ(best, 2);
}

TEST(Combine, APictureThatIsCertainRulesNothingOut) {
  const std::vector<PictureEvidence> two = {evidence(1, 0, 0), evidence(0, 0, 1)};
  const PictureEvidence combined = combine(two);
  EXPECT_NEAR(combined.probabilities[0], 0.5, 1e-3);
  EXPECT_THROW((void)combine({}), std::invalid_argument);
}

TEST(LikelihoodOfObjects, TheHomesOwnPicturesCountMoreThanTypes) {
  // A stove that stands in the hall of this home; 9 of 9 pictures show it, and none of the others.
  std::vector<NamedPicture> pictures(9, {"hall", {"stove"}});
  pictures.insert(pictures.end(), 9, {"kitchen", {}});
  pictures.insert(pictures.end(), 9, {"bath", {}});
  const RoomObjects learned(pictures);
  const std::vector<ObjectScore> seen = {{"stove", 0.5}};
  const Eigen::VectorXd likelihood =
      likelihood_of_objects(seen, Concepts::standard(), kLearned, learned);
  // Weights 0.95, 0.05 and 0.05; trusted by 0.35.
  EXPECT_NEAR(likelihood[1], 0.65 + 0.35 * 3 * 0.95 / 1.05, 1e-12);
  EXPECT_NEAR(likelihood[2], 0.65 + 0.35 * 3 * 0.05 / 1.05, 1e-12);
  EXPECT_NEAR(likelihood.sum(), 3, 1e-12);
  const RoomDecision decision = decide_with_objects(
      evidence(0.3, 0.4, 0.3), seen, Concepts::standard(), kLearned, test_model(), learned);
  EXPECT_EQ(decision.object, "stove");
  EXPECT_EQ(decision.rooms.front().room, "hall");
  // What no picture shows is known by its type.
  const std::vector<ObjectScore> fridge = {{"fridge", 1}};
  EXPECT_GT(likelihood_of_objects(fridge, Concepts::standard(), kLearned, learned)[2], 2);
}

TEST(LikelihoodOfObjects, AnObjectSpeaksForTheRoomsOfItsType) {
  const std::vector<ObjectScore> seen = {{"stove", 0.5}};
  const Eigen::VectorXd likelihood = likelihood_of_objects(seen, Concepts::standard(), kLearned);
  // Trusted by 0.7 * 0.5 = 0.35: then it is the kitchen, one of three.
  EXPECT_NEAR(likelihood[2], 0.65 + 0.35 * 3, 1e-12);
  EXPECT_NEAR(likelihood[0], 0.65, 1e-12);
  EXPECT_NEAR(likelihood.mean(), 1, 1e-12);
}

TEST(LikelihoodOfObjects, SeveralRoomsOfATypeShareIt) {
  const std::vector<Room> rooms = {{"Anna's", "bedroom"}, {"Ben's", "bedroom"}, {"hall", "hall"}};
  const std::vector<ObjectScore> seen = {{"bed", 1.0}};
  const Eigen::VectorXd likelihood = likelihood_of_objects(seen, Concepts::standard(), rooms);
  EXPECT_NEAR(likelihood[0], 0.3 + 0.7 * 1.5, 1e-12);
  EXPECT_DOUBLE_EQ(likelihood[0], likelihood[1]);
}

TEST(LikelihoodOfObjects, WhatStandsAnywhereOrNowhereHereSaysNothing) {
  Concepts concepts = Concepts::standard();
  concepts.objects_of_room_type["kitchen"].insert("lamp");  // and in bedrooms
  const std::vector<ObjectScore> seen = {{"lamp", 0.9}, {"bed", 0.9}, {"banana", 0.9}};
  EXPECT_TRUE(likelihood_of_objects(seen, concepts, kLearned).isApprox(Eigen::Vector3d::Ones()))
      << "this home has no bedroom";
}

TEST(DecideWithObjects, AnObjectDecidesWhereRoomsLookAlike) {
  const std::vector<ObjectScore> seen = {{"stove", 0.95}, {"toilet seat", 0.02}};
  const auto alone = evidence(0.05, 0.4, 0.55);
  EXPECT_EQ(decide(alone, kRooms, test_model()).verdict, Verdict::kEither);
  const RoomDecision decision =
      decide_with_objects(alone, seen, Concepts::standard(), kLearned, test_model());
  EXPECT_EQ(decision.room(), "kitchen");
  EXPECT_EQ(decision.object, "stove");
  EXPECT_THAT(decision.why, HasSubstr("there is a stove"));
}

TEST(DecideWithObjects, AnObjectIsNoMatchForACertainPicture) {
  // Other than under the paper's rule, under which it decides over any score.
  const std::vector<ObjectScore> seen = {{"stove", 0.6}};
  const RoomDecision decision = decide_with_objects(evidence(0.005, 0.99, 0.005), seen,
                                                    Concepts::standard(), kLearned, test_model());
  EXPECT_EQ(decision.room(), "hall");
  EXPECT_EQ(decision.object, "");
}

TEST(DecideWithObjects, ObjectsMakeNoUnknownPlaceAKnownOne) {
  const std::vector<ObjectScore> seen = {{"stove", 1.0}};
  EXPECT_EQ(
      decide_with_objects(evidence(0, 0, 1, -3), seen, Concepts::standard(), kLearned, test_model())
          .verdict,
      Verdict::kNoneOfThem);
}

TEST(Verdict, HasWordsForPeople) {
  EXPECT_EQ(to_string(Verdict::kRoom), "room");
  EXPECT_EQ(to_string(Verdict::kEither), "either");
  EXPECT_EQ(to_string(Verdict::kNotSure), "not sure");
  EXPECT_EQ(to_string(Verdict::kNoneOfThem), "none of them");
}

}  // namespace
}  // namespace roomwise::rooms
