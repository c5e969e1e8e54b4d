#include "roomwise/image/resample.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "roomwise/base/random.h"

namespace roomwise::image {
namespace {

ColorImage random_image(int width, int height) {
  RandomStream random(9);
  ColorImage image(width, height);
  for (Rgb8& pixel : image.pixels()) {
    pixel = {static_cast<std::uint8_t>(random.index(256)),
             static_cast<std::uint8_t>(random.index(256)),
             static_cast<std::uint8_t>(random.index(256))};
  }
  return image;
}

double mean_red(const ColorImage& image) {
  double sum = 0;
  for (const Rgb8 pixel : image.pixels()) sum += pixel.r;
  return sum / static_cast<double>(image.pixels().size());
}

TEST(Resample, GreyIsTheLumaOfBt601) {
  ColorImage image(5, 1);
  image.at(0, 0) = {255, 0, 0};
  image.at(1, 0) = {0, 255, 0};
  image.at(2, 0) = {0, 0, 255};
  image.at(3, 0) = {255, 255, 255};
  image.at(4, 0) = {0, 0, 0};
  EXPECT_THAT(to_gray(image).pixels(), ::testing::ElementsAre(76, 150, 29, 255, 0));
}

TEST(Resample, KeepsAPictureOfTheSameSize) {
  const ColorImage image = random_image(31, 17);
  EXPECT_EQ(resize(image, 31, 17), image);
}

TEST(Resample, KeepsOneColourAtAnySize) {
  const Rgb8 color{255, 1, 128};
  for (const auto& [width, height] : {std::pair{1, 1}, {3, 50}, {50, 3}, {299, 299}, {7, 8}}) {
    EXPECT_EQ(resize(ColorImage(40, 30, color), width, height), ColorImage(width, height, color));
  }
  EXPECT_EQ(resize(ColorImage(1, 1, color), 4, 5), ColorImage(4, 5, color));
}

TEST(Resample, ShrinksToTheMeanOfWhatIsCovered) {
  ColorImage image(4, 2);
  for (std::uint8_t i = 0; i < 8; ++i) image.pixels()[i].r = static_cast<std::uint8_t>(i * 10);
  const ColorImage half = resize(image, 2, 1);
  EXPECT_EQ(half.at(0, 0).r, (0 + 10 + 40 + 50) / 4);
  EXPECT_EQ(half.at(1, 0).r, (20 + 30 + 60 + 70) / 4);

  // Each new pixel covers one old one and half of the middle one.
  ColorImage three(3, 1);
  three.at(0, 0).r = 30;
  three.at(1, 0).r = 90;
  const ColorImage two = resize(three, 2, 1);
  EXPECT_EQ(two.at(0, 0).r, 50);
  EXPECT_EQ(two.at(1, 0).r, 30);
}

TEST(Resample, KeepsTheMeanWhenShrinking) {
  const ColorImage image = random_image(64, 48);
  EXPECT_NEAR(mean_red(resize(image, 17, 11)), mean_red(image), 0.5);
}

TEST(Resample, GrowsByInterpolationBetweenCentres) {
  ColorImage image(2, 1);
  image.at(1, 0).r = 100;
  const ColorImage grown = resize(image, 4, 1);
  EXPECT_EQ(grown.at(0, 0).r, 0);
  EXPECT_EQ(grown.at(1, 0).r, 25);
  EXPECT_EQ(grown.at(2, 0).r, 75);
  EXPECT_EQ(grown.at(3, 0).r, 100);
}

TEST(Resample, GrowsOneWayWhileItShrinksTheOther) {
  ColorImage image(2, 2);
  image.at(0, 0).r = 100;  // column 0 has the mean 50, column 1 has 0
  const ColorImage resized = resize(image, 4, 1);
  EXPECT_EQ(resized.at(0, 0).r, 50);
  EXPECT_EQ(resized.at(1, 0).r, 38);
  EXPECT_EQ(resized.at(3, 0).r, 0);
}

TEST(Resample, CutsOutAPart) {
  const ColorImage image = random_image(9, 7);
  const ColorImage part = crop(image, 2, 3, 5, 4);
  EXPECT_EQ(part.width(), 5);
  EXPECT_EQ(part.height(), 4);
  EXPECT_EQ(part.at(0, 0), image.at(2, 3));
  EXPECT_EQ(part.at(4, 3), image.at(6, 6));
  EXPECT_EQ(crop(image, 0, 0, 9, 7), image);
  EXPECT_THROW(std::ignore = crop(image, 5, 0, 5, 1), std::invalid_argument);
  EXPECT_THROW(std::ignore = crop(image, -1, 0, 1, 1), std::invalid_argument);
}

TEST(Resample, MirrorExchangesLeftAndRight) {
  const ColorImage image = random_image(9, 7);
  EXPECT_EQ(mirror(image).at(0, 4), image.at(8, 4));
  EXPECT_EQ(mirror(mirror(image)), image);
}

}  // namespace
}  // namespace roomwise::image
