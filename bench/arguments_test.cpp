#include "arguments.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <string>

#include "roomwise/base/testing/testing.h"

namespace roomwise::bench {
namespace {

TEST(Arguments, ACountIsAWholeNumberFromOneOn) {
  EXPECT_EQ(parse_count("200", "check [HOMES]").value(), 200);
  for (const char* wrong : {"abc", "", "0", "-3", "5x", "1.5", " 7", "99999999999"}) {
    EXPECT_ERROR(parse_count(wrong, "check [HOMES]"), "check [HOMES]");
  }
}

TEST(Arguments, TheOnlyCountMayBeLeftOutAndStandsAlone) {
  std::string program = "check", count = "7", more = "day";
  std::array<char*, 3> arguments{program.data(), count.data(), more.data()};
  EXPECT_EQ(only_count(1, arguments.data(), 200, "check [HOMES]").value(), 200);
  EXPECT_EQ(only_count(2, arguments.data(), 200, "check [HOMES]").value(), 7);
  EXPECT_ERROR(only_count(3, arguments.data(), 200, "check [HOMES]"), "'day'");
}

}  // namespace
}  // namespace roomwise::bench
