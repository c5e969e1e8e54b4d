#include "roomwise/recording/association.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <tuple>

#include "roomwise/base/random.h"

namespace roomwise::recording {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

// The definition, by looking at every pair.
std::vector<Association> associate_slowly(const std::vector<TimestampNs>& first,
                                          const std::vector<TimestampNs>& second,
                                          TimestampNs tolerance_ns) {
  std::vector<std::tuple<TimestampNs, std::size_t, std::size_t>> pairs;
  for (std::size_t i = 0; i < first.size(); ++i) {
    for (std::size_t j = 0; j < second.size(); ++j) {
      const TimestampNs difference_ns = std::abs(first[i] - second[j]);
      if (difference_ns < tolerance_ns) pairs.emplace_back(difference_ns, i, j);
    }
  }
  std::ranges::sort(pairs);
  std::vector<bool> first_used(first.size()), second_used(second.size());
  std::vector<Association> associations;
  for (const auto& [difference_ns, i, j] : pairs) {
    if (first_used[i] || second_used[j]) continue;
    first_used[i] = second_used[j] = true;
    associations.push_back({i, j});
  }
  std::ranges::sort(associations, {}, &Association::first);
  return associations;
}

TEST(Association, TakesTheNearestAndEachOnce) {
  const std::vector<TimestampNs> first{0, 100, 200};
  const std::vector<TimestampNs> second{5, 95, 104, 500};
  EXPECT_THAT(associate(first, second, 20), ElementsAre(Association{0, 0}, Association{1, 2}));
}

TEST(Association, LetsTheClosestPairGoFirst) {
  // 10 would like 12, but 13 is nearer to it; what is left for 10 is 2.
  const std::vector<TimestampNs> first{10, 13};
  const std::vector<TimestampNs> second{2, 12};
  EXPECT_THAT(associate(first, second, 20), ElementsAre(Association{0, 0}, Association{1, 1}));
}

TEST(Association, LeavesOutWhatIsAsFarAsTheTolerance) {
  const std::vector<TimestampNs> first{0, 100};
  const std::vector<TimestampNs> second{20, 119};
  EXPECT_THAT(associate(first, second, 20), ElementsAre(Association{1, 1}));
  EXPECT_THAT(associate(first, {}, 20), IsEmpty());
  EXPECT_THAT(associate({}, second, 20), IsEmpty());
}

TEST(Association, BreaksTiesByTheOrderOfTheLists) {
  EXPECT_THAT(associate(std::vector<TimestampNs>{10}, std::vector<TimestampNs>{5, 15}, 20),
              ElementsAre(Association{0, 0}));
  EXPECT_THAT(associate(std::vector<TimestampNs>{5, 15}, std::vector<TimestampNs>{10}, 20),
              ElementsAre(Association{0, 0}));
}

TEST(Association, AgreesWithTheDefinitionOnRandomLists) {
  RandomStream random(17);
  for (int round = 0; round < 500; ++round) {
    // Few different times, so that many differences are equal.
    const auto random_times = [&] {
      std::vector<TimestampNs> times;
      TimestampNs now = 0;
      for (std::uint64_t left = random.index(30); left > 0; --left) {
        now += 1 + static_cast<TimestampNs>(random.index(6));
        times.push_back(now);
      }
      return times;
    };
    const auto first = random_times();
    const auto second = random_times();
    const auto tolerance = static_cast<TimestampNs>(1 + random.index(20));
    ASSERT_EQ(associate(first, second, tolerance), associate_slowly(first, second, tolerance))
        << "round " << round;
  }
}

TEST(Association, TakesLongListsAndAnyTolerance) {
  // An hour at 30 frames a second; looking at every pair would take minutes.
  std::vector<TimestampNs> first, second;
  for (TimestampNs i = 0; i < 108'000; ++i) {
    first.push_back(i * 33'333'333);
    second.push_back(i * 33'333'333 + 4'000'000);
  }
  const auto associations = associate(first, second, 7'200'000'000'000);
  ASSERT_EQ(associations.size(), first.size());
  EXPECT_TRUE(std::ranges::all_of(associations, [](auto a) { return a.first == a.second; }));
}

}  // namespace
}  // namespace roomwise::recording
