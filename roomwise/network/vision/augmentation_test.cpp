#include "roomwise/network/vision/augmentation.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "roomwise/base/testing/testing.h"
#include "roomwise/image/resample.h"
#include "roomwise/network/vision/picture_light.h"

namespace roomwise::network {
namespace {

using image::ColorImage;

ColorImage random_image(int width, int height) {
  RandomStream random(5);
  ColorImage image(width, height);
  for (Rgb8& pixel : image.pixels()) {
    const std::uint64_t bits = random.next();
    pixel = {static_cast<std::uint8_t>(bits), static_cast<std::uint8_t>(bits >> 8),
             static_cast<std::uint8_t>(bits >> 16)};
  }
  return image;
}

// The definition of sRGB, written here once more.
double linear(std::uint8_t byte) {
  const double s = byte / 255.0;
  return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

TEST(Augmentation, NoneGivesTheSamePicture) {
  const ColorImage image = random_image(40, 30);
  EXPECT_EQ(vary(image, {}), image);
  RandomStream random(1);
  EXPECT_EQ(augment(image, kNoAugmentation, random), image);
  EXPECT_TRUE(vary(ColorImage(), {}).empty());
}

TEST(Augmentation, TheWayThroughLinearLightKeepsEveryByte) {
  ColorImage ramp(256, 1);
  for (int i = 0; i < 256; ++i) {
    const auto byte = static_cast<std::uint8_t>(i);
    ramp.at(i, 0) = {byte, byte, byte};
  }
  PictureVariation hardly;
  hardly.exposure_stops = 1e-9;
  EXPECT_EQ(vary(ramp, hardly), ramp);
}

TEST(Augmentation, OneStopDoublesLinearValues) {
  PictureVariation brighter;
  brighter.exposure_stops = 1;
  for (int i = 0; i <= 187; ++i) {  // sRGB 188 is half of white's light
    const auto byte = static_cast<std::uint8_t>(i);
    const std::uint8_t doubled = vary(ColorImage(1, 1, {byte, byte, byte}), brighter).at(0, 0).g;
    // Within half a step of a byte, and the table's.
    const double below = doubled == 0 ? 0 : (linear(doubled) + linear(doubled - 1)) / 2;
    const double above = doubled == 255 ? 1 : (linear(doubled) + linear(doubled + 1)) / 2;
    EXPECT_GE(2 * linear(byte), below - 1e-5) << i;
    EXPECT_LE(2 * linear(byte), above + 1e-5) << i;
  }
  EXPECT_EQ(vary(ColorImage(1, 1, {200, 200, 200}), brighter).at(0, 0), (Rgb8{255, 255, 255}));
}

TEST(Augmentation, WarmLampsAreRedAndOfTheSameLuminance) {
  for (const double mired : {-kMaxLampMired, -50.0, 0.0, 50.0, kMaxLampMired}) {
    const auto color = light_color(mired, 0);
    EXPECT_NEAR(0.2126 * color[0] + 0.7152 * color[1] + 0.0722 * color[2], 1, 1e-12);
    EXPECT_EQ(color[0] > 1, mired > 0) << mired;
    EXPECT_EQ(color[2]<1, mired> 0) << mired;
  }
  EXPECT_THAT(light_color(0, 0), ::testing::Each(::testing::DoubleNear(1, 1e-12)));
  EXPECT_GT(light_color(0, 0.5)[1], light_color(0, 0.5)[0] * 1.4);
  // Planck's law integrated over CIE's 1931 observer puts 4000 K at x = 0.3805, y = 0.3768; the
  // fit is taken where it is steepest here. Against 6504 K at x = 0.3135, y = 0.3236.
  const auto at = light_color(1e6 / 4000 - 1e6 / 6504, 0);
  const auto rgb = [](double x, double y) {
    const double X = x / y;
    const double Z = (1 - x - y) / y;
    return std::array{3.2406 * X - 1.5372 - 0.4986 * Z, -0.9689 * X + 1.8758 + 0.0415 * Z,
                      0.0557 * X - 0.2040 + 1.0570 * Z};
  };
  const auto warm = rgb(0.3805, 0.3768);
  const auto white = rgb(0.3135, 0.3236);
  EXPECT_NEAR(at[0] / at[1], warm[0] / warm[1] / (white[0] / white[1]), 0.02);
  EXPECT_NEAR(at[2] / at[1], warm[2] / warm[1] / (white[2] / white[1]), 0.02);
}

TEST(Augmentation, BlurSpreadsLightAndKeepsItsSum) {
  ColorImage point(41, 41);
  point.at(20, 20) = {255, 255, 255};
  PictureVariation blurred;
  blurred.blur = 2.0 / 41;  // 2 pixels
  const ColorImage spread = vary(point, blurred);
  double sum = 0;
  double variance = 0;
  for (int y = 0; y < 41; ++y) {
    for (int x = 0; x < 41; ++x) {
      sum += linear(spread.at(x, y).r);
      variance += (x - 20) * (x - 20) * linear(spread.at(x, y).r);
    }
  }
  EXPECT_NEAR(sum, 1, 0.05);  // of bytes
  EXPECT_NEAR(std::sqrt(variance / sum), 2, 0.1);
  EXPECT_EQ(spread.at(18, 20), spread.at(20, 22));
  const ColorImage even(17, 9, {10, 100, 200});
  EXPECT_EQ(vary(even, blurred), even);  // edges, too
}

TEST(Augmentation, NoiseHasTheStandardDeviationThatItSays) {
  // In the middle of the scale, where nothing is cut off.
  const ColorImage grey(200, 200, {137, 137, 137});
  PictureVariation noisy;
  noisy.noise = 0.05;
  noisy.noise_seed = 3;
  double sum = 0;
  double squares = 0;
  const ColorImage image = vary(grey, noisy);
  for (const Rgb8 pixel : image.pixels()) {
    const double error = linear(pixel.b) - linear(137);
    sum += error;
    squares += error * error;
  }
  EXPECT_NEAR(sum / 40'000, 0, 1e-3);
  EXPECT_NEAR(std::sqrt(squares / 40'000), 0.05 * std::sqrt(linear(137) + 0.01), 3e-4);
  PictureVariation other = noisy;
  other.noise_seed = 4;
  EXPECT_NE(vary(grey, other), image);
}

TEST(Augmentation, GammaActsOnSrgbValues) {
  PictureVariation darker;
  darker.gamma_stops = 1;  // squared
  EXPECT_EQ(vary(ColorImage(1, 1, {128, 0, 255}), darker).at(0, 0), (Rgb8{64, 0, 255}));
}

TEST(Augmentation, APartIsCutOutByWholePixels) {
  const ColorImage image = random_image(40, 30);
  PictureVariation part;
  part.side = 0.5;
  part.place_x = 1;
  part.place_y = 0.4;
  EXPECT_EQ(vary(image, part), image::crop(image, 20, 6, 20, 15));
  part.mirrored = true;
  EXPECT_EQ(vary(image, part), image::mirror(image::crop(image, 20, 6, 20, 15)));
}

TEST(Augmentation, RollTurnsThePictureAboutItsMiddle) {
  // A smooth picture of which every place is known: red rises to the right, green downwards.
  ColorImage image(101, 101);
  for (int y = 0; y < 101; ++y) {
    for (int x = 0; x < 101; ++x) {
      image.at(x, y) = {static_cast<std::uint8_t>(2 * x), static_cast<std::uint8_t>(2 * y), 0};
    }
  }
  PictureVariation quarter;
  quarter.roll_deg = 90;
  const ColorImage turned = vary(image, quarter);
  ASSERT_EQ(turned.width(), 101);
  EXPECT_EQ(turned.at(50, 50), image.at(50, 50));
  EXPECT_NEAR(turned.at(100, 50).r, image.at(50, 100).r, 1);
  EXPECT_NEAR(turned.at(100, 50).g, image.at(50, 100).g, 1);

  PictureVariation slanted;
  slanted.roll_deg = 10;
  const ColorImage smaller = vary(image, slanted);
  // The largest square within a square turned by 10 degrees.
  EXPECT_NEAR(smaller.width(), 101 / (std::cos(M_PI / 18) + std::sin(M_PI / 18)), 2);
  EXPECT_EQ(smaller.at(smaller.width() / 2, smaller.height() / 2), image.at(50, 50));
}

TEST(Augmentation, PanMakesOneSideSmaller) {
  // Stripes along y: what is nearer shows fewer of them in as many pixels.
  ColorImage image(200, 200);
  for (int y = 0; y < 200; ++y) {
    for (int x = 0; x < 200; ++x) image.at(x, y).r = static_cast<std::uint8_t>(y);
  }
  PictureVariation panned;
  panned.pan_deg = 20;
  const ColorImage seen = vary(image, panned);
  const auto height_seen = [&](int x) { return seen.at(x, seen.height() - 1).r - seen.at(x, 0).r; };
  EXPECT_LT(height_seen(seen.width() - 1) * 1.2, height_seen(0));
  EXPECT_NEAR(seen.at(seen.width() / 2, seen.height() / 2).r, 100, 1);
}

TEST(Augmentation, SmallPicturesCanBeVariedToo) {
  RandomStream random(2);
  for (const auto& [width, height] : {std::pair{1, 1}, {1, 9}, {9, 1}, {2, 2}}) {
    const ColorImage image(width, height, {50, 60, 70});
    for (int i = 0; i < 20; ++i) EXPECT_FALSE(augment(image, {}, random).empty());
  }
}

TEST(Augmentation, TheSameStreamGivesTheSameBits) {
  const ColorImage image = random_image(64, 48);
  RandomStream first(1, {7, 2});
  RandomStream second(1, {7, 2});
  RandomStream third(1, {7, 3});
  const ColorImage varied = augment(image, {}, first);
  EXPECT_EQ(varied, augment(image, {}, second));
  EXPECT_NE(varied, augment(image, {}, third));
  EXPECT_NE(varied, image);
}

TEST(Augmentation, OneOptionDoesNotShiftWhatOthersDraw) {
  AugmentationOptions without;
  without.roll_deg = 0;
  without.noise = 0;
  RandomStream first(4);
  RandomStream second(4);
  PictureVariation all = sample_variation({}, first);
  const PictureVariation fewer = sample_variation(without, second);
  all.roll_deg = 0;
  all.noise = 0;
  EXPECT_EQ(all, fewer);
}

TEST(Augmentation, DrawsWithinItsOptions) {
  AugmentationOptions options;
  options.mirror = true;
  RandomStream random(8);
  int mirrored = 0;
  double warmest = 0;
  for (int i = 0; i < 1000; ++i) {
    const PictureVariation variation = sample_variation(options, random);
    EXPECT_LE(std::abs(variation.lamp_mired), options.lamp_mired);
    EXPECT_GT(variation.side, options.min_side);
    EXPECT_LE(variation.side, 1);
    warmest = std::max(warmest, variation.lamp_mired);
    mirrored += variation.mirrored ? 1 : 0;
  }
  EXPECT_GT(warmest, 0.95 * options.lamp_mired);
  EXPECT_NEAR(mirrored, 500, 60);
}

TEST(Augmentation, TheKeyTellsOptionsApart) {
  AugmentationOptions options;
  EXPECT_EQ(options.key(), AugmentationOptions{}.key());
  options.mirror = true;
  EXPECT_NE(options.key(), AugmentationOptions{}.key());
  EXPECT_NE(kNoAugmentation.key(), AugmentationOptions{}.key());
}

TEST(Augmentation, RefusesWhatAPictureDoesNotBear) {
  EXPECT_OK(AugmentationOptions{}.validate());
  EXPECT_OK(kNoAugmentation.validate());
  AugmentationOptions options;
  options.lamp_mired = 101;
  EXPECT_ERROR(options.validate(), "lamp_mired is 101; expected 0 to 100");
  options = {};
  options.min_side = 0;
  EXPECT_ERROR(options.validate(), "min_side");
  options = {};
  options.noise = std::numeric_limits<double>::quiet_NaN();
  EXPECT_ERROR(options.validate(), "noise");
}

}  // namespace
}  // namespace roomwise::network
