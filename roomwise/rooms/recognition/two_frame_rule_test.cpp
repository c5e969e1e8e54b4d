#include "roomwise/rooms/recognition/two_frame_rule.h"

#include <gmock/gmock.h>

#include "roomwise/base/testing/testing.h"

namespace roomwise::rooms {
namespace {

using objects::ObjectScore;

class TwoFrameRuleTest : public ::testing::Test {
 protected:
  RoomAnswer decide(const RoomScore& first, const RoomScore& second,
                    std::vector<ObjectScore> objects_of_second = {}) {
    const auto look = [&] {
      ++looks_;
      return objects_of_second;
    };
    return rooms::decide(first, second, look, concepts_, rooms_);
  }

  Concepts concepts_ = Concepts::standard();
  std::vector<Room> rooms_ = {
      {"Anna's room", "bedroom"}, {"kitchen", "kitchen"}, {"bath", "toilet"}};
  int looks_ = 0;
};

TEST_F(TwoFrameRuleTest, SameRoomIsTheAnswerWithoutLookingForObjects) {
  const auto answer = decide({"kitchen", 0.6}, {"kitchen", 0.9}, {{"bed", 0.9}});
  EXPECT_EQ(answer.room, "kitchen");
  EXPECT_DOUBLE_EQ(answer.score, 0.9);
  EXPECT_EQ(answer.reason, Reason::kFramesAgree);
  EXPECT_EQ(answer.object, "");
  EXPECT_EQ(looks_, 0);
}

TEST_F(TwoFrameRuleTest, ARepresentativeObjectDecidesOverAnyScore) {
  const auto answer = decide({"kitchen", 0.99}, {"bath", 0.9}, {{"bed", 0.1}});
  EXPECT_EQ(answer.room, "Anna's room");
  EXPECT_EQ(answer.reason, Reason::kRepresentativeObject);
  EXPECT_EQ(answer.object, "bed");
  EXPECT_DOUBLE_EQ(answer.score, 0.1);
  EXPECT_EQ(looks_, 1);
}

TEST_F(TwoFrameRuleTest, TheBestRepresentativeObjectDecides) {
  const auto answer = decide({"kitchen", 0.9}, {"bath", 0.8}, {{"toilet seat", 0.5}, {"bed", 0.4}});
  EXPECT_EQ(answer.room, "bath");
  EXPECT_EQ(answer.object, "toilet seat");
}

TEST_F(TwoFrameRuleTest, AnObjectOfTwoRoomTypesRepresentsNone) {
  concepts_.objects_of_room_type["kitchen"].insert("lamp");
  const auto alone = decide({"kitchen", 0.9}, {"bath", 0.8}, {{"lamp", 0.5}});
  EXPECT_EQ(alone.room, "kitchen");
  EXPECT_EQ(alone.reason, Reason::kHigherScore);
  const auto next = decide({"kitchen", 0.9}, {"bath", 0.8}, {{"lamp", 0.5}, {"bed", 0.1}});
  EXPECT_EQ(next.room, "Anna's room") << "the next object is looked at";
}

TEST_F(TwoFrameRuleTest, AnObjectOfNoRoomTypeRepresentsNone) {
  EXPECT_EQ(decide({"kitchen", 0.9}, {"bath", 0.8}, {{"banana", 0.9}}).reason,
            Reason::kHigherScore);
}

TEST_F(TwoFrameRuleTest, ATypeWithTwoRoomsInTheHomeDoesNotDecide) {
  rooms_.push_back({"Ben's room", "bedroom"});
  const auto alone = decide({"Anna's room", 0.6}, {"Ben's room", 0.7}, {{"bed", 0.9}});
  EXPECT_EQ(alone.room, "Ben's room");
  EXPECT_EQ(alone.reason, Reason::kHigherScore);
  const auto next = decide({"kitchen", 0.6}, {"Ben's room", 0.7}, {{"bed", 0.9}, {"stove", 0.1}});
  EXPECT_EQ(next.room, "kitchen") << "the next object is looked at";
  EXPECT_EQ(next.object, "stove");
}

TEST_F(TwoFrameRuleTest, ATypeWithoutARoomInTheHomeDoesNotDecide) {
  rooms_ = {{"kitchen", "kitchen"}, {"hall", "hall"}};
  EXPECT_EQ(decide({"kitchen", 0.6}, {"hall", 0.7}, {{"bed", 0.9}}).reason, Reason::kHigherScore);
}

TEST_F(TwoFrameRuleTest, WithoutAnObjectTheSurerPictureDecides) {
  const auto first = decide({"kitchen", 0.9}, {"bath", 0.8});
  EXPECT_EQ(first.room, "kitchen");
  EXPECT_DOUBLE_EQ(first.score, 0.9);
  EXPECT_EQ(first.reason, Reason::kHigherScore);
  EXPECT_EQ(decide({"kitchen", 0.7}, {"bath", 0.8}).room, "bath");
  EXPECT_EQ(decide({"kitchen", 0.8}, {"bath", 0.8}).room, "bath") << "equal: the second picture's";
}

TEST(Concepts, AnObjectRepresentsTheOnlyTypeThatHasIt) {
  Concepts concepts = Concepts::standard();
  EXPECT_EQ(concepts.represented_room_type("microwave"), "kitchen");
  EXPECT_EQ(concepts.represented_room_type("toilet seat"), "toilet");
  EXPECT_EQ(concepts.represented_room_type("banana"), std::nullopt);
  concepts.objects_of_room_type["living room"] = {"lamp"};
  EXPECT_EQ(concepts.represented_room_type("lamp"), std::nullopt);
}

TEST(Concepts, StandardRelationsUseObjectsOfTheVocabulary) {
  const Concepts concepts = Concepts::standard();
  for (const auto& [type, objects] : concepts.objects_of_room_type) {
    for (const std::string& object : objects) {
      EXPECT_TRUE(concepts.vocabulary.objects().contains(object)) << type << " has-a " << object;
    }
  }
}

TEST(Reason, HasWordsForPeople) {
  EXPECT_EQ(to_string(Reason::kSingleFrame), "single frame");
  EXPECT_EQ(to_string(Reason::kFramesAgree), "frames agree");
  EXPECT_EQ(to_string(Reason::kRepresentativeObject), "representative object");
  EXPECT_EQ(to_string(Reason::kHigherScore), "higher score");
}

}  // namespace
}  // namespace roomwise::rooms
