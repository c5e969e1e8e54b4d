#include "roomwise/pipeline/rooms/room_baselines.h"

#include <gtest/gtest.h>

#include <numeric>

namespace roomwise::pipeline {
namespace {

double in_common(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::min(a[i], b[i]);
  return sum;
}

TEST(ColorHistogram, CountsSharesOfThePicture) {
  image::ColorImage picture(4, 4, {250, 10, 10});
  const auto red = color_histogram(picture);
  EXPECT_EQ(std::ranges::count(red, 1.0F), 1) << "one colour, one cell";
  for (int x = 0; x < 4; ++x) picture.at(x, 0) = {10, 10, 250};
  const auto quarter_blue = color_histogram(picture);
  EXPECT_NEAR(std::accumulate(quarter_blue.begin(), quarter_blue.end(), 0.0), 1, 1e-6);
  EXPECT_NEAR(in_common(red, quarter_blue), 0.75, 1e-6);
}

TEST(ColorHistogram, TellsHueFromLight) {
  const auto green = color_histogram(image::ColorImage(2, 2, {20, 240, 20}));
  const auto blue = color_histogram(image::ColorImage(2, 2, {20, 20, 240}));
  const auto dark_green = color_histogram(image::ColorImage(2, 2, {5, 60, 5}));
  EXPECT_EQ(in_common(green, blue), 0);
  EXPECT_EQ(in_common(green, dark_green), 0) << "value is counted, too";
  EXPECT_EQ(in_common(green, color_histogram(image::ColorImage(2, 2, {22, 238, 21}))), 1);
}

}  // namespace
}  // namespace roomwise::pipeline
