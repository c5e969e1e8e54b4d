#include "roomwise/rooms/recognition/room_filter.h"

#include <gmock/gmock.h>

#include <cmath>

#include "roomwise/base/testing/testing.h"
#include "roomwise/rooms/testing/test_rooms.h"

namespace roomwise::rooms {
namespace {

RoomFilterOptions without_correlation() {
  RoomFilterOptions options;
  options.mean_dwell_s = 20;
  options.correlation_time_s = 0;
  return options;
}

TEST(RoomFilter, TwoRoomsKeepTheKnownAnswer) {
  // Two rooms that lead to each other at the rate 1/20 a second: after t seconds one is in the
  // room where one was with probability (1 + exp(-2 t / 20)) / 2.
  RoomFilter filter(RoomTopology({"a", "b"}), without_correlation());
  filter.update(std::vector{1.0, 0.0}, 0);
  const double sure = 1 / (1 + 1e-4);  // no picture is surer
  EXPECT_NEAR(filter.belief()[0], sure, 1e-12);
  filter.predict(5);
  EXPECT_NEAR(filter.belief()[0], 0.5 + (sure - 0.5) * std::exp(-0.5), 1e-12);
  // Bayes' rule: a picture that says 1 : 3.
  const double before = filter.belief()[0];
  filter.update(std::vector{0.25, 0.75}, 0);
  EXPECT_NEAR(filter.belief()[0], 0.25 * before / (0.25 * before + 0.75 * (1 - before)), 1e-12);
}

TEST(RoomFilter, TheFrameRateDoesNotCount) {
  const RoomTopology topology(kRooms, kWalk);
  RoomFilter often(topology);
  RoomFilter once(topology);
  often.update(std::vector{0.9, 0.05, 0.05}, 0);
  once.update(std::vector{0.9, 0.05, 0.05}, 0);
  for (int i = 0; i < 10; ++i) often.predict(0.3);
  once.predict(3);
  EXPECT_TRUE(often.belief().isApprox(once.belief(), 1e-9));
  // Pictures that are alike say together what one says after as long a time, nearly: with each
  // some time passes, and their weights add up to a little less than that of ten.
  const std::vector<double> kitchen{0.1, 0.2, 0.7};
  for (int i = 0; i < 30; ++i) often.update(kitchen, 1.0 / 30);
  once.update(kitchen, 1);
  EXPECT_NEAR(often.belief()[2], once.belief()[2], 0.25);
  EXPECT_LT(often.belief()[2], 0.95) << "thirty pictures within a second are no thirty proofs";
}

TEST(RoomFilter, RoomsChangeAtDoors) {
  // From the bath a door leads to the hall alone. A picture that could be hall or kitchen is the
  // hall's; without doors it could be either.
  RoomFilter doors(RoomTopology(kRooms, kWalk), without_correlation());
  RoomFilter open(RoomTopology(kRooms), without_correlation());
  for (RoomFilter* filter : {&doors, &open}) {
    for (int i = 0; i < 3; ++i) filter->update(std::vector{0.9, 0.05, 0.05}, 1);
    filter->update(std::vector{0.0, 0.5, 0.5}, 1);
    filter->update(std::vector{0.0, 0.5, 0.5}, 1);
  }
  EXPECT_GT(doors.belief()[1], 5 * doors.belief()[2]);
  EXPECT_NEAR(open.belief()[1], open.belief()[2], 1e-9);
}

TEST(RoomFilter, OneWrongPictureDoesNotMoveIt) {
  RoomFilter filter(RoomTopology(kRooms, kWalk));
  for (int i = 0; i < 5; ++i) filter.update(std::vector{0.05, 0.9, 0.05}, 1);
  filter.update(std::vector{0.05, 0.05, 0.9}, 1);
  EXPECT_GT(filter.belief()[1], 0.5);
  for (int i = 0; i < 3; ++i) filter.update(std::vector{0.05, 0.05, 0.9}, 1);
  EXPECT_GT(filter.belief()[2], 0.5) << "but several do";
}

TEST(RoomFilter, APictureThatSaysNothingChangesNothing) {
  RoomFilter filter(RoomTopology(kRooms, kWalk));
  filter.update(std::vector{0.2, 0.3, 0.5}, 0);
  const Eigen::VectorXd before = filter.belief();
  filter.update(std::vector{0.0, 0.0, 0.0}, 0);
  EXPECT_EQ(filter.belief(), before);
  EXPECT_NEAR(before.sum(), 1, 1e-12);
}

TEST(RoomFilter, RefusesWhatMakesNoSense) {
  RoomFilterOptions options;
  options.mean_dwell_s = 0;
  EXPECT_ERROR(options.validate(), "mean_dwell_s");
  EXPECT_THROW(RoomFilter(RoomTopology(kRooms), options), std::invalid_argument);
  options = {};
  options.correlation_time_s = -1;
  EXPECT_ERROR(options.validate(), "correlation_time_s");
  RoomFilter filter{RoomTopology(kRooms)};
  EXPECT_THROW(filter.update(std::vector{1.0}, 0), std::invalid_argument);
}

}  // namespace
}  // namespace roomwise::rooms
