#include "laboratory/simulation/home/home_checks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "laboratory/simulation/home/home_geometry.h"

namespace roomwise::simulation {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Two rooms of 4 x 3 m side by side, a front door into the left one, a door between them.
HomeModel two_rooms() {
  HomeModel home;
  home.rooms.resize(2);
  home.rooms[0].name = "hall";
  home.rooms[0].interior = {{0, 0}, {4, 3}};
  home.rooms[1].name = "study";
  home.rooms[1].kind = RoomKind::kStudy;
  home.rooms[1].interior = {{4.12, 0}, {8, 3}};
  Door front;
  front.opening.center = {2, -0.06};
  front.open_rad = 0;
  Door between;
  between.opening.center = {4.06, 0.6};
  between.opening.along_x = false;
  between.room = 1;
  between.other_room = 0;
  between.open_rad = 1.5;
  home.doors = {front, between};
  Window window;
  window.opening = {{6, 3.06}, true, 1.2, 0.9, 2.1};
  window.room = 1;
  home.windows = {window};
  return home;
}

PlacedObject thing(const std::string& name, std::size_t room, const Eigen::Vector3d& bottom,
                   const Eigen::Vector3d& size, double yaw = 0) {
  PlacedObject object;
  object.name = object.kind = name;
  object.room = room;
  object.world_from_object = upright_pose(bottom, yaw);
  object.size_m = size;
  return object;
}

TEST(HomeChecks, FindNothingInAHomeThatIsRight) {
  HomeModel home = two_rooms();
  home.objects.push_back(thing("table", 1, {6.5, 1.8, 0}, {1, 0.8, 0.75}));
  home.objects.push_back(thing("cup", 1, {6.5, 1.8, 0.75}, {0.1, 0.1, 0.1}));
  home.objects.back().stands_on = 0;
  EXPECT_THAT(find_faults(home), IsEmpty());
}

TEST(HomeChecks, FindWhatStandsWhereItMustNot) {
  const struct {
    PlacedObject object;
    const char* fault;
  } cases[] = {
      {thing("wardrobe", 1, {7.9, 1.5, 0}, {1, 0.6, 2}), "wardrobe stands in a wall"},
      {thing("wardrobe", 1, {6, 2.6, 0}, {1, 0.6, 2}), "wardrobe stands before a window"},
      {thing("chair", 1, {5.2, 0.6, 0}, {0.4, 0.4, 0.9}), "chair stands in a door's swing"},
      {thing("chair", 0, {3.6, 0.5, 0}, {0.4, 0.4, 0.9}), "chair stands in the way of a door"},
      {thing("chair", 0, {2, 0.5, 0}, {0.4, 0.4, 0.9}), "chair stands in the way of a door"},
      {thing("chair", 0, {2, 2, 0.4}, {0.4, 0.4, 0.9}), "chair floats"},
      {thing("pole", 0, {2, 2, 0}, {0.1, 0.1, 3}), "pole goes through the ceiling"},
  };
  for (const auto& [object, fault] : cases) {
    HomeModel home = two_rooms();
    home.objects.push_back(object);
    EXPECT_THAT(find_faults(home), Contains(fault));
  }
}

TEST(HomeChecks, FindThingsInACurtain) {
  HomeModel home = two_rooms();
  home.objects.push_back(thing("chest", 1, {6.7, 2.7, 0}, {0.5, 0.5, 0.8}));
  EXPECT_THAT(find_faults(home), IsEmpty());
  home.windows[0].has_curtains = true;
  EXPECT_THAT(find_faults(home), Contains("chest stands in a curtain"));
}

TEST(HomeChecks, FindThingsInsideOneAnother) {
  HomeModel home = two_rooms();
  home.objects.push_back(thing("table", 1, {6, 1.5, 0}, {1, 0.8, 0.75}));
  // Its bounds overlap the table's, its own turned shape does not.
  home.objects.push_back(thing("chair", 1, {6.74, 2.14, 0}, {0.5, 0.5, 0.9}, 3.14159265358979 / 4));
  EXPECT_THAT(find_faults(home), IsEmpty());
  home.objects.back().world_from_object.translation.y() = 1.9;
  EXPECT_THAT(find_faults(home), Contains("table is inside chair"));
}

TEST(HomeChecks, FindThingsThatFall) {
  HomeModel home = two_rooms();
  home.objects.push_back(thing("table", 1, {6, 1.5, 0}, {1, 0.8, 0.75}));
  home.objects.push_back(thing("cup", 1, {6.48, 1.5, 0.75}, {0.1, 0.1, 0.1}));
  home.objects.back().stands_on = 0;
  EXPECT_THAT(find_faults(home), Contains("cup hangs over the edge of table"));
  home.objects.back() = thing("cup", 1, {6, 1.5, 0.9}, {0.1, 0.1, 0.1});
  home.objects.back().stands_on = 0;
  EXPECT_THAT(find_faults(home), Contains("cup floats above table"));
}

TEST(HomeChecks, FindRoomsThatCannotBeReached) {
  HomeModel home = two_rooms();
  home.doors[1].open_rad = 0;  // shut
  EXPECT_THAT(find_unreachable(home), Contains("the study cannot be reached"));
  home = two_rooms();
  home.objects.push_back(thing("wall of boxes", 0, {3, 1.5, 0}, {0.3, 3, 1}));
  EXPECT_THAT(find_unreachable(home), Contains("the study cannot be reached"));
}

TEST(HomeChecks, FindNamesThatAreTakenTwice) {
  HomeModel home = two_rooms();
  home.objects.push_back(thing("bin", 0, {0.5, 2.5, 0}, {0.3, 0.3, 0.4}));
  home.objects.push_back(thing("bin", 1, {7.5, 0.5, 0}, {0.3, 0.3, 0.4}));
  EXPECT_THAT(find_faults(home), Contains(HasSubstr("two objects are called 'bin'")));
}

}  // namespace
}  // namespace roomwise::simulation
