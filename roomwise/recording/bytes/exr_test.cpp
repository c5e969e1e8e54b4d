#include "roomwise/recording/bytes/exr.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/recording/bytes/testing/exr_writer.h"

namespace roomwise::recording {
namespace {

using testing::exr_file;
using testing::ExrPlan;

constexpr std::int64_t kMaxExrPixels = 10'000;

// Metres that 16 bits hold: a slope with a step in it.
float slope(std::size_t channel, int x, int y) {
  return 0.5F + 0.125F * static_cast<float>(x) + (y < 9 ? 0.0F : 1.0F) +
         10.0F * static_cast<float>(channel);
}

ExrPlan sloping(int width, int height) {
  ExrPlan plan;
  plan.width = width;
  plan.height = height;
  plan.value = slope;
  return plan;
}

void expect_slope(const Bytes& file, int width, int height, std::size_t channel = 0) {
  const auto pixels = decode_exr(file, kMaxExrPixels);
  ASSERT_OK(pixels);
  ASSERT_EQ(pixels->width(), width);
  ASSERT_EQ(pixels->height(), height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) ASSERT_EQ(pixels->at(x, y), slope(channel, x, y)) << x << y;
  }
}

TEST(Exr, GivesBackEachKindOfNumbersAndPackings) {
  for (const bool is_half : {true, false}) {
    for (const int packing : {0, 2, 3}) {
      // Blocks that are whole, one that is not, and less than one.
      for (const int height : {32, 37, 5}) {
        ExrPlan plan = sloping(13, height);
        plan.is_half = is_half;
        plan.packing = static_cast<std::uint8_t>(packing);
        EXPECT_TRUE(is_exr(exr_file(plan)));
        expect_slope(exr_file(plan), 13, height);
      }
    }
  }
}

TEST(Exr, MayBeginAtAnyPixel) {
  ExrPlan plan = sloping(12, 20);
  plan.left = -7;
  plan.top = 100;
  expect_slope(exr_file(plan), 12, 20);
}

TEST(Exr, TakesOneOfSeveralChannels) {
  ExrPlan plan = sloping(12, 20);
  plan.channels = {"A", "B", "G", "R"};
  expect_slope(exr_file(plan), 12, 20, 3);
  plan.channels = {"confidence", "Z"};
  expect_slope(exr_file(plan), 12, 20, 1);
  plan.channels = {"depth"};
  expect_slope(exr_file(plan), 12, 20, 0);
  plan.channels = {"x", "y"};
  EXPECT_ERROR(decode_exr(exr_file(plan), kMaxExrPixels), "none is R or Z");
}

TEST(Exr, KnowsAllNumbersOfSixteenBits) {
  ExrPlan plan = sloping(6, 1);
  plan.packing = 0;
  Bytes file = exr_file(plan);
  constexpr std::array<std::uint16_t, 6> kHalves{0x0001, 0x83FF, 0x7BFF, 0x7C00, 0xFC00, 0x7E00};
  std::memcpy(file.data() + file.size() - 12, kHalves.data(), 12);
  const auto pixels = decode_exr(file, kMaxExrPixels);
  ASSERT_OK(pixels);
  EXPECT_EQ(pixels->at(0, 0), std::ldexp(1.0F, -24));
  EXPECT_EQ(pixels->at(1, 0), -std::ldexp(1023.0F, -24));
  EXPECT_EQ(pixels->at(2, 0), 65504.0F);
  EXPECT_EQ(pixels->at(3, 0), std::numeric_limits<float>::infinity());
  EXPECT_EQ(pixels->at(4, 0), -std::numeric_limits<float>::infinity());
  EXPECT_TRUE(std::isnan(pixels->at(5, 0)));
}

TEST(Exr, SaysWhatItDoesNotRead) {
  ExrPlan plan = sloping(12, 20);
  EXPECT_ERROR(decode_exr(exr_file(plan), 12 * 20 - 1), "it claims 12x20 pixels");
  plan.packing = 4;
  EXPECT_ERROR(decode_exr(exr_file(plan), kMaxExrPixels), "packed in a way (4) that is not read");
  plan = sloping(12, 20);
  plan.flags = 0x200;
  EXPECT_ERROR(decode_exr(exr_file(plan), kMaxExrPixels), "it has tiles");
  EXPECT_ERROR(decode_exr(Bytes{1, 2, 3}, kMaxExrPixels), "it is no OpenEXR file");
  EXPECT_FALSE(is_exr(Bytes{1, 2, 3}));
}

TEST(Exr, IsRefusedWhereverItIsCutOff) {
  const Bytes whole = exr_file(sloping(12, 37));
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_FALSE(decode_exr(std::span(whole).first(size), kMaxExrPixels)) << size;
  }
}

TEST(Exr, SurvivesRandomBytes) {
  RandomStream random(3);
  const Bytes whole = exr_file(sloping(12, 37));
  for (int round = 0; round < 3000; ++round) {
    Bytes bytes = whole;
    for (int flips = 0; flips < 4; ++flips) {
      bytes[random.index(bytes.size())] = static_cast<std::uint8_t>(random.next());
    }
    const auto pixels = decode_exr(bytes, kMaxExrPixels);
    EXPECT_TRUE(pixels || !pixels.error().message.empty());
  }
}

}  // namespace
}  // namespace roomwise::recording
