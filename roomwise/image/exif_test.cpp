#include "roomwise/image/exif.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "roomwise/base/file.h"
#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/image/codec.h"
#include "roomwise/image/testing/exif_writer.h"

namespace roomwise::image {
namespace {

// Exif with a directory of two entries: ImageWidth and Orientation.
Bytes exif_with(std::uint8_t orientation, bool big_endian) {
  if (big_endian) {
    return {'E', 'x',  'i', 'f', 0, 0, 'M', 'M', 0, 42,          0, 0, 0, 8, 0, 2,  //
            1,   0,    0,   3,   0, 0, 0,   1,   1, 0,           0, 0,              //
            1,   0x12, 0,   3,   0, 0, 0,   1,   0, orientation, 0, 0,              //
            0,   0,    0,   0};
  }
  return {'E',  'x', 'i', 'f', 0, 0, 'I', 'I', 42,          0, 8, 0, 0, 0, 2, 0,  //
          0,    1,   3,   0,   1, 0, 0,   0,   0,           1, 0, 0,              //
          0x12, 1,   3,   0,   1, 0, 0,   0,   orientation, 0, 0, 0,              //
          0,    0,   0,   0};
}

TEST(Exif, ReadsTheOrientationInBothByteOrders) {
  for (std::uint8_t orientation = 1; orientation <= 8; ++orientation) {
    EXPECT_EQ(exif_orientation(exif_with(orientation, false)), orientation);
    EXPECT_EQ(exif_orientation(exif_with(orientation, true)), orientation);
  }
}

TEST(Exif, IsUprightWhereTheBytesMakeNoSense) {
  EXPECT_EQ(exif_orientation({}), kUpright);
  EXPECT_EQ(exif_orientation(exif_with(0, false)), kUpright);
  EXPECT_EQ(exif_orientation(exif_with(9, false)), kUpright);
  const Bytes whole = exif_with(6, true);
  constexpr std::size_t kEndOfOrientation = 38;
  for (std::size_t size = 0; size < kEndOfOrientation; ++size) {
    EXPECT_EQ(exif_orientation(std::span(whole).first(size)), kUpright) << size;
  }
  Bytes far_directory = whole;
  for (std::size_t i = 10; i < 14; ++i) far_directory[i] = 0xFF;
  EXPECT_EQ(exif_orientation(far_directory), kUpright);
}

TEST(Exif, SurvivesRandomBytes) {
  RandomStream random(5);
  for (int round = 0; round < 2000; ++round) {
    Bytes bytes = exif_with(6, round % 2 == 0);
    for (int flips = 0; flips < 4; ++flips) {
      bytes[random.index(bytes.size())] = static_cast<std::uint8_t>(random.next());
    }
    const int orientation = exif_orientation(bytes);
    EXPECT_TRUE(orientation >= 1 && orientation <= 8);
  }
}

using testing::ExifEntry;
using testing::ExifWriter;
using testing::kPhoneExif;

TEST(ExifLens, ReadsWhatAPhoneSaysInBothByteOrders) {
  for (const bool big_endian : {false, true}) {
    const Bytes bytes = ExifWriter(big_endian).write(kPhoneExif);
    EXPECT_EQ(exif_orientation(bytes), 6);
    const auto lens = exif_lens(bytes);
    ASSERT_TRUE(lens.has_value());
    EXPECT_EQ(lens->focal_length_mm, 4.25);
    EXPECT_EQ(lens->focal_length_35mm_mm, 26);
    EXPECT_EQ(lens->pixels_per_mm, 800);
    EXPECT_EQ(lens->digital_zoom, 1.5);
    EXPECT_EQ(lens->width, 4032);
    EXPECT_EQ(lens->height, 3024);
  }
}

TEST(ExifLens, LeavesOutWhatMakesNoSense) {
  const auto read = [](std::vector<ExifEntry> entries) {
    return exif_lens(ExifWriter(true).write(entries));
  };
  EXPECT_FALSE(read({{0xA405, 3, 0}})) << "0 stands for unknown";
  EXPECT_FALSE(read({{0x920A, 5, 425, 100}})) << "without the sensor it tells nothing";
  EXPECT_FALSE(read({{0x920A, 5, 425, 0}, {0xA20E, 5, 8000, 1}}));
  EXPECT_FALSE(read({{0xA405, 5, 26, 1}})) << "of another kind";
  const auto lens = read({{0xA405, 3, 26}, {0xA404, 5, 0, 1}, {0x920A, 5, 1, 1000}});
  ASSERT_TRUE(lens.has_value());
  EXPECT_FALSE(lens->digital_zoom) << "0: no zoom";
  EXPECT_FALSE(lens->focal_length_mm);
}

TEST(ExifLens, SurvivesAnyCutAndRandomBytes) {
  const Bytes whole = ExifWriter(false).write(kPhoneExif);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    static_cast<void>(exif_lens(std::span(whole).first(size)));
  }
  RandomStream random(6);
  for (int round = 0; round < 2000; ++round) {
    Bytes bytes = ExifWriter(round % 2 == 0).write(kPhoneExif);
    for (int flips = 0; flips < 4; ++flips) {
      bytes[random.index(bytes.size())] = static_cast<std::uint8_t>(random.next());
    }
    const auto lens = exif_lens(bytes);
    EXPECT_TRUE(!lens || std::isfinite(lens->focal_length_mm.value_or(0)));
  }
}

TEST(ExifLens, ComesWithAPhoto) {
  const Bytes plain = encode_jpeg(ColorImage(8, 6), 90);
  EXPECT_FALSE(decode_photo(plain).value().lens);
  const Bytes jpeg = testing::with_exif(plain, ExifWriter(true).write(kPhoneExif));
  const auto photo = decode_photo(jpeg);
  ASSERT_OK(photo);
  EXPECT_EQ(photo->color.width(), 6) << "upright";
  EXPECT_EQ(photo->lens.value().focal_length_35mm_mm, 26);
}

// A picture of 3 x 2 pixels, 0 1 2 / 3 4 5, as the numbers of the upright picture row by row.
TEST(Exif, TurnsThePictureUpright) {
  ColorImage image(3, 2);
  for (std::uint8_t i = 0; i < 6; ++i) image.pixels()[i] = {i, 0, 0};
  const std::vector<std::vector<int>> upright{{0, 1, 2, 3, 4, 5},   // 1: as stored
                                              {2, 1, 0, 5, 4, 3},   // 2: mirrored
                                              {5, 4, 3, 2, 1, 0},   // 3: upside down
                                              {3, 4, 5, 0, 1, 2},   // 4: upside down, mirrored
                                              {0, 3, 1, 4, 2, 5},   // 5: rows are columns
                                              {3, 0, 4, 1, 5, 2},   // 6: turn clockwise
                                              {5, 2, 4, 1, 3, 0},   // 7: 5, upside down
                                              {2, 5, 1, 4, 0, 3}};  // 8: turn anticlockwise
  for (int orientation = 1; orientation <= 8; ++orientation) {
    const ColorImage turned = apply_orientation(image, orientation);
    EXPECT_EQ(turned.width(), orientation >= 5 ? 2 : 3);
    std::vector<int> found;
    for (const Rgb8 pixel : turned.pixels()) found.push_back(pixel.r);
    EXPECT_EQ(found, upright[static_cast<std::size_t>(orientation - 1)]) << orientation;
  }
}

}  // namespace
}  // namespace roomwise::image
