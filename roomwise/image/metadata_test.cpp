#include "roomwise/image/metadata.h"

#include <gtest/gtest.h>
#include <webp/encode.h>

#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/image/codec.h"
#include "roomwise/image/testing/exif_writer.h"

namespace roomwise::image {
namespace {

using testing::exif_with_place;
using testing::secrets_in;
using testing::with_exif;

ColorImage some_picture() {
  ColorImage color(24, 16);
  for (int y = 0; y < color.height(); ++y) {
    for (int x = 0; x < color.width(); ++x) {
      color.at(x, y) = {static_cast<std::uint8_t>(10 * x), static_cast<std::uint8_t>(15 * y), 90};
    }
  }
  return color;
}

void append_text(Bytes& bytes, std::string_view text) {
  bytes.insert(bytes.end(), text.begin(), text.end());
}

// A segment behind the picture's first bytes.
Bytes with_segment(Bytes jpeg, std::uint8_t marker, std::string_view content) {
  Bytes segment{0xFF, marker, 0, static_cast<std::uint8_t>(content.size() + 2)};
  append_text(segment, content);
  jpeg.insert(jpeg.begin() + 2, segment.begin(), segment.end());
  return jpeg;
}

// A chunk before the end of the picture. No decoder looks at the CRC of one that it passes over.
Bytes with_chunk(Bytes png, std::string_view letters, std::string_view content) {
  Bytes chunk{0, 0, 0, static_cast<std::uint8_t>(content.size())};
  append_text(chunk, letters);
  append_text(chunk, content);
  chunk.insert(chunk.end(), 4, 0);
  constexpr std::ptrdiff_t kEnd = 12;
  png.insert(png.end() - kEnd, chunk.begin(), chunk.end());
  return png;
}

TEST(Metadata, OfAJpegGoesAndThePictureStaysAsItIsTurned) {
  const Bytes plain = encode_jpeg(some_picture(), 90);
  for (std::uint8_t orientation = 1; orientation <= 8; ++orientation) {
    Bytes jpeg = with_exif(plain, exif_with_place(orientation));
    jpeg = with_segment(jpeg, 0xE1, "http://ns.adobe.com/xap/1.0/ SecretPhone");
    jpeg = with_segment(jpeg, 0xED, "Photoshop 3.0 Jane Secret");
    jpeg = with_segment(jpeg, 0xFE, "by Jane Secret");
    append_text(jpeg, "a second picture by Jane Secret");
    EXPECT_EQ(secrets_in(jpeg), "device owner place ");
    const auto bare = without_metadata(jpeg);
    ASSERT_TRUE(bare);
    EXPECT_EQ(secrets_in(*bare), "");
    EXPECT_EQ(decode_color(*bare).value(), decode_color(jpeg).value()) << int{orientation};
    EXPECT_EQ(decode_color(*bare)->width(), orientation >= 5 ? 16 : 24);
    EXPECT_EQ(without_metadata(*bare), bare) << "there is nothing more to leave out";
  }
}

TEST(Metadata, LeavesAPictureWithoutAsItIs) {
  const Bytes jpeg = encode_jpeg(some_picture(), 90), png = encode_png(some_picture());
  EXPECT_EQ(without_metadata(jpeg), jpeg);
  EXPECT_EQ(without_metadata(png), png);
  const Bytes depth = encode_png(DepthImage(8, 6, 1500));
  EXPECT_EQ(without_metadata(depth), depth);
}

TEST(Metadata, OfTheColoursOfAJpegWhatDecodersAskForStays) {
  const Bytes plain = encode_jpeg(some_picture(), 90);
  // Of a picture that says so the three channels are red, green and blue.
  const std::string_view adobe("Adobe\0d\0\0\0\0\0 and Jane Secret", 28);
  Bytes rgb = plain;
  rgb.erase(rgb.begin() + 2, rgb.begin() + 20);  // that of JFIF, which says otherwise
  rgb = with_segment(rgb, 0xEE, adobe);
  ASSERT_NE(decode_color(rgb).value(), decode_color(plain).value());
  const auto bare = without_metadata(rgb);
  ASSERT_TRUE(bare);
  EXPECT_EQ(decode_color(*bare).value(), decode_color(rgb).value());
  EXPECT_EQ(secrets_in(*bare), "");
}

TEST(Metadata, OfAPngGoes) {
  const Bytes exif = exif_with_place(1);
  const std::string tiff(exif.begin() + 6, exif.end());
  Bytes png = with_chunk(encode_png(some_picture()), "eXIf", tiff);
  png = with_chunk(png, "tEXt", std::string_view("Author\0Jane Secret", 18));
  append_text(png, "SecretPhone");
  EXPECT_EQ(personal_data_of(png), (PersonalData{true, true, true}));
  const auto bare = without_metadata(png);
  ASSERT_TRUE(bare);
  EXPECT_EQ(*bare, encode_png(some_picture()));
}

TEST(Metadata, OfAWebpGoes) {
  const ColorImage color = some_picture();
  std::uint8_t* encoded = nullptr;
  const std::size_t size =
      WebPEncodeLosslessRGB(reinterpret_cast<const std::uint8_t*>(color.pixels().data()),
                            color.width(), color.height(), 3 * color.width(), &encoded);
  const Bytes plain(encoded, encoded + size);
  WebPFree(encoded);
  const Bytes exif = exif_with_place(1);
  Bytes webp(plain.begin(), plain.begin() + 12);
  append_text(webp, std::string_view("VP8X\x0A\0\0\0\x08\0\0\0\x17\0\0\x0F\0\0", 18));
  webp.insert(webp.end(), plain.begin() + 12, plain.end());
  append_text(webp, "EXIF");
  const Bytes length{static_cast<std::uint8_t>(exif.size()), 0, 0, 0};
  webp.insert(webp.end(), length.begin(), length.end());
  webp.insert(webp.end(), exif.begin(), exif.end());
  webp[4] = static_cast<std::uint8_t>(webp.size() - 8);
  webp[5] = static_cast<std::uint8_t>((webp.size() - 8) >> 8U);
  ASSERT_EQ(decode_color(webp).value(), color);
  EXPECT_TRUE(personal_data_of(webp).place);
  const auto bare = without_metadata(webp);
  ASSERT_TRUE(bare);
  EXPECT_EQ(secrets_in(*bare), "");
  EXPECT_EQ(decode_color(*bare).value(), color);
  EXPECT_EQ(without_metadata(plain), plain);
}

TEST(Metadata, IsToldOfButNotRead) {
  const Bytes plain = encode_jpeg(some_picture(), 90);
  EXPECT_FALSE(personal_data_of(plain).any());
  EXPECT_FALSE(personal_data_of({}).any());
  EXPECT_EQ(personal_data_of(with_exif(plain, exif_with_place(6))),
            (PersonalData{true, true, true}));
  const Bytes lens = testing::ExifWriter(true).write(testing::kPhoneExif);
  EXPECT_FALSE(personal_data_of(with_exif(plain, lens)).any()) << "a lens is nobody's name";
  EXPECT_EQ(personal_data_of(
                with_segment(plain, 0xE1, "http://ns.adobe.com/xap/1.0/ exif:GPSLatitude=\"50\"")),
            (PersonalData{true, false, false}));
}

TEST(Metadata, OfFilesThatMakeNoSenseIsNothing) {
  EXPECT_FALSE(without_metadata({}));
  EXPECT_FALSE(without_metadata(Bytes{1, 2, 3}));
  const Bytes jpeg = with_exif(encode_jpeg(some_picture(), 90), exif_with_place(6));
  const Bytes png = encode_png(some_picture());
  for (const Bytes& whole : {jpeg, png}) {
    for (std::size_t size = 0; size < whole.size(); ++size) {
      EXPECT_FALSE(without_metadata(std::span(whole).first(size))) << size;
      static_cast<void>(personal_data_of(std::span(whole).first(size)));
    }
  }
}

TEST(Metadata, NeverChangesAPictureThatCanBeDecoded) {
  RandomStream random(7);
  const Bytes jpeg = with_exif(encode_jpeg(some_picture(), 90), exif_with_place(6));
  const Bytes png = with_chunk(encode_png(some_picture()), "tEXt", "Author");
  for (int round = 0; round < 4000; ++round) {
    Bytes damaged = round % 2 == 0 ? jpeg : png;
    damaged[random.index(damaged.size())] = static_cast<std::uint8_t>(random.next());
    const auto decoded = decode_color(damaged);
    if (!decoded) continue;
    const auto bare = without_metadata(damaged);
    if (!bare) continue;
    EXPECT_EQ(decode_color(*bare).value_or(ColorImage()), *decoded) << round;
  }
}

}  // namespace
}  // namespace roomwise::image
