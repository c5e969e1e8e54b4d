#include "roomwise/objects/proposals/square_about.h"

#include <gtest/gtest.h>

namespace roomwise::objects {
namespace {

TEST(SquareAbout, LiesInThePictureAboutTheBox) {
  const auto expect = [](const network::PixelBox& square, const network::PixelBox& wanted,
                         const char* why) {
    EXPECT_FLOAT_EQ(square.left, wanted.left) << why;
    EXPECT_FLOAT_EQ(square.top, wanted.top) << why;
    EXPECT_FLOAT_EQ(square.right, wanted.right) << why;
    EXPECT_FLOAT_EQ(square.bottom, wanted.bottom) << why;
  };
  expect(square_about({90, 40, 110, 50}, 1, 200, 100), {90, 35, 110, 55}, "its longest side");
  expect(square_about({90, 40, 110, 50}, 2, 200, 100), {80, 25, 120, 65}, "twice that");
  expect(square_about({0, 0, 20, 10}, 1.5F, 200, 100), {0, 0, 30, 30}, "moved into the picture");
  expect(square_about({50, 20, 190, 90}, 1, 200, 100), {70, 0, 170, 100},
         "no larger than the picture");
}

}  // namespace
}  // namespace roomwise::objects
