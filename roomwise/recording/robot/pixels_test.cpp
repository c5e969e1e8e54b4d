#include "roomwise/recording/robot/pixels.h"

#include <gmock/gmock.h>

#include <limits>

#include "roomwise/base/testing/testing.h"
#include "roomwise/image/codec.h"
#include "roomwise/recording/messages/testing/byte_writer.h"

namespace roomwise::recording {
namespace {

using recording::testing::ByteWriter;
using ::testing::ElementsAre;

ImageMessage image_of(const std::string& pixels, std::uint32_t width, std::uint32_t step,
                      Bytes data, std::uint32_t height = 1) {
  ImageMessage image;
  image.width = width;
  image.height = height;
  image.pixels = pixels;
  image.step = step;
  image.data = std::move(data);
  return image;
}

TEST(Pixels, ColourComesInManyOrders) {
  const Rgb8 pixel{10, 20, 30};
  EXPECT_EQ(color_of(image_of("rgb8", 1, 3, {10, 20, 30})).value().at(0, 0), pixel);
  EXPECT_EQ(color_of(image_of("bgr8", 1, 3, {30, 20, 10})).value().at(0, 0), pixel);
  EXPECT_EQ(color_of(image_of("8UC3", 1, 3, {30, 20, 10})).value().at(0, 0), pixel);
  EXPECT_EQ(color_of(image_of("rgba8", 1, 4, {10, 20, 30, 7})).value().at(0, 0), pixel);
  EXPECT_EQ(color_of(image_of("bgra8", 1, 4, {30, 20, 10, 7})).value().at(0, 0), pixel);
  EXPECT_EQ(color_of(image_of("mono8", 1, 1, {9})).value().at(0, 0), (Rgb8{9, 9, 9}));
}

TEST(Pixels, RowsMayBePadded) {
  const auto color = color_of(image_of("mono8", 2, 4, {1, 2, 0, 0, 3, 4}, 2));
  ASSERT_OK(color);
  EXPECT_EQ(color->at(1, 1), (Rgb8{4, 4, 4}));
}

TEST(Pixels, LumaAndChromaBecomeColour) {
  // White, black, and red as BT.601 has it.
  const auto uyvy = color_of(image_of("yuv422", 2, 4, {128, 235, 128, 16}));
  ASSERT_OK(uyvy);
  EXPECT_EQ(uyvy->at(0, 0), (Rgb8{255, 255, 255}));
  EXPECT_EQ(uyvy->at(1, 0), (Rgb8{0, 0, 0}));
  const auto yuyv = color_of(image_of("YUYV", 2, 4, {81, 90, 81, 240}));
  ASSERT_OK(yuyv);
  EXPECT_GT(yuyv->at(1, 0).r, 250);
  EXPECT_LT(yuyv->at(1, 0).g, 5);
}

TEST(Pixels, DepthInMillimetresIsTakenAsItIs) {
  auto image = image_of("16UC1", 2, 4, {0xE8, 0x03, 0, 0});
  EXPECT_THAT(depth_of(image).value().pixels(), ElementsAre(1000, 0));
  image.data = {0x03, 0xE8, 0, 1};
  image.is_big_endian = true;
  EXPECT_THAT(depth_of(image).value().pixels(), ElementsAre(1000, 1));
}

TEST(Pixels, DepthInMetresIsRoundedAndWhatIsNoDepthIsZero) {
  ByteWriter data;
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  for (const float m : {1.25F, 0.0F, -1.0F, kInfinity, -kInfinity, std::nanf(""), 65.5F, 66.0F}) {
    data.number<float>(m);
  }
  EXPECT_THAT(depth_of(image_of("32FC1", 8, 32, data.all())).value().pixels(),
              ElementsAre(1250, 0, 0, 0, 0, 0, 65500, 0));
}

TEST(Pixels, APictureThatLiesAboutItsSizeIsRefused) {
  EXPECT_ERROR(color_of(image_of("rgb8", 2, 6, Bytes(5))), "2x1 pixels");
  EXPECT_ERROR(color_of(image_of("rgb8", 2, 3, Bytes(6))), "3 a row");
  EXPECT_ERROR(color_of(image_of("rgb8", 2, 6, Bytes(12), 3)), "12 bytes");
  EXPECT_ERROR(depth_of(image_of("16UC1", 4'000'000'000, 8, Bytes(8), 4'000'000'000)), "claims");
  EXPECT_ERROR(depth_of(image_of("16UC1", 0, 0, {})), "claims");
  EXPECT_ERROR(color_of(image_of("bayer_rggb8", 1, 1, {1})), "'bayer_rggb8'");
  EXPECT_ERROR(depth_of(image_of("rgb8", 1, 3, Bytes(3))), "record 16UC1");
}

CompressedImageMessage compressed(const std::string& format, Bytes data) {
  return {{}, format, std::move(data)};
}

Bytes depth_png(std::vector<std::uint16_t> depths) {
  image::DepthImage depth(static_cast<int>(depths.size()), 1);
  std::ranges::copy(depths, depth.pixels().begin());
  return image::encode_png(depth);
}

Bytes with_config(float a, float b, const Bytes& picture) {
  return ByteWriter()
      .number<std::uint32_t>(1)
      .number<float>(a)
      .number<float>(b)
      .bytes(picture)
      .all();
}

TEST(Pixels, CompressedDepthIsAPngBehindItsParameters) {
  const Bytes png = depth_png({1000, 0, 2345});
  const auto image = compressed("16UC1; compressedDepth png", with_config(0, 0, png));
  EXPECT_EQ(pixel_kind(image), PixelKind::kDepth);
  EXPECT_THAT(depth_of(image).value().pixels(), ElementsAre(1000, 0, 2345));
  EXPECT_THAT(depth_png_of(image), ::testing::ElementsAreArray(png));
}

TEST(Pixels, CompressedDepthInMetresIsInverse) {
  // depth = a / (value - b)
  const auto image =
      compressed("32FC1; compressedDepth png", with_config(100, -50, depth_png({0, 50, 150})));
  EXPECT_THAT(depth_of(image).value().pixels(), ElementsAre(0, 1000, 500));
  EXPECT_TRUE(depth_png_of(image).empty());
}

// One zero, then three values: 5, 5, 3.
Bytes some_rvl() {
  return ByteWriter()
      .number<std::uint32_t>(4)
      .number<std::uint32_t>(1)
      .number<std::uint32_t>(0x13A10300)
      .all();
}

TEST(Pixels, CompressedDepthInMetresIsInverseInRvlToo) {
  const auto image = compressed("32FC1; compressedDepth rvl", with_config(10, -5, some_rvl()));
  EXPECT_THAT(depth_of(image).value().pixels(), ElementsAre(0, 1000, 1000, 1250));
}

TEST(Pixels, CompressedDepthMayBeRvl) {
  const auto image = compressed("16UC1; compressedDepth rvl", with_config(0, 0, some_rvl()));
  EXPECT_THAT(depth_of(image).value().pixels(), ElementsAre(0, 5, 5, 3));
  auto cut_off = image;
  cut_off.data.resize(cut_off.data.size() - 1);
  EXPECT_ERROR(depth_of(cut_off), "cut off");
  auto lying = image;
  for (std::size_t i = 12; i < 20; ++i) lying.data[i] = 0xFF;
  EXPECT_ERROR(depth_of(lying), "claims");
}

TEST(Pixels, APngOfSixteenBitsIsDepth) {
  const auto depth = compressed("png", depth_png({7, 8}));
  EXPECT_EQ(pixel_kind(depth), PixelKind::kDepth);
  EXPECT_THAT(depth_of(depth).value().pixels(), ElementsAre(7, 8));
  const auto color = compressed("png", image::encode_png(image::ColorImage(2, 2, {1, 2, 3})));
  EXPECT_EQ(pixel_kind(color), PixelKind::kColor);
  EXPECT_EQ(color_of(color).value().at(1, 1), (Rgb8{1, 2, 3}));
  EXPECT_EQ(pixel_kind(compressed("h264", {0, 0, 0, 1})), PixelKind::kOther);
}

TEST(Pixels, CompressedDepthThatIsTooShortIsRefused) {
  EXPECT_ERROR(depth_of(compressed("16UC1; compressedDepth png", Bytes(12))), "12 bytes");
  EXPECT_ERROR(depth_of(compressed("16UC1; compressedDepth png", Bytes(40))), "16UC1 as PNG");
  EXPECT_FALSE(depth_of(compressed("32FC1; compressedDepth png", Bytes(40))));
}

}  // namespace
}  // namespace roomwise::recording
