#include "roomwise/rooms/recognition/room_classifier.h"

#include <gmock/gmock.h>

#include <limits>

#include "roomwise/base/testing/testing.h"

namespace roomwise::rooms {
namespace {

using ::testing::HasSubstr;

// Three pictures of each room, two variants of each.
RoomClassifier two_rooms() {
  Eigen::MatrixXf rows(12, 3);
  std::vector<int> room;
  std::vector<int> picture;
  for (int i = 0; i < 12; ++i) {
    const auto step = static_cast<float>(i);
    rows.row(i) =
        root_features(i < 6 ? std::vector{9.0F, 1.0F, step} : std::vector{1.0F, 9.0F, step});
    room.push_back(i / 6);
    picture.push_back(i / 2);
  }
  Eigen::MatrixXf weights(2, 3);
  weights << 4, 0, 0.5F, 0, 4, -0.25F;
  return RoomClassifier({"net", "abc123"}, {"bath", "kitchen"},
                        SoftmaxRegression(weights, Eigen::Vector2f(0.5F, -0.5F)),
                        RoomRetrieval{RoomGallery(rows, room, picture, 2), RoomCalibration{}});
}

TEST(RoomClassifier, NamesTheBestRoomFirst) {
  const auto scores = two_rooms().scores(std::vector<float>{0, 1, 0});
  ASSERT_OK(scores);
  ASSERT_EQ(scores->size(), 2u);
  EXPECT_EQ((*scores)[0].room, "kitchen");
  EXPECT_NEAR((*scores)[0].score, 1 / (1 + std::exp(-3.0)), 1e-6);
  EXPECT_NEAR((*scores)[0].score + (*scores)[1].score, 1, 1e-6);
}

TEST(RoomClassifier, TheLengthOfTheFeaturesDoesNotCount) {
  const RoomClassifier classifier = two_rooms();
  const auto near = classifier.scores(std::vector<float>{0.25F, 0.5F, 0.125F});
  const auto far = classifier.scores(std::vector<float>{2, 4, 1});
  ASSERT_OK(near);
  EXPECT_EQ(*near, *far);
  EXPECT_OK(classifier.scores(std::vector<float>{0, 0, 0}));
}

TEST(RoomClassifier, RefusesFeaturesOfAnotherNetwork) {
  const RoomClassifier classifier = two_rooms();
  EXPECT_ERROR(classifier.scores(std::vector<float>{1, 2}),
               "2 features, but the rooms were learned on 3 of the network net");
  EXPECT_ERROR(classifier.scores(std::vector<float>{1, 2, std::numeric_limits<float>::infinity()}),
               "not finite");
}

TEST(RoomClassifier, IsKnownByMorePicturesWithoutBeingCalibratedAnew) {
  const RoomClassifier classifier = two_rooms();
  const std::vector<float> picture{3, 4, 40};
  const std::vector<RoomPicture> more(RoomGallery::kNeighbours, RoomPicture{picture, "kitchen"});
  const auto knowing = classifier.with(more);
  ASSERT_OK(knowing);
  EXPECT_GT(knowing->evidence(picture)->familiarity, classifier.evidence(picture)->familiarity);
  EXPECT_GT(knowing->evidence(picture)->probabilities[1],
            classifier.evidence(picture)->probabilities[1]);
  EXPECT_EQ(knowing->retrieval().calibration, classifier.retrieval().calibration);
  EXPECT_EQ(*knowing->scores(picture), *classifier.scores(picture)) << "the paper's way";
  EXPECT_ERROR(classifier.with(std::vector<RoomPicture>{{picture, "cellar"}}), "\"cellar\"");
  EXPECT_ERROR(classifier.with(std::vector<RoomPicture>{{{1, 2}, "bath"}}), "2 features");
}

TEST(RoomClassifier, ComesBackFromItsBytes) {
  const RoomClassifier classifier = two_rooms();
  const auto back = RoomClassifier::from_bytes(classifier.to_bytes());
  ASSERT_OK(back);
  EXPECT_EQ(back->network(), classifier.network());
  EXPECT_EQ(back->rooms(), classifier.rooms());
  EXPECT_EQ(back->regression().weights(), classifier.regression().weights());
  EXPECT_EQ(back->regression().biases(), classifier.regression().biases());
}

TEST(RoomClassifier, SaysTheSameOfAPictureAfterItWasStored) {
  const RoomClassifier classifier = two_rooms();
  const auto back = RoomClassifier::from_bytes(classifier.to_bytes());
  ASSERT_OK(back);
  const std::vector<float> picture{0.8F, 0.2F, 0.3F};
  const auto before = classifier.evidence(picture);
  const auto after = back->evidence(picture);
  ASSERT_OK(before);
  ASSERT_OK(after);
  EXPECT_GT(before->probabilities[0], 0.6);
  EXPECT_EQ(before->probabilities, after->probabilities);
  EXPECT_EQ(before->familiarity, after->familiarity);
  EXPECT_EQ(back->retrieval().calibration, classifier.retrieval().calibration);
}

TEST(RoomClassifier, RefusesDamagedBytes) {
  const Bytes whole = two_rooms().to_bytes();
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_FALSE(RoomClassifier::from_bytes(std::span(whole).first(size)).has_value()) << size;
  }
  Bytes longer = whole;
  longer.push_back(0);
  EXPECT_ERROR(RoomClassifier::from_bytes(longer), "something follows its end");
  Bytes other = whole;
  other[0] = 'X';
  EXPECT_ERROR(RoomClassifier::from_bytes(other), "does not begin with RWRC");
  Bytes newer = whole;
  EXPECT_EQ(newer[4], 2);
  newer[4] = 3;
  EXPECT_ERROR(RoomClassifier::from_bytes(newer),
               "has version 3, this program reads 2; learn the rooms again");
  Bytes infinite = whole;
  // The first weight, after the names of the network and of a room, and its bias.
  const std::size_t weight = 4 + 4 + (4 + 3) + (4 + 6) + 4 + 4 + (4 + 4) + 4;
  for (std::size_t i = weight; i < weight + 4; ++i) infinite[i] = 0xff;
  EXPECT_ERROR(RoomClassifier::from_bytes(infinite), "not finite");
  Bytes unbounded = whole;  // it ends with the calibration's last number
  for (std::size_t i = whole.size() - 8; i < whole.size(); ++i) unbounded[i] = 0xff;
  EXPECT_ERROR(RoomClassifier::from_bytes(unbounded), "plain_cosine_deviation");
}

TEST(RoomClassifier, SurvivesEveryFlippedByte) {
  const Bytes whole = two_rooms().to_bytes();
  EXPECT_EQ(RoomClassifier::from_bytes(whole)->to_bytes(), whole);
  for (std::size_t i = 0; i < whole.size(); ++i) {
    Bytes flipped = whole;
    flipped[i] ^= 0xff;
    if (const auto read = RoomClassifier::from_bytes(flipped)) {
      EXPECT_EQ(read->to_bytes(), flipped) << "byte " << i;
    }
  }
}

TEST(RoomClassifier, NeedsOneClassARoom) {
  const RoomClassifier rooms = two_rooms();
  EXPECT_THROW(RoomClassifier({}, {"bath"}, rooms.regression(), rooms.retrieval()),
               std::invalid_argument);
}

}  // namespace
}  // namespace roomwise::rooms
