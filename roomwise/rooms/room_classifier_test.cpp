#include "roomwise/rooms/room_classifier.h"

#include <gmock/gmock.h>

#include <limits>

#include "roomwise/base/testing.h"

namespace roomwise::rooms {
namespace {

using ::testing::HasSubstr;

RoomClassifier two_rooms() {
  Eigen::MatrixXf weights(2, 3);
  weights << 4, 0, 0.5F, 0, 4, -0.25F;
  return RoomClassifier({"net", "abc123"}, {"bath", "kitchen"},
                        SoftmaxRegression(weights, Eigen::Vector2f(0.5F, -0.5F)));
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

TEST(RoomClassifier, ComesBackFromItsBytes) {
  const RoomClassifier classifier = two_rooms();
  const auto back = RoomClassifier::from_bytes(classifier.to_bytes());
  ASSERT_OK(back);
  EXPECT_EQ(back->network(), classifier.network());
  EXPECT_EQ(back->rooms(), classifier.rooms());
  EXPECT_EQ(back->regression().weights(), classifier.regression().weights());
  EXPECT_EQ(back->regression().biases(), classifier.regression().biases());
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
  newer[4] = 2;
  EXPECT_ERROR(RoomClassifier::from_bytes(newer), "version 2");
  Bytes infinite = whole;
  for (std::size_t i = whole.size() - 4; i < whole.size(); ++i) infinite[i] = 0xff;
  EXPECT_ERROR(RoomClassifier::from_bytes(infinite), "not finite");
}

TEST(RoomClassifier, SurvivesEveryFlippedByte) {
  const Bytes whole = two_rooms().to_bytes();
  for (std::size_t i = 0; i < whole.size(); ++i) {
    Bytes flipped = whole;
    flipped[i] ^= 0xff;
    if (const auto read = RoomClassifier::from_bytes(flipped)) {
      EXPECT_EQ(read->to_bytes(), flipped) << "byte " << i;
    }
  }
}

TEST(RoomClassifier, NeedsOneClassARoom) {
  EXPECT_THROW(RoomClassifier({}, {"bath"}, two_rooms().regression()), std::invalid_argument);
}

}  // namespace
}  // namespace roomwise::rooms
