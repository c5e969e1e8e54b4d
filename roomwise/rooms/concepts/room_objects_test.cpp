#include "roomwise/rooms/concepts/room_objects.h"

#include <gmock/gmock.h>

namespace roomwise::rooms {
namespace {

using ::testing::Eq;
using ::testing::IsEmpty;
using ::testing::Optional;

// `count` pictures of the room, of which the first `showing` show the object.
void add(std::vector<NamedPicture>& pictures, const std::string& room, int count, int showing,
         const std::string& object) {
  for (int i = 0; i < count; ++i) {
    pictures.push_back(
        {room, i < showing ? std::set<std::string>{object} : std::set<std::string>{}});
  }
}

TEST(RoomObjectsTest, CountsWhatPicturesShowRoomByRoom) {
  std::vector<NamedPicture> pictures;
  add(pictures, "kitchen", 19, 10, "microwave");
  add(pictures, "hall", 39, 0, "");
  const RoomObjects objects(pictures);
  EXPECT_DOUBLE_EQ(objects.weight("kitchen", "microwave"), 10.5 / 20);
  EXPECT_DOUBLE_EQ(objects.weight("hall", "microwave"), 0.5 / 40);
  const auto shares = objects.shares("microwave");
  EXPECT_NEAR(shares.at("kitchen"), 0.525 / (0.525 + 0.0125), 1e-12);
  EXPECT_NEAR(shares.at("kitchen") + shares.at("hall"), 1, 1e-12);
  EXPECT_THAT(objects.represented_room("microwave"), Optional(Eq("kitchen")));
  EXPECT_THAT(objects.shares("bed"), IsEmpty());
  EXPECT_EQ(objects.represented_room("bed"), std::nullopt);
}

TEST(RoomObjectsTest, AnObjectOfTwoRoomsRepresentsNone) {
  std::vector<NamedPicture> pictures;
  add(pictures, "Anna's room", 30, 20, "bed");
  add(pictures, "Ben's room", 30, 8, "bed");
  EXPECT_EQ(RoomObjects(pictures).represented_room("bed"), std::nullopt);
}

TEST(RoomObjectsTest, FewPicturesProveNothing) {
  std::vector<NamedPicture> pictures;
  add(pictures, "kitchen", 20, 3, "stove");  // one too few
  add(pictures, "hall", 30, 0, "");
  EXPECT_EQ(RoomObjects(pictures).represented_room("stove"), std::nullopt);
  add(pictures, "kitchen", 1, 1, "stove");
  EXPECT_THAT(RoomObjects(pictures).represented_room("stove"), Optional(Eq("kitchen")));
  // A room that was hardly looked at may have one, too.
  add(pictures, "bath", 5, 0, "");
  EXPECT_EQ(RoomObjects(pictures).represented_room("stove"), std::nullopt);
}

TEST(RoomObjectsTest, WhatSomebodySaysCountsMore) {
  std::vector<NamedPicture> pictures;
  add(pictures, "kitchen", 30, 20, "plant");
  add(pictures, "hall", 30, 0, "");
  add(pictures, "bath", 30, 0, "");
  const RoomObjects moved(pictures, {{"plant", "kitchen", false}});
  EXPECT_EQ(moved.represented_room("plant"), std::nullopt);
  // Then it speaks for the kitchen no more than for the others.
  EXPECT_NEAR(moved.shares("plant").at("kitchen"), 1.0 / 3, 1e-12);
  EXPECT_NEAR(moved.shares("plant").at("hall"), 1.0 / 3, 1e-12);
  const RoomObjects said(pictures, {{"plant", "hall", true}, {"piano", "hall", true}});
  EXPECT_THAT(said.represented_room("plant"), Optional(Eq("hall")));
  EXPECT_THAT(said.represented_room("piano"), Optional(Eq("hall")));
  const auto shares = said.shares("plant");
  EXPECT_DOUBLE_EQ(shares.at("hall"), 0.98);
  EXPECT_NEAR(shares.at("kitchen") + shares.at("bath"), 0.02, 1e-12);
  EXPECT_GT(shares.at("kitchen"), shares.at("bath"));
  EXPECT_THAT(RoomObjects(pictures, {{"plant", "attic", true}}).represented_room("plant"),
              Optional(Eq("kitchen")))
      << "a room that is not there any more";
}

TEST(RoomObjectsTest, OneDenialDoesNotUndoAnother) {
  std::vector<NamedPicture> pictures;
  add(pictures, "kitchen", 30, 20, "plant");
  add(pictures, "bath", 30, 15, "plant");
  add(pictures, "hall", 30, 1, "plant");
  const ObjectClaim not_kitchen{"plant", "kitchen", false}, not_bath{"plant", "bath", false};
  const auto shares = RoomObjects(pictures, {not_kitchen, not_bath}).shares("plant");
  EXPECT_NEAR(shares.at("kitchen"), 1.0 / 3, 1e-12);
  EXPECT_NEAR(shares.at("bath"), 1.0 / 3, 1e-12);
  EXPECT_NEAR(shares.at("hall"), 1.0 / 3, 1e-12);
  EXPECT_EQ(RoomObjects(pictures, {not_bath, not_kitchen}).shares("plant"), shares);
  // What has less than an equal part gains nothing by it.
  const ObjectClaim not_hall{"plant", "hall", false};
  const auto two = RoomObjects(pictures, {not_kitchen, not_hall}).shares("plant");
  EXPECT_NEAR(two.at("kitchen"), 1.0 / 3, 1e-12);
  EXPECT_NEAR(two.at("hall"), RoomObjects(pictures).shares("plant").at("hall"), 1e-12);
  EXPECT_NEAR(two.at("bath"), 2.0 / 3 - two.at("hall"), 1e-12);
  // Where it stands in none of them, it tells nothing.
  for (const auto& [room, share] :
       RoomObjects(pictures, {not_kitchen, not_bath, not_hall}).shares("plant")) {
    EXPECT_NEAR(share, 1.0 / 3, 1e-12) << room;
  }
}

TEST(RoomObjectsTest, ARoomWithoutPicturesCanBeClaimedToo) {
  std::vector<NamedPicture> pictures;
  add(pictures, "kitchen", 30, 20, "plant");
  const std::vector<std::string> rooms = {"attic", "kitchen"};
  const RoomObjects objects(pictures, {{"piano", "attic", true}}, rooms);
  EXPECT_THAT(objects.represented_room("piano"), Optional(Eq("attic")));
  EXPECT_DOUBLE_EQ(objects.shares("piano").at("attic"), 0.98);
  EXPECT_DOUBLE_EQ(objects.shares("plant").at("kitchen"), 1) << "the attic was not looked at";
}

TEST(RoomObjectsTest, RelationsAreShownTheHeaviestFirst) {
  std::vector<NamedPicture> pictures;
  add(pictures, "hall", 20, 5, "lamp");
  add(pictures, "hall", 20, 12, "plant");
  add(pictures, "bath", 40, 0, "");
  const auto relations = RoomObjects(pictures, {{"bench", "bath", true}}).relations();
  ASSERT_EQ(relations.size(), 3U);
  EXPECT_EQ(relations[0].object, "bench");
  EXPECT_TRUE(relations[0].is_claimed);
  EXPECT_TRUE(relations[0].is_representative);
  EXPECT_EQ(relations[0].shown, 0);
  EXPECT_EQ(relations[1].object, "plant");
  EXPECT_EQ(relations[1].shown, 12);
  EXPECT_EQ(relations[1].pictures, 40);
  EXPECT_TRUE(relations[1].is_representative);
  EXPECT_FALSE(relations[1].is_claimed);
  EXPECT_EQ(relations[2].object, "lamp");
}

}  // namespace
}  // namespace roomwise::rooms
