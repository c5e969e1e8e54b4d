#include "roomwise/pipeline/objects/own_things.h"

#include <gtest/gtest.h>

#include <array>

#include "roomwise/base/testing/testing.h"

namespace roomwise::pipeline {
namespace {

class OwnThingsNoted : public ::testing::Test {
 protected:
  std::size_t noted(const home::OwnThingSighting& seen) {
    return note_own_things(home_, {{mug_, seen}}).value();
  }
  home::OwnThingSighting last_seen() { return home_.own_things()->at(0).last_seen; }

  roomwise::testing::ScratchFolder folder_;
  home::Home home_ = home::Home::create(folder_ / "a.home").value();
  home::OwnThingId mug_ =
      home_.add_own_thing({.name = "my mug", .owner = "7"}, std::array{objects::TaughtView{}})
          .value();
};

TEST_F(OwnThingsNoted, AWalkThatIsLookedThroughAgainTellsNothingNew) {
  const home::OwnThingSighting undated{std::nullopt, "hall", {}, {}};
  const home::OwnThingSighting dated{1'753'000'000, "kitchen", {}, {}};
  for (const home::OwnThingSighting& seen : {undated, dated}) {
    EXPECT_EQ(noted(seen), 1U);
    EXPECT_EQ(noted(seen), 0U);
    EXPECT_EQ(last_seen(), seen);
  }
}

TEST_F(OwnThingsNoted, WhatTheSameWalkShowsElsewhereNowIsNoted) {
  EXPECT_EQ(noted({1'753'000'000, "kitchen", {}, {}}), 1U);
  EXPECT_EQ(noted({1'753'000'000, "hall", {}, {}}), 1U);
  EXPECT_EQ(last_seen().room, "hall");
}

TEST_F(OwnThingsNoted, AnEarlierWalkChangesNothing) {
  EXPECT_EQ(noted({1'753'000'000, "kitchen", {}, {}}), 1U);
  EXPECT_EQ(noted({1'752'000'000, "hall", {}, {}}), 0U);
  EXPECT_EQ(last_seen().room, "kitchen");
}

}  // namespace
}  // namespace roomwise::pipeline
