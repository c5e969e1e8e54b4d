#include "roomwise/service/server/connection_table.h"

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
    EXPECT_EQ(table.identify(table.add("10.0.0.1"), {"", 7}), i < 2) << i;
  }
  EXPECT_EQ(table.ask("10.0.0.2").refused, "");
}

class IdleConnection final : public Connection {
 public:
  void end(const std::string&) override {}
  void cut() override {}
};

// Who holds connections open and shows no token keeps nobody out who shares the address, and nobody
// who has shown one.
TEST(ConnectionTableTest, AnAddressesNewestConnectionsWithoutATokenStay) {
  ConnectionTable table = table_for(64, 16);
  std::vector<std::shared_ptr<IdleConnection>> connections;
  for (int i = 0; i < 9; ++i) {
    EXPECT_EQ(table.ask("10.0.0.1").cut, nullptr);
    const auto number = table.add("10.0.0.1");
    connections.push_back(std::make_shared<IdleConnection>());
    table.set(number, connections.back());
    if (i == 0) {
      EXPECT_TRUE(table.identify(number, {"", 3}));
    }
  }
  EXPECT_EQ(table.ask("10.0.0.2").cut, nullptr);
  const auto verdict = table.ask("10.0.0.1");
  EXPECT_EQ(verdict.refused, "");
  EXPECT_EQ(verdict.cut, connections[1]) << "the oldest without a token";
}

TEST(ConnectionTableTest, TheAddressesOfAnIpv6NetworkShareTheirPlacesButAProxyIsOne) {
  ConnectionTable table(ConnectionLimits{}, {"2001:db8:1:2::99"});
  std::vector<std::shared_ptr<IdleConnection>> connections;
  for (int i = 0; i < 8; ++i) {
    const auto number = table.add("2001:db8:1:2::" + std::to_string(i + 1));
    connections.push_back(std::make_shared<IdleConnection>());
    table.set(number, connections.back());
  }
  EXPECT_EQ(table.ask("2001:db8:1:2::99").cut, nullptr);
  EXPECT_EQ(table.ask("2001:db8:1:3::9").cut, nullptr);
  EXPECT_EQ(table.ask("2001:db8:1:2::9").cut, connections[0]);
}

TEST(ConnectionTableTest, SocketsThatWereToldToGoCountUntilTheyAreGone) {
  ConnectionTable table = table_for(/*connections=*/6, /*per_device=*/4);
  std::vector<std::shared_ptr<IdleConnection>> sockets;
  std::vector<ConnectionTable::Number> numbers;
  const auto open = [&](std::int64_t device) {
    numbers.push_back(table.add("10.0.0.1"));
    sockets.push_back(std::make_shared<IdleConnection>());
    table.set(numbers.back(), sockets.back());
    return table.identify(numbers.back(), {"", device});
  };
  for (int i = 0; i < 4; ++i) {
    ASSERT_TRUE(open(7));
    const auto gone = table.open_socket(numbers.back());
    if (i < 2) {
      EXPECT_TRUE(gone.empty());
    } else {
      ASSERT_EQ(gone.size(), 1u);
      EXPECT_EQ(gone[0], sockets[static_cast<std::size_t>(i) - 2]);
    }
  }
  EXPECT_EQ(table.sockets(), 2u);
  EXPECT_FALSE(open(7)) << "the two that do not go are its own";
  table.remove(numbers.back());
  ASSERT_TRUE(open(8));
  ASSERT_TRUE(open(8));
  EXPECT_EQ(table.ask("10.0.0.2").refused, "too many connections");
  table.remove(numbers.front());
  EXPECT_EQ(table.ask("10.0.0.2").refused, "");
  EXPECT_TRUE(open(7));
}

TEST(ConnectionTableTest, EachSocketIsKnownWithTheRoleInWhichItWasOpened) {
  ConnectionTable table(ConnectionLimits{});
  const DeviceOfHome anna{"flat-1", -1};
  for (const Role role : {Role::kHelper, Role::kDevice}) {
    const ConnectionTable::Number number = table.add("10.0.0.1");
    ASSERT_TRUE(table.identify(number, anna, role));
    EXPECT_TRUE(table.open_socket(number).empty());
  }
  EXPECT_EQ(table.roles_online("flat-1").size(), 2u);
  EXPECT_TRUE(table.roles_online("flat-1").contains({-1, Role::kHelper}));
  EXPECT_TRUE(table.roles_online("flat-2").empty());
  EXPECT_EQ(table.online("flat-1").size(), 1u);
}

}  // namespace
}  // namespace roomwise::service
