#include "roomwise/live/device/teaching.h"

#include <gtest/gtest.h>

namespace roomwise::live {
namespace {

// A checkered thing in the middle of an even picture.
FrameImages shown(std::uint8_t light = 200) {
  FrameImages images;
  images.color = image::ColorImage(160, 120, {light, light, light});
  for (int y = 40; y < 80; ++y) {
    for (int x = 60; x < 100; ++x) {
      if ((x / 10 + y / 10) % 2 == 0) images.color.at(x, y) = {light, 0, 0};
    }
  }
  return images;
}

TEST(TeachingTest, TenPicturesAreEnoughAndHalfWayThereOneIsTold) {
  Teaching teaching;
  for (std::size_t i = 1; i <= Teaching::kEnough; ++i) {
    const Teaching::Reply reply = teaching.take(shown(), 1000, 1000.0 * static_cast<double>(i));
    EXPECT_FALSE(reply.fault);
    const bool is_half = i == Teaching::kEnough / 2, is_all = i == Teaching::kEnough;
    EXPECT_EQ(reply.step.has_value(), is_half || is_all) << i;
    EXPECT_EQ(teaching.has_enough(), is_all);
  }
  EXPECT_EQ(teaching.shown().size(), Teaching::kEnough);
  EXPECT_FALSE(teaching.take(shown(), 1000, 20'000).step);  // no more is taken
  EXPECT_EQ(teaching.shown().size(), Teaching::kEnough);
}

TEST(TeachingTest, ItEndsAMinuteAfterTheLastPictureThatWasTaken) {
  Teaching teaching;
  const auto step = [&](double t_ms, std::uint8_t light) {
    return teaching.take(shown(light), 1000, t_ms).step;
  };
  EXPECT_EQ(step(5000, 10), std::nullopt);
  EXPECT_EQ(step(60'000, 200), std::nullopt);
  EXPECT_EQ(step(120'000, 10), std::nullopt);
  EXPECT_EQ(step(120'001, 10), guide::TeachingStep::kStopped);
}

TEST(TeachingTest, WhatToDoAboutBadPicturesIsSaidAtOnceAndNotWithEach) {
  Teaching teaching;
  const auto dark = [&](double t_ms) { return teaching.take(shown(10), 1000, t_ms).fault; };
  EXPECT_EQ(dark(1000), objects::ShowFault::kDark);
  EXPECT_EQ(dark(2000), std::nullopt);
  EXPECT_EQ(dark(4000), objects::ShowFault::kDark);
  EXPECT_TRUE(teaching.shown().empty());
}

}  // namespace
}  // namespace roomwise::live
