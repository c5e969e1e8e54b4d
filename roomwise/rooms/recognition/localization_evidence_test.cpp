#include "roomwise/rooms/recognition/localization_evidence.h"

#include <gmock/gmock.h>

#include "roomwise/rooms/recognition/room_decision.h"
#include "roomwise/rooms/recognition/room_stream.h"
#include "roomwise/rooms/testing/test_rooms.h"

namespace roomwise::rooms {
namespace {

using Eigen::Vector2d;
using mapping::LocalizationStatus;
using ::testing::HasSubstr;

// Bath, hall and kitchen, one behind the other, 3 m by 2 m each, open to each other at x = 3 and 6
// m.
RoomLayout three_rooms() {
  const image::Image<fusion::FloorCell> cells(90, 20, fusion::FloorCell::kFree);
  const fusion::FloorGrid grid(Vector2d::Zero(), 0.1, cells);
  WalkedPath walk;
  for (double x_m = 0.5; x_m < 8.6; x_m += 0.1) {
    walk.push_back({{x_m, 1}, x_m < 3 ? "bath" : x_m < 6 ? "hall" : "kitchen"});
  }
  return RoomLayout::make(grid, std::span(&walk, 1)).value();
}

// The localiser's answer: found `x_m` along the rooms, known to a centimetre.
mapping::Localization found_at(double x_m) {
  mapping::Localization answer;
  answer.status = LocalizationStatus::kFound;
  answer.world_from_camera.translation = {x_m, 1, 1.4};
  answer.information = 1e4 * geometry::Matrix6d::Identity();
  answer.inliers = 40;
  return answer;
}

mapping::Localization not_found(LocalizationStatus status) {
  mapping::Localization answer;
  answer.status = status;
  return answer;
}

LocalizationEvidence place(const mapping::Localization& answer, bool has_depth = true) {
  static const std::optional<RoomLayout> layout = three_rooms();
  return localization_evidence(answer, has_depth, {}, layout, kRooms);
}

RoomDecision decide_at(const PictureEvidence& pictures, const LocalizationEvidence& at) {
  return decide(with_place(pictures, at, test_model()), kRooms, test_model());
}

TEST(LocalizationEvidence, APoseDeepInARoomDecidesWherePicturesLeaveTwoOpen) {
  const PictureEvidence pictures = evidence(0.02, 0.48, 0.5);
  EXPECT_EQ(decide(pictures, kRooms, test_model()).verdict, Verdict::kEither);
  const LocalizationEvidence at = place(found_at(4.5));
  EXPECT_NEAR(at.probabilities.sum(), 1, 1e-12);
  EXPECT_GT(at.probabilities[1], 0.98);
  EXPECT_THAT(at.why, HasSubstr("in hall"));
  EXPECT_EQ(decide_at(pictures, at).room(), "hall");
}

TEST(LocalizationEvidence, APoseAtADoorwayLeavesBothRooms) {
  const LocalizationEvidence at = place(found_at(6));
  EXPECT_GT(at.probabilities[1], 0.35);
  EXPECT_GT(at.probabilities[2], 0.35);
  EXPECT_LT(at.probabilities[0], 0.01);
  EXPECT_THAT(at.why, HasSubstr("between"));
  EXPECT_EQ(decide_at(evidence(0.02, 0.48, 0.5), at).verdict, Verdict::kEither);
  EXPECT_EQ(decide_at(evidence(0.02, 0.03, 0.95), at).room(), "kitchen")
      << "there the pictures tell";
}

TEST(LocalizationEvidence, ThePlaceIsAsWideAsItIsUncertain) {
  mapping::Localization vague = found_at(5.2);
  const double exact = place(vague).probabilities[1];
  vague.information = geometry::Matrix6d::Identity();  // 1 m
  EXPECT_LT(place(vague).probabilities[1], exact - 0.1);
}

TEST(LocalizationEvidence, WhereItContradictsThePicturesNoRoomIsSaid) {
  const RoomDecision decision = decide_at(evidence(0.005, 0.015, 0.98), place(found_at(1.5)));
  EXPECT_EQ(decision.verdict, Verdict::kEither);
  EXPECT_TRUE(decision.allows("bath") && decision.allows("kitchen"));
}

TEST(LocalizationEvidence, APoseOutsideEveryFloorTellsNoRoom) {
  const LocalizationEvidence outside = place(found_at(40));
  EXPECT_NEAR(outside.probabilities.maxCoeff(), outside.probabilities.minCoeff(), 1e-12);
  EXPECT_EQ(outside.log_likelihood_ratio, 0) << "and does not say that it is one of these rooms";
  const PictureEvidence pictures = evidence(0.1, 0.2, 0.7);
  EXPECT_TRUE(
      with_place(pictures, outside, test_model()).probabilities.isApprox(pictures.probabilities));
}

TEST(LocalizationEvidence, ARoomThatWasNotLearnedSpeaksAgainstThoseThatWere) {
  const std::optional<RoomLayout> layout = three_rooms();
  const std::vector<std::string> learned{"bath", "hall"};
  const LocalizationEvidence at = localization_evidence(found_at(7.5), true, {}, layout, learned);
  EXPECT_NEAR(at.probabilities[0], at.probabilities[1], 1e-12);
  EXPECT_LT(at.log_likelihood_ratio,
            place(not_found(LocalizationStatus::kNothingSimilar)).log_likelihood_ratio)
      << "more than if there were no place";
  EXPECT_THAT(at.why, HasSubstr("in kitchen, which was not learned"));
  // The kitchen looks a little like the hall.
  const PictureEvidence alike{Eigen::Vector2d(0.02, 0.98), -1.2};
  EXPECT_EQ(decide(with_place(alike, at, test_model()), learned, test_model()).verdict,
            Verdict::kNoneOfThem);
  // Between the hall and the kitchen it speaks for both, in proportion.
  const double between =
      localization_evidence(found_at(6), true, {}, layout, learned).log_likelihood_ratio;
  EXPECT_GT(between, 0);
  EXPECT_LT(between, place(found_at(6)).log_likelihood_ratio - 2);
}

TEST(LocalizationEvidence, ARoomThatNobodyNamedSpeaksAgainstTheOthers) {
  const image::Image<fusion::FloorCell> cells(90, 20, fusion::FloorCell::kFree);
  WalkedPath walk;
  for (double x_m = 0.5; x_m < 8.6; x_m += 0.1) {
    walk.push_back({{x_m, 1}, x_m < 3 ? "bath" : x_m < 6 ? "hall" : ""});
  }
  const std::optional<RoomLayout> layout =
      RoomLayout::make({Vector2d::Zero(), 0.1, cells}, std::span(&walk, 1)).value();
  const std::vector<std::string> learned{"bath", "hall"};
  const LocalizationEvidence at = localization_evidence(found_at(7.5), true, {}, layout, learned);
  EXPECT_LT(at.log_likelihood_ratio, -2.5);
  EXPECT_THAT(at.why, HasSubstr("in a room without a name"));
}

TEST(LocalizationEvidence, AHintThatWasConfirmedTellsTheRoomAndNotTheHome) {
  mapping::Localization hint = found_at(4.5);
  hint.is_weak_hypothesis = true;
  EXPECT_EQ(place(hint).log_likelihood_ratio, 0) << "homes have windows and tiles alike";
  EXPECT_TRUE(place(hint).probabilities.isApprox(place(found_at(4.5)).probabilities));
}

TEST(LocalizationEvidence, AMapWithoutRoomsSaysThatItIsThisHome) {
  const LocalizationEvidence at =
      localization_evidence(found_at(4.5), true, {}, std::nullopt, kRooms);
  EXPECT_GT(at.log_likelihood_ratio, 0);
  EXPECT_NEAR(at.probabilities.maxCoeff(), at.probabilities.minCoeff(), 1e-12);
}

TEST(LocalizationEvidence, APlaceOnTheMapMakesAnyPictureKnown) {
  const PictureEvidence strange = evidence(0.1, 0.7, 0.2, -9);
  EXPECT_EQ(decide(strange, kRooms, test_model()).verdict, Verdict::kNoneOfThem);
  EXPECT_EQ(decide_at(strange, place(found_at(4.5))).room(), "hall");
}

TEST(LocalizationEvidence, APlaceByShapeWithLittleSupportMakesNothingKnown) {
  mapping::Localization by_shape = found_at(4.5);
  by_shape.supporting_keyframes = 3;
  by_shape.support = 0.7;
  EXPECT_EQ(place(by_shape).log_likelihood_ratio, 0)
      << "other homes have such walls and doors, too";
  EXPECT_GT(place(by_shape).probabilities[1], 0.98) << "if it is this home, it is there";
  const PictureEvidence strange = evidence(0.1, 0.7, 0.2, -2.1);
  EXPECT_EQ(decide_at(strange, place(by_shape)).verdict, Verdict::kNotSure);
  by_shape.support = 2;
  EXPECT_EQ(decide_at(strange, place(by_shape)).room(), "hall");
}

TEST(LocalizationEvidence, LittleThatFitsSaysLessOfTheHomeThanMuch) {
  const double sure = place(found_at(4.5)).log_likelihood_ratio;
  mapping::Localization by_few = found_at(4.5);
  by_few.inliers = 13;
  const double likely = place(by_few).log_likelihood_ratio;
  EXPECT_GT(likely, 0);
  EXPECT_LT(likely, sure);
  by_few.inliers = 16;
  EXPECT_EQ(place(by_few).log_likelihood_ratio, sure);

  mapping::Localization by_shape = found_at(4.5);
  by_shape.inliers = 4;
  by_shape.supporting_keyframes = 3;
  by_shape.support = 1;
  EXPECT_EQ(place(by_shape).log_likelihood_ratio, likely);
  by_shape.support = 1.4;
  EXPECT_EQ(place(by_shape).log_likelihood_ratio, sure);
}

TEST(LocalizationEvidence, ThatThereIsNoPlaceSpeaksAgainstThisHome) {
  const PictureEvidence alike = evidence(0.01, 0.97, 0.02, 2);
  EXPECT_EQ(decide(alike, kRooms, test_model()).room(), "hall");
  const LocalizationEvidence nowhere = place(not_found(LocalizationStatus::kNoMotion));
  EXPECT_NE(decide_at(alike, nowhere).verdict, Verdict::kRoom);
  EXPECT_TRUE(with_place(alike, nowhere, test_model()).probabilities.isApprox(alike.probabilities))
      << "it tells nothing of the rooms";
  const LocalizationEvidence wall = place(not_found(LocalizationStatus::kDegenerate));
  EXPECT_EQ(wall.log_likelihood_ratio, nowhere.log_likelihood_ratio);
  EXPECT_EQ(
      place(not_found(LocalizationStatus::kNoMotion), /*has_depth=*/false).log_likelihood_ratio, 0)
      << "without depth few pictures have a place";
}

// Of two pictures, where `first` and `second` were found.
LocalizationEvidence pair(const mapping::Localization& first, const mapping::Localization& second,
                          bool has_depth = true, bool contradictory = false) {
  static const std::optional<RoomLayout> layout = three_rooms();
  return localization_evidence(mapping::PairLocalization{first, second, contradictory}, has_depth,
                               {}, layout, kRooms);
}

TEST(LocalizationEvidence, OfTwoPicturesTheSecondTellsTheRoom) {
  const LocalizationEvidence both = pair(found_at(2), found_at(4.5));
  EXPECT_TRUE(both.probabilities.isApprox(place(found_at(4.5)).probabilities));
}

TEST(LocalizationEvidence, OfTwoPicturesTheFirstTellsWhereTheSecondHasNoPlace) {
  const auto lost = not_found(LocalizationStatus::kDegenerate);
  const LocalizationEvidence deep = pair(found_at(4.5), lost);
  EXPECT_GT(deep.probabilities[1], 0.9);
  EXPECT_THAT(deep.why, HasSubstr("in hall"));
  // One step on it may be in the next room.
  const LocalizationEvidence near_door = pair(found_at(5.6), lost);
  EXPECT_LT(near_door.probabilities[1], place(found_at(5.6)).probabilities[1] - 0.1);
  EXPECT_GT(near_door.probabilities[2], 0.1);
}

TEST(LocalizationEvidence, WhetherItIsThisHomeBothPicturesSay) {
  const auto lost = not_found(LocalizationStatus::kNothingSimilar);
  const double of_one = place(found_at(4.5)).log_likelihood_ratio;
  const double of_both = pair(found_at(4.5), found_at(4.5)).log_likelihood_ratio;
  EXPECT_GT(of_both, of_one);
  EXPECT_LT(of_both, 2 * of_one) << "they are of one place";
  const double of_either = pair(lost, found_at(4.5)).log_likelihood_ratio;
  EXPECT_NEAR(pair(found_at(4.5), lost).log_likelihood_ratio, of_either, 0.3);
  EXPECT_GT(of_either, 0);
  EXPECT_LT(of_either, of_one / 2);
  EXPECT_EQ(pair(lost, found_at(4.5), /*has_depth=*/false).log_likelihood_ratio, of_one)
      << "without depth few pictures have a place";
  // A place by a few features, which other homes' doors and windows have, too.
  mapping::Localization doubtful = found_at(4.5);
  doubtful.inliers = 12;
  EXPECT_GT(place(doubtful).log_likelihood_ratio, 1);
  EXPECT_LT(pair(lost, doubtful).log_likelihood_ratio, 1e-9)
      << "the other one would have a place, too";
  EXPECT_LT(pair(doubtful, lost).log_likelihood_ratio, 1e-9);
}

TEST(LocalizationEvidence, TwoPicturesThatContradictEachOtherTellNothing) {
  for (const auto status : {LocalizationStatus::kAmbiguous, LocalizationStatus::kContradicted}) {
    const LocalizationEvidence open =
        pair(found_at(4.5), not_found(status), true, /*contradictory=*/true);
    EXPECT_EQ(open.log_likelihood_ratio, 0);
    EXPECT_NEAR(open.probabilities[0], open.probabilities[1], 1e-12);
  }
  // That the second may be in two places says nothing against the first's.
  const auto twins = not_found(LocalizationStatus::kAmbiguous);
  EXPECT_GT(pair(found_at(4.5), twins).probabilities[1], 0.9);
}

TEST(LocalizationEvidence, ThatTwoPicturesHaveNoPlaceSpeaksMoreAgainstThisHomeThanThatOneHasNone) {
  const auto nowhere = not_found(LocalizationStatus::kNothingSimilar);
  const double of_one = place(nowhere).log_likelihood_ratio;
  const double of_two = pair(nowhere, nowhere).log_likelihood_ratio;
  EXPECT_LT(of_two, of_one);
  EXPECT_GT(of_two, 2 * of_one) << "they are of one place";
  EXPECT_EQ(pair(nowhere, nowhere, /*has_depth=*/false).log_likelihood_ratio, 0);
}

TEST(LocalizationEvidence, IsAskedOnlyWhereItMayChangeTheAnswer) {
  EXPECT_TRUE(place_may_tell(evidence(0.1, 0.5, 0.4, 8), test_model())) << "two rooms are open";
  EXPECT_TRUE(place_may_tell(evidence(0, 1, 0, 1), test_model())) << "not known well enough";
  EXPECT_TRUE(place_may_tell(evidence(0, 1, 0, 4), test_model())) << "it might be elsewhere";
  const PictureEvidence sure = evidence(0, 0.95, 0.05, 8);
  EXPECT_FALSE(place_may_tell(sure, test_model()));
  EXPECT_EQ(decide_at(sure, place(not_found(LocalizationStatus::kNoMotion))).room(), "hall");
}

TEST(LocalizationEvidence, WorksOnAWalk) {
  RoomStream walk(RoomTopology(kRooms, kWalk), test_model());
  const PictureEvidence strange = evidence(0.2, 0.4, 0.4, -4);
  RoomDecision decision;
  for (int i = 0; i < 3; ++i) {
    decision = walk.update(with_place(strange, place(found_at(7.5)), test_model()), 1);
  }
  EXPECT_EQ(decision.room(), "kitchen");
  for (int i = 0; i < 8; ++i) {
    decision = walk.update(
        with_place(strange, place(not_found(LocalizationStatus::kNothingSimilar)), test_model()),
        1);
  }
  EXPECT_EQ(decision.verdict, Verdict::kNoneOfThem);
}

}  // namespace
}  // namespace roomwise::rooms
