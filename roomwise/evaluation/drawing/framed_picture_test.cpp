#include "roomwise/evaluation/drawing/framed_picture.h"

#include <gtest/gtest.h>

namespace roomwise::evaluation {
namespace {

using Eigen::AlignedBox2f;
using Eigen::Vector2f;

constexpr Rgb8 kYellow{255, 220, 0}, kBlack{0, 0, 0}, kGrey{90, 90, 90};

image::ColorImage grey(int width, int height) {
  image::ColorImage picture(width, height);
  for (Rgb8& pixel : picture.pixels()) pixel = kGrey;
  return picture;
}

TEST(FramedPicture, HasAFrameAroundTheBoxAndNotOverIt) {
  const AlignedBox2f box(Vector2f(20, 10), Vector2f(40, 30));
  const image::ColorImage framed = framed_picture(grey(80, 60), box, 320);
  EXPECT_EQ(framed.width(), 80) << "never larger than it was";
  EXPECT_EQ(framed.at(20, 10), kGrey);
  EXPECT_EQ(framed.at(39, 29), kGrey);
  EXPECT_EQ(framed.at(19, 20), kBlack);
  EXPECT_EQ(framed.at(18, 20), kYellow);
  EXPECT_EQ(framed.at(42, 20), kYellow);
  EXPECT_EQ(framed.at(15, 20), kGrey);
}

TEST(FramedPicture, IsMadeSmallerWithItsBox) {
  const AlignedBox2f box(Vector2f(200, 100), Vector2f(400, 300));
  const image::ColorImage framed = framed_picture(grey(800, 600), box, 80);
  EXPECT_EQ(framed.width(), 80);
  EXPECT_EQ(framed.height(), 60);
  EXPECT_EQ(framed.at(18, 20), kYellow);
}

TEST(FramedPicture, MayHaveABoxBeyondItsRimOrNone) {
  const AlignedBox2f beyond(Vector2f(-50, -50), Vector2f(500, 500));
  EXPECT_EQ(framed_picture(grey(80, 60), beyond, 80).at(0, 0), kBlack) << "it is seen at the rim";
  EXPECT_EQ(framed_picture(grey(80, 60), beyond, 80).at(40, 30), kGrey);
  EXPECT_EQ(framed_picture(grey(80, 60), AlignedBox2f(), 80).at(40, 30), kGrey);
}

}  // namespace
}  // namespace roomwise::evaluation
