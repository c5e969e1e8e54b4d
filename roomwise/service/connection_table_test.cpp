#include "roomwise/service/connection_table.h"

#include <gtest/gtest.h>

namespace roomwise::service {
namespace {

ConnectionTable table_for(std::size_t connections, std::size_t per_device) {
  return ConnectionTable({connections, /*unknown_per_peer=*/8, per_device, 2});
}

// A device with as many connections as it may have gets no more, and those in excess take nobody's
// place: they make room like connections without a token.
TEST(ConnectionTableTest, ADeviceCannotTakeAllPlaces) {
  ConnectionTable table = table_for(/*connections=*/4, /*per_device=*/2);
  for (int i = 0; i < 4; ++i) {
    ASSERT_EQ(table.ask("10.0.0.1").refused, "");
    EXPECT_EQ(table.identify(table.add("10.0.0.1"), 7), i < 2) << i;
  }
  EXPECT_EQ(table.ask("10.0.0.2").refused, "");
}

TEST(ConnectionTableTest, AnAddressGetsSoManyConnectionsWithoutATokenAndNoMore) {
  ConnectionTable table = table_for(64, 16);
  ConnectionTable::Number last = 0;
  for (int i = 0; i < 8; ++i) {
    EXPECT_EQ(table.ask("10.0.0.1").refused, "");
    last = table.add("10.0.0.1");
  }
  EXPECT_NE(table.ask("10.0.0.1").refused, "");
  EXPECT_EQ(table.ask("10.0.0.2").refused, "");
  EXPECT_TRUE(table.identify(last, 3));
  EXPECT_EQ(table.ask("10.0.0.1").refused, "");
}

}  // namespace
}  // namespace roomwise::service
