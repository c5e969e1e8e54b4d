#include "roomwise/pipeline/rooms/turn_hint.h"

#include <gtest/gtest.h>

#include "roomwise/base/random.h"

namespace roomwise::pipeline {
namespace {

// Grey, with squares of random brightness from column `first` to before `last`.
image::ColorImage squares(int first, int last) {
  image::ColorImage picture(320, 240, {128, 128, 128});
  RandomStream random(1);
  for (int y = 0; y + 8 <= 240; y += 8) {
    for (int x = 0; x + 8 <= 320; x += 8) {
      const auto value = static_cast<std::uint8_t>(random.index(256));
      if (x < first || x >= last) continue;
      for (int dy = 0; dy < 8; ++dy) {
        for (int dx = 0; dx < 8; ++dx) picture.at(x + dx, y + dy) = {value, value, value};
      }
    }
  }
  return picture;
}

TEST(TurnHint, AsksToTurnToTheSideWithMoreToSee) {
  EXPECT_EQ(side_with_more_to_see(squares(0, 140)), Side::kLeft);
  EXPECT_EQ(side_with_more_to_see(squares(180, 320)), Side::kRight);
  EXPECT_EQ(turn_hint(squares(0, 140)),
            "turn a little to the left: there is more to see on that side");
  EXPECT_EQ(turn_hint(squares(180, 320)),
            "turn a little to the right: there is more to see on that side");
}

TEST(TurnHint, MakesNoSideUp) {
  EXPECT_EQ(side_with_more_to_see(squares(0, 320)), std::nullopt) << "both sides are full";
  EXPECT_EQ(side_with_more_to_see(squares(0, 0)), std::nullopt) << "a bare wall";
  EXPECT_EQ(turn_hint(squares(0, 0)), "turn slowly and take another picture");
}

}  // namespace
}  // namespace roomwise::pipeline
