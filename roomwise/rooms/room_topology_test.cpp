#include "roomwise/rooms/room_topology.h"

#include <gtest/gtest.h>

#include "roomwise/rooms/test_rooms.h"

namespace roomwise::rooms {
namespace {

TEST(RoomTopology, CountsPassagesBothWays) {
  const std::vector<std::string> walk = {"hall", "bath", "hall", "kitchen", "kitchen", "hall"};
  const RoomTopology topology(kRooms, walk);
  Eigen::Matrix3d expected;
  expected << 0, 2, 0, 2, 0, 2, 0, 2, 0;
  EXPECT_EQ(topology.passages(), expected);
  const Eigen::MatrixXd destinations = topology.destinations();
  EXPECT_DOUBLE_EQ(destinations(0, 1), 0.95) << "a tenth to both other rooms alike";
  EXPECT_DOUBLE_EQ(destinations(0, 2), 0.05);
  EXPECT_DOUBLE_EQ(destinations(1, 0), 0.5);
  EXPECT_DOUBLE_EQ(destinations(1, 1), 0);
  EXPECT_TRUE(destinations.rowwise().sum().isApprox(Eigen::Vector3d::Ones()));
}

TEST(RoomTopology, RoomsThatWereNotLearnedAreWalkedThrough) {
  const std::vector<std::string> walk = {"bath", "attic", "kitchen", "attic", "kitchen"};
  const RoomTopology topology(kRooms, walk);
  EXPECT_EQ(topology.passages()(0, 2), 1);
  EXPECT_EQ(topology.passages().sum(), 2) << "back from the attic is no passage";
}

TEST(RoomTopology, WithoutAWalkEveryRoomLeadsToEveryOther) {
  const Eigen::MatrixXd destinations = RoomTopology(kRooms).destinations();
  EXPECT_DOUBLE_EQ(destinations(0, 1), 0.5);
  EXPECT_DOUBLE_EQ(destinations(2, 0), 0.5);
  EXPECT_EQ(RoomTopology({"hall"}).destinations()(0, 0), 0) << "nowhere to go";
}

}  // namespace
}  // namespace roomwise::rooms
