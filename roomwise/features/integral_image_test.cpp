#include "roomwise/features/integral_image.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "roomwise/base/random.h"

namespace roomwise::features {
namespace {

std::uint32_t summed_directly(const image::GrayImage& picture, int left, int top, int right,
                              int bottom) {
  std::uint32_t sum = 0;
  for (int y = std::max(top, 0); y < std::min(bottom, picture.height()); ++y) {
    for (int x = std::max(left, 0); x < std::min(right, picture.width()); ++x) {
      sum += picture.at(x, y);
    }
  }
  return sum;
}

TEST(IntegralImage, SumsAnyBoxLikeTheDirectSum) {
  RandomStream random(1);
  const auto between = [&](int low, int high) {
    return low + static_cast<int>(random.index(static_cast<std::uint64_t>(high - low)));
  };
  for (int round = 0; round < 2000; ++round) {
    image::GrayImage picture(between(1, 40), between(1, 40));
    for (auto& pixel : picture.pixels()) pixel = static_cast<std::uint8_t>(random.index(256));
    const IntegralImage integral(picture);
    // Boxes inside, across the border, wholly outside, and upside down.
    const int left = between(-10, 50), right = between(-10, 50);
    const int top = between(-10, 50), bottom = between(-10, 50);
    ASSERT_EQ(integral.box_sum(left, top, right, bottom),
              summed_directly(picture, left, top, right, bottom))
        << picture.width() << "x" << picture.height() << ": " << left << "," << top << " to "
        << right << "," << bottom;
  }
}

TEST(IntegralImage, RowsStartAtZeroAndEndAtTheWhole) {
  const image::GrayImage picture(3, 2, 255);
  const IntegralImage integral(picture);
  EXPECT_EQ(integral.row(0)[3], 0U);
  EXPECT_EQ(integral.row(2)[0], 0U);
  EXPECT_EQ(integral.row(1)[2], 2U * 255);
  EXPECT_EQ(integral.row(2)[3], 6U * 255);
}

TEST(IntegralImage, RowByRowIsTheSame) {
  RandomStream random(2);
  for (int width = 1; width < 40; ++width) {
    image::GrayImage picture(width, 5);
    for (auto& pixel : picture.pixels()) pixel = static_cast<std::uint8_t>(random.index(256));
    const IntegralImage expected(picture);
    for (const Simd simd : {Simd::kPortable, process_simd()}) {
      IntegralImage integral;
      integral.reset(50, 9);  // what was there before does not matter
      integral.reset(width, 5);
      for (int y = 0; y < 5; ++y) {
        const std::vector<std::uint16_t> row(picture.row(y).begin(), picture.row(y).end());
        integral.set_row(y, row, simd);
      }
      for (int y = 0; y <= 5; ++y) {
        ASSERT_TRUE(std::equal(expected.row(y), expected.row(y) + width + 1, integral.row(y)));
      }
    }
  }
}

TEST(IntegralImage, AnEmptyPictureHasEmptyBoxes) {
  const IntegralImage integral{image::GrayImage()};
  EXPECT_EQ(integral.width(), 0);
  EXPECT_EQ(integral.box_sum(0, 0, 5, 5), 0U);
}

TEST(IntegralImage, StaysExactWhereTheWholeSumOverflows) {
  // 5000 x 4000 white pixels sum to more than 2^32; a box in the far corner is still right.
  const image::GrayImage picture(5000, 4000, 255);
  const IntegralImage integral(picture);
  EXPECT_EQ(integral.box_sum(4900, 3950, 5000, 4000), 100U * 50 * 255);
}

}  // namespace
}  // namespace roomwise::features
