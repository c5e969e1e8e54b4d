#include "roomwise/rooms/layout/room_topology.h"

#include <gtest/gtest.h>

#include "roomwise/rooms/testing/test_rooms.h"

namespace roomwise::rooms {
namespace {

TEST(RoomTopology, CountsPassagesBothWays) {
  const std::vector<std::string> walk = {"hall", "bath", "hall", "kitchen", "kitchen", "hall"};
  const RoomTopology topology(kRooms, walk);
  Eigen::Matrix3d expected;
  expected << 0, 2, 0, 2, 0, 2, 0, 2, 0;
  EXPECT_EQ(topology.transition_counts(), expected);
  const Eigen::MatrixXd transition_probabilities = topology.transition_probabilities();
  EXPECT_DOUBLE_EQ(transition_probabilities(0, 1), 0.95) << "a tenth to both other rooms alike";
  EXPECT_DOUBLE_EQ(transition_probabilities(0, 2), 0.05);
  EXPECT_DOUBLE_EQ(transition_probabilities(1, 0), 0.5);
  EXPECT_DOUBLE_EQ(transition_probabilities(1, 1), 0);
  EXPECT_TRUE(transition_probabilities.rowwise().sum().isApprox(Eigen::Vector3d::Ones()));
}

TEST(RoomTopology, RoomsThatWereNotLearnedAreWalkedThrough) {
  const std::vector<std::string> walk = {"bath", "attic", "kitchen", "attic", "kitchen"};
  const RoomTopology topology(kRooms, walk);
  EXPECT_EQ(topology.transition_counts()(0, 2), 1);
  EXPECT_EQ(topology.transition_counts().sum(), 2) << "back from the attic is no passage";
}

TEST(RoomTopology, WithoutAWalkEveryRoomLeadsToEveryOther) {
  const Eigen::MatrixXd transition_probabilities = RoomTopology(kRooms).transition_probabilities();
  EXPECT_DOUBLE_EQ(transition_probabilities(0, 1), 0.5);
  EXPECT_DOUBLE_EQ(transition_probabilities(2, 0), 0.5);
  EXPECT_EQ(RoomTopology({"hall"}).transition_probabilities()(0, 0), 0) << "nowhere to go";
}

}  // namespace
}  // namespace roomwise::rooms
