#include "laboratory/simulation/home/ground_truth.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "laboratory/simulation/home/home_generator.h"
#include "laboratory/simulation/home/home_geometry.h"
#include "laboratory/simulation/testing/made_up_furniture.h"
#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::simulation {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

HomeModel sample_home() {
  return *generate_home({6, {}}, testing::made_up_furniture());
}

TEST(ObservationCounter, CountsPixelsOfObjects) {
  image::Image<std::uint16_t> image(4, 2);
  image.at(0, 0) = 1;
  image.at(1, 0) = 3;
  image.at(2, 1) = 3;
  ObservationCounter counter(3);
  counter.add(7, image);
  image.at(1, 0) = 0;
  counter.add(2, image);
  EXPECT_THAT(counter.of(0),
              ElementsAre(ObjectObservation{2, 1, 0.125}, ObjectObservation{7, 1, 0.125}));
  EXPECT_THAT(counter.of(1), IsEmpty());
  EXPECT_THAT(counter.of(2),
              ElementsAre(ObjectObservation{2, 1, 0.125}, ObjectObservation{7, 2, 0.25}));
}

TEST(ObjectsTruth, IsReadBackAsWritten) {
  const HomeModel home = sample_home();
  ObservationCounter counter(home.objects.size());
  counter.add(3, image::Image<std::uint16_t>(8, 4, 2));
  const auto truth = objects_truth(home, testing::made_up_furniture(), counter);
  const testing::ScratchFolder folder;
  ASSERT_OK(write_objects_truth(folder / "objects.json", truth));
  const auto read = read_objects_truth(folder / "objects.json");
  ASSERT_OK(read);
  ASSERT_EQ(read->size(), home.objects.size());
  for (std::size_t i = 0; i < read->size(); ++i) {
    const ObjectTruth& object = (*read)[i];
    const PlacedObject& placed = home.objects[i];
    EXPECT_EQ(object.name, placed.name);
    EXPECT_EQ(object.kind, placed.kind);
    EXPECT_EQ(object.label.find('_'), std::string::npos);
    EXPECT_EQ(object.room, home.rooms[placed.room].name);
    EXPECT_EQ(object.model, placed.model);
    EXPECT_EQ(object.creator, "nobody");
    EXPECT_EQ(object.license, "CC0");
    EXPECT_EQ(object.seen, truth[i].seen);
    const Footprint footprint = footprint_of(placed);
    EXPECT_LT((object.center_m.head<2>() - footprint.center).norm(), 1e-3);
    EXPECT_NEAR(object.center_m.z(), (footprint.bottom_m + footprint.top_m) / 2, 1e-3);
    EXPECT_LT((object.size_m - placed.size_m).norm(), 1e-3);
    EXPECT_NEAR(object.yaw_rad, footprint.yaw_rad, 1e-3);
  }
  EXPECT_THAT((*read)[1].seen, ElementsAre(ObjectObservation{3, 32, 1.0}));
}

TEST(ObjectsTruth, NamesWhatIsWrongWithAFile) {
  const testing::ScratchFolder folder;
  EXPECT_ERROR(read_objects_truth(folder / "none.json"), "none.json");
  ASSERT_OK(write_file(folder / "a.json", std::string_view("{\"objects\": [{\"name\": 3}]}")));
  EXPECT_ERROR(read_objects_truth(folder / "a.json"), "a.json");
  ASSERT_OK(write_file(folder / "b.json", std::string_view("{\"objects\": [")));
  EXPECT_ERROR(read_objects_truth(folder / "b.json"), "b.json");
  ASSERT_OK(
      write_file(folder / "c.json", std::string_view("{\"objects\": [{\"name\": \"bed\"}]}")));
  EXPECT_ERROR(read_objects_truth(folder / "c.json"), "kind");
}

TEST(FloorPlanTruth, IsReadBackAsWritten) {
  const HomeModel home = sample_home();
  const testing::ScratchFolder folder;
  ASSERT_OK(write_floor_plan(folder / "floorplan.json", home));
  const auto plan = read_floor_plan(folder / "floorplan.json");
  ASSERT_OK(plan);
  ASSERT_EQ(plan->rooms.size(), home.rooms.size());
  for (std::size_t i = 0; i < home.rooms.size(); ++i) {
    EXPECT_EQ(plan->rooms[i].name, home.rooms[i].name);
    EXPECT_EQ(plan->rooms[i].kind, home.rooms[i].kind);
    EXPECT_LT((plan->rooms[i].interior.max - home.rooms[i].interior.max).norm(), 1e-3);
  }
  ASSERT_EQ(plan->doors.size(), home.doors.size());
  for (std::size_t i = 0; i < home.doors.size(); ++i) {
    EXPECT_EQ(plan->doors[i].room, home.doors[i].room);
    EXPECT_EQ(plan->doors[i].other_room, home.doors[i].other_room);
    EXPECT_EQ(plan->doors[i].has_leaf, home.doors[i].has_leaf);
  }
  EXPECT_EQ(plan->windows.size(), home.windows.size());
  EXPECT_EQ(plan->walls.size(), walls_of(home).size());
  const FreeSpaceTruth& space = plan->free_space;
  // In the middle of every open door a person has room; outside nobody is.
  for (const Door& door : home.doors) {
    if (!door.other_room) continue;
    const Eigen::Vector2d cell = (door.opening.center - space.origin_m) / space.cell_m;
    EXPECT_EQ(space.rows[static_cast<std::size_t>(cell.y())][static_cast<std::size_t>(cell.x())],
              '.');
  }
  EXPECT_EQ(space.rows[0].find('.'), std::string::npos);
}

TEST(FloorPlanTruth, NamesWhatIsWrongWithAFile) {
  const testing::ScratchFolder folder;
  ASSERT_OK(write_file(folder / "f.json", std::string_view("{\"rooms\": []}")));
  EXPECT_ERROR(read_floor_plan(folder / "f.json"), "ceiling_height");
}

TEST(Walls, SeparateRoomsAndEncloseTheHome) {
  HomeModel home;
  home.wall_thickness_m = 0.1;
  home.rooms.resize(2);
  home.rooms[0].interior = {{0.05, 0.05}, {1.95, 2.95}};
  home.rooms[1].interior = {{2.05, 0.05}, {4.95, 2.95}};
  const auto walls = walls_of(home);
  double length = 0;
  for (const WallSegment& wall : walls) length += (wall.to - wall.from).norm();
  EXPECT_EQ(walls.size(), 5);  // the outline's four and the one between
  EXPECT_NEAR(length, 2 * 5 + 3 * 3, 1e-3);
}

}  // namespace
}  // namespace roomwise::simulation
