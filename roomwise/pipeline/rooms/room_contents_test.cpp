#include "roomwise/pipeline/rooms/room_contents.h"

#include <gmock/gmock.h>

#include "roomwise/home/testing/sample_home.h"

namespace roomwise::pipeline {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Key;
using ::testing::Not;

// A home of two rooms, frames 0 to 29 and 30 to 59, with a key-frame every third frame. The network
// knows a microwave and a bed, and three things that the home has no word for: the kitchen's
// pictures show the one, the other's the other.
class RoomContentsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto made = home::Home::create(folder_ / "a.home");
    ASSERT_OK(made);
    home_.emplace(*std::move(made));
    ROOMWISE_MUST(home_->add_recording(home::testing::sample_recording()));
    ROOMWISE_MUST(
        home_->add_network({"net", "c0ffee", {"microwave", "four-poster", "a", "b", "c"}, 3}));
    ROOMWISE_MUST(home_->replace_concepts(rooms::Concepts::standard()));
    for (home::KeyframeId id = 0; id < 20; ++id) {
      home::MapCommit step = home::testing::sample_commit(1, 1, id);
      const bool in_kitchen = id < 10;
      step.keyframes[0].predictions[0].second.scores = {
          in_kitchen ? 0.9F : 0.0F, in_kitchen ? 0.0F : 0.9F, 0.05F, 0.03F, 0.02F};
      ROOMWISE_MUST(home_->commit(step));
    }
    ROOMWISE_MUST(home_->replace_rooms(
        std::vector<rooms::Room>{{"Anna's room", "Anna's room"}, {"kitchen", "kitchen"}}));
    ROOMWISE_MUST(
        home_->replace_room_ranges(1, {{0, 29, "kitchen", 1}, {30, 59, "Anna's room", 1}}));
  }

  objects::Instance thing(const std::string& name, double probability, home::KeyframeId id) {
    objects::Instance thing = home::testing::sample_instance(id);
    thing.name = name;
    thing.names = {{name, 1}};
    thing.probability = probability;
    return thing;
  }

  roomwise::testing::ScratchFolder folder_;
  std::optional<home::Home> home_;
};

TEST_F(RoomContentsTest, ObjectsAreCountedInTheRoomsThatShowThem) {
  const auto objects = room_objects(*home_);
  ASSERT_OK(objects);
  EXPECT_DOUBLE_EQ(objects->weight("kitchen", "microwave"), 10.5 / 11);
  EXPECT_DOUBLE_EQ(objects->weight("Anna's room", "microwave"), 0.5 / 11);
  EXPECT_EQ(objects->represented_room("microwave"), "kitchen");
  EXPECT_EQ(objects->represented_room("bed"), "Anna's room");
}

TEST_F(RoomContentsTest, ObjectsAreCountedAsTheNetworkThatIsAskedForSeesThem) {
  // A later one has looked at all too, and takes every picture for a bed's.
  const auto newer = home_->add_network({"newer", "beef", {"four-poster", "microwave"}, 3});
  ASSERT_OK(newer);
  for (home::KeyframeId id = 0; id < 20; ++id) {
    ASSERT_OK(home_->put_prediction(id, *newer, {{0, 0, 0}, {0.9F, 0.1F}}));
  }
  EXPECT_EQ(room_objects(*home_, "c0ffee")->represented_room("microwave"), "kitchen");
  EXPECT_EQ(room_objects(*home_, "beef")->represented_room("microwave"), std::nullopt);
  EXPECT_THAT(room_objects(*home_, "beef")->shares("microwave"), IsEmpty());
  EXPECT_THAT(room_objects(*home_)->shares("microwave"), IsEmpty()) << "the newest's";
  EXPECT_THAT(room_objects(*home_, "unknown")->relations(), IsEmpty());
}

TEST_F(RoomContentsTest, WhatIsClaimedIsKeptAndCounts) {
  EXPECT_THAT(*object_claims(*home_), IsEmpty());
  const std::vector<rooms::ObjectClaim> claims = {{"bed", "kitchen", true},
                                                  {"microwave", "kitchen", false}};
  ASSERT_OK(store_object_claims(*home_, claims));
  EXPECT_EQ(*object_claims(*home_), claims);
  const auto objects = room_objects(*home_);
  ASSERT_OK(objects);
  EXPECT_EQ(objects->represented_room("bed"), "kitchen");
  EXPECT_EQ(objects->represented_room("microwave"), std::nullopt);
  ASSERT_OK(move_object_claims(*home_, "kitchen", "galley"));
  EXPECT_EQ(*object_claims(*home_), (std::vector<rooms::ObjectClaim>{
                                        {"bed", "galley", true}, {"microwave", "galley", false}}));
  ASSERT_OK(move_object_claims(*home_, "Anna's room", std::nullopt));
  EXPECT_EQ(object_claims(*home_)->size(), 2U);
  ASSERT_OK(move_object_claims(*home_, "galley", std::nullopt));
  EXPECT_THAT(*object_claims(*home_), IsEmpty());
  ASSERT_OK(home_->put_setting("object_claims", "[{]"));
  EXPECT_ERROR(object_claims(*home_), "object_claims");
}

TEST_F(RoomContentsTest, ThingsBelongToTheRoomOfTheKeyframeThatShowsThemBest) {
  ASSERT_OK(home_->replace_instances(
      std::vector<objects::Instance>{thing("microwave", 0.9, 2), thing("bed", 0.8, 15),
                                     thing("lamp", 0.5, 16), thing("lamp", 0.5, 17)}));
  const auto contents = room_contents(*home_, {});
  ASSERT_OK(contents);
  EXPECT_DOUBLE_EQ(contents->at("kitchen").at("microwave"), 0.9);
  EXPECT_DOUBLE_EQ(contents->at("Anna's room").at("lamp"), 0.75);
  EXPECT_THAT(contents->at("kitchen"), Not(Contains(Key("bed"))));
}

TEST_F(RoomContentsTest, ARoomOfUnknownTypeIsGuessedByItsThings) {
  ASSERT_OK(home_->replace_instances(
      std::vector<objects::Instance>{thing("bed", 0.95, 15), thing("wardrobe", 0.9, 16)}));
  const auto guesses = classify_room_types(*home_, {});
  ASSERT_OK(guesses);
  const rooms::TypePosterior& best = guesses->at("Anna's room").front();
  EXPECT_EQ(best.type, "bedroom");
  EXPECT_GT(best.probability, 0.75);
  EXPECT_THAT(best.because, ElementsAre("bed", "wardrobe"));
  EXPECT_EQ(guesses->at("kitchen").front().type, rooms::kOtherType) << "nothing was found there";
}

}  // namespace
}  // namespace roomwise::pipeline
