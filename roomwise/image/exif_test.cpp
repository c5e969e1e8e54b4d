#include "roomwise/image/exif.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/base/file.h"
#include "roomwise/base/random.h"

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
