#include "roomwise/image/codec.h"

// jpeglib.h needs these declared before it.
#include <cstddef>
#include <cstdio>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <jpeglib.h>
#include <png.h>
#include <sys/resource.h>
#include <webp/encode.h>
#include <zlib.h>

#include <cstdlib>
#include <functional>

#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::image {
namespace {

using roomwise::testing::ScratchFolder;

// Smooth, with every channel different, so that a JPEG stays close to it.
ColorImage gradient(int width, int height) {
  ColorImage image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image.at(x, y) = {static_cast<std::uint8_t>(255 * x / width),
                        static_cast<std::uint8_t>(255 * y / height),
                        static_cast<std::uint8_t>(127 * (x + y) / (width + height))};
    }
  }
  return image;
}

DepthImage random_depth(int width, int height) {
  RandomStream random(3);
  DepthImage depth(width, height);
  for (std::uint16_t& value : depth.pixels()) value = static_cast<std::uint16_t>(random.next());
  return depth;
}

int largest_difference(const ColorImage& a, const ColorImage& b) {
  int largest = 0;
  for (std::size_t i = 0; i < a.pixels().size(); ++i) {
    const Rgb8 p = a.pixels()[i];
    const Rgb8 q = b.pixels()[i];
    largest = std::max({largest, std::abs(p.r - q.r), std::abs(p.g - q.g), std::abs(p.b - q.b)});
  }
  return largest;
}

// A JPEG as other programs write it; `configure` sets what encode_jpeg has no option for.
Bytes make_jpeg(const Bytes& samples, int width, int height, int channels, J_COLOR_SPACE space,
                const std::function<void(jpeg_compress_struct&)>& configure = {},
                const Bytes& app1 = {}) {
  jpeg_compress_struct codec{};
  jpeg_error_mgr errors{};
  codec.err = jpeg_std_error(&errors);
  jpeg_create_compress(&codec);
  unsigned char* buffer = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&codec, &buffer, &size);
  codec.image_width = static_cast<JDIMENSION>(width);
  codec.image_height = static_cast<JDIMENSION>(height);
  codec.input_components = channels;
  codec.in_color_space = space;
  jpeg_set_defaults(&codec);
  jpeg_set_quality(&codec, 95, TRUE);
  if (configure) configure(codec);
  jpeg_start_compress(&codec, TRUE);
  if (!app1.empty()) {
    jpeg_write_marker(&codec, JPEG_APP0 + 1, app1.data(), static_cast<unsigned>(app1.size()));
  }
  Bytes copy = samples;
  while (codec.next_scanline < codec.image_height) {
    JSAMPROW row = copy.data() + static_cast<std::size_t>(codec.next_scanline) *
                                     static_cast<std::size_t>(width * channels);
    jpeg_write_scanlines(&codec, &row, 1);
  }
  jpeg_finish_compress(&codec);
  Bytes bytes(buffer, buffer + size);
  jpeg_destroy_compress(&codec);
  std::free(buffer);
  return bytes;
}

Bytes samples_of(const ColorImage& image) {
  Bytes samples;
  for (const Rgb8 pixel : image.pixels())
    samples.insert(samples.end(), {pixel.r, pixel.g, pixel.b});
  return samples;
}

struct PngLayout {
  int color_type = PNG_COLOR_TYPE_RGB;
  int bit_depth = 8;
  int interlace = PNG_INTERLACE_NONE;
};

// A PNG as other programs write it. samples: one number a channel and pixel, packed by libpng.
Bytes make_png(int width, int height, const PngLayout& layout,
               const std::vector<std::uint16_t>& samples,
               const std::vector<png_color>& palette = {}, Bytes palette_alpha = {}) {
  Bytes bytes;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(
      png, &bytes,
      [](png_structp p, png_bytep data, std::size_t size) {
        auto& out = *static_cast<Bytes*>(png_get_io_ptr(p));
        out.insert(out.end(), data, data + size);
      },
      nullptr);
  png_set_IHDR(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height),
               layout.bit_depth, layout.color_type, layout.interlace, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  if (!palette.empty()) {
    png_set_PLTE(png, info, palette.data(), static_cast<int>(palette.size()));
    png_set_tRNS(png, info, palette_alpha.data(), static_cast<int>(palette_alpha.size()), nullptr);
  }
  png_write_info(png, info);
  png_set_packing(png);
  Bytes packed;
  for (const std::uint16_t sample : samples) {
    if (layout.bit_depth == 16) packed.push_back(static_cast<std::uint8_t>(sample >> 8));
    packed.push_back(static_cast<std::uint8_t>(sample));
  }
  const std::size_t row_size = packed.size() / static_cast<std::size_t>(height);
  std::vector<png_bytep> rows;
  for (std::size_t y = 0; y < static_cast<std::size_t>(height); ++y) {
    rows.push_back(packed.data() + y * row_size);
  }
  png_write_image(png, rows.data());
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  return bytes;
}

TEST(Codec, KeepsEveryPixelInPng) {
  const ColorImage color = gradient(37, 23);
  const DepthImage depth = random_depth(37, 23);
  EXPECT_EQ(decode_color(encode_png(color)).value(), color);
  EXPECT_EQ(decode_depth(encode_png(depth)).value(), depth);
  EXPECT_EQ(decode_depth(encode_smooth_png(depth)).value(), depth);
}

TEST(Codec, DepthThatRunsOnFromRowToRowIsPackedSmaller) {
  DepthImage slope(160, 120);
  for (int y = 0; y < slope.height(); ++y) {
    for (int x = 0; x < slope.width(); ++x) {
      slope.at(x, y) = static_cast<std::uint16_t>(1000 + 7 * y + (x * x) % 311);
    }
  }
  EXPECT_LT(2 * encode_smooth_png(slope).size(), encode_png(slope).size());
}

// Both ways through PNG would hide bytes that are swapped twice; the other side here is libpng
// alone.
TEST(Codec, HasTheByteOrderOfPng) {
  const DepthImage depth =
      decode_depth(make_png(2, 1, {PNG_COLOR_TYPE_GRAY, 16}, {0x1234, 5000})).value();
  EXPECT_THAT(depth.pixels(), ::testing::ElementsAre(0x1234, 5000));
}

TEST(Codec, StaysCloseInJpeg) {
  const ColorImage image = gradient(64, 48);
  EXPECT_LE(largest_difference(decode_color(encode_jpeg(image, 95)).value(), image), 8);
}

TEST(Codec, ReadsProgressiveAndGreyJpeg) {
  const ColorImage image = gradient(64, 48);
  const Bytes progressive = make_jpeg(samples_of(image), 64, 48, 3, JCS_RGB,
                                      [](auto& codec) { jpeg_simple_progression(&codec); });
  EXPECT_LE(largest_difference(decode_color(progressive).value(), image), 8);

  const Bytes grey = make_jpeg(Bytes(64 * 48, 90), 64, 48, 1, JCS_GRAYSCALE);
  EXPECT_EQ(decode_color(grey).value(), ColorImage(64, 48, {90, 90, 90}));
}

// Each coefficient in two scans of its own: 127 of them, where usual pictures have some ten.
TEST(Codec, RefusesAJpegOfVeryManyScans) {
  std::vector<jpeg_scan_info> scans{{1, {0}, 0, 0, 0, 0}};
  for (const int is_refined : {0, 1}) {
    for (int k = 1; k < DCTSIZE2; ++k) scans.push_back({1, {0}, k, k, is_refined, 1 - is_refined});
  }
  const auto of_scans = [&](std::size_t count) {
    return make_jpeg(Bytes(64 * 48, 90), 64, 48, 1, JCS_GRAYSCALE, [&](auto& codec) {
      codec.scan_info = scans.data();
      codec.num_scans = static_cast<int>(count);
    });
  };
  EXPECT_OK(decode_color(of_scans(64)));
  EXPECT_ERROR(decode_color(of_scans(scans.size())), "more than 64 scans");
}

// Texts that are packed to a thousandth of their size, 300 MB of them.
TEST(Codec, KeepsNothingOfAPngButThePicture) {
  std::string text(7'900'000, 'a');
  const Bytes plain = make_png(2, 1, {PNG_COLOR_TYPE_GRAY, 8}, {7, 9});
  Bytes packed(text.size() / 100);
  uLongf size = packed.size();
  ASSERT_EQ(
      compress(packed.data(), &size, reinterpret_cast<const Bytef*>(text.data()), text.size()),
      Z_OK);
  packed.resize(size);
  text.clear();
  text.shrink_to_fit();
  Bytes chunk{'z', 'T', 'X', 't', 'k', 0, 0};
  chunk.insert(chunk.end(), packed.begin(), packed.end());
  const auto append_number = [](Bytes& bytes, std::uint64_t number) {
    for (const int shift : {24, 16, 8, 0})
      bytes.push_back(static_cast<std::uint8_t>(number >> shift));
  };
  constexpr std::ptrdiff_t kHeader = 33;  // the mark and IHDR
  Bytes png(plain.begin(), plain.begin() + kHeader);
  for (int i = 0; i < 40; ++i) {
    append_number(png, chunk.size() - 4);
    png.insert(png.end(), chunk.begin(), chunk.end());
    append_number(png, crc32(0, chunk.data(), static_cast<uInt>(chunk.size())));
  }
  png.insert(png.end(), plain.begin() + kHeader, plain.end());
  const auto peak_kb = [] {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss;
  };
  const long before_kb = peak_kb();
  EXPECT_EQ(decode_color(png).value(), decode_color(plain).value());
  EXPECT_LT(peak_kb() - before_kb, 100'000);
}

TEST(Codec, TurnsAPhotoUprightByItsExif) {
  // "II", 42, the directory at 8 with one entry: tag 0x0112, SHORT, 1 value, 6 (turn clockwise).
  const Bytes exif{'E',  'x', 'i', 'f', 0, 0, 'I', 'I', 42, 0, 8, 0, 0, 0, 1, 0,
                   0x12, 1,   3,   0,   1, 0, 0,   0,   6,  0, 0, 0, 0, 0, 0, 0};
  const ColorImage image = gradient(64, 48);
  const Bytes jpeg = make_jpeg(samples_of(image), 64, 48, 3, JCS_RGB, {}, exif);
  const ColorImage upright = decode_color(jpeg).value();
  ASSERT_EQ(upright.width(), 48);
  ASSERT_EQ(upright.height(), 64);
  EXPECT_NEAR(upright.at(47, 0).r, image.at(0, 0).r, 8) << "top left went to the top right";
  EXPECT_NEAR(upright.at(47, 63).r, image.at(63, 0).r, 8) << "top right went to the bottom right";

  const roomwise::testing::ScratchFolder folder;
  ASSERT_OK(write_file(folder / "turned.jpg", jpeg));
  const ColorImage as_taken = read_color_as_taken(folder / "turned.jpg").value();
  ASSERT_EQ(as_taken.width(), 64);
  EXPECT_NEAR(as_taken.at(63, 0).r, image.at(63, 0).r, 8);
}

TEST(Codec, RefusesCmyk) {
  const Bytes cmyk = make_jpeg(Bytes(16 * 16 * 4, 100), 16, 16, 4, JCS_CMYK);
  EXPECT_ERROR(decode_color(cmyk), "is a CMYK JPEG");
}

TEST(Codec, ReadsEveryKindOfPng) {
  for (const int interlace : {PNG_INTERLACE_NONE, PNG_INTERLACE_ADAM7}) {
    for (const int depth : {1, 2, 4, 8, 16}) {
      // Black and white are the same at every depth.
      const auto white = static_cast<std::uint16_t>((1 << depth) - 1);
      const ColorImage grey = decode_color(make_png(3, 2, {PNG_COLOR_TYPE_GRAY, depth, interlace},
                                                    {white, 0, 0, 0, white, white}))
                                  .value();
      const Rgb8 w{255, 255, 255};
      const Rgb8 b{0, 0, 0};
      EXPECT_THAT(grey.pixels(), ::testing::ElementsAre(w, b, b, b, w, w)) << depth;

      if (depth >= 8) {
        const auto half = static_cast<std::uint16_t>(white / 2);
        const auto rgb = decode_color(
            make_png(2, 1, {PNG_COLOR_TYPE_RGB, depth, interlace}, {white, 0, half, 0, white, 0}));
        EXPECT_THAT(rgb->pixels(), ::testing::ElementsAre(Rgb8{255, 0, 127}, Rgb8{0, 255, 0}))
            << depth;
        const auto rgba = decode_color(make_png(2, 1, {PNG_COLOR_TYPE_RGBA, depth, interlace},
                                                {white, 0, white, white, white, white, white, 0}));
        EXPECT_THAT(rgba->pixels(), ::testing::ElementsAre(Rgb8{255, 0, 255}, b))
            << "alpha is blended over black";
        const auto grey_alpha = decode_color(
            make_png(2, 1, {PNG_COLOR_TYPE_GA, depth, interlace}, {white, half, white, white}));
        EXPECT_THAT(grey_alpha->pixels(), ::testing::ElementsAre(Rgb8{127, 127, 127}, w)) << depth;
      }
      if (depth <= 8) {
        const auto palette =
            decode_color(make_png(2, 1, {PNG_COLOR_TYPE_PALETTE, depth, interlace}, {0, 1},
                                  {{10, 20, 30}, {200, 100, 50}}, {255, 51}));
        EXPECT_THAT(palette->pixels(), ::testing::ElementsAre(Rgb8{10, 20, 30}, Rgb8{40, 20, 10}))
            << depth;
      }
    }
  }
}

TEST(Codec, RefusesDepthThatIsNot16BitGrey) {
  EXPECT_ERROR(decode_depth(encode_png(ColorImage(4, 4))),
               "is an 8-bit RGB picture; a depth image must be a 16-bit greyscale PNG");
  EXPECT_ERROR(decode_depth(make_png(1, 1, {PNG_COLOR_TYPE_GRAY, 8}, {1})),
               "is an 8-bit greyscale picture");
  EXPECT_ERROR(decode_depth(make_png(1, 1, {PNG_COLOR_TYPE_RGB, 16}, {1, 2, 3})),
               "is a 16-bit RGB picture");
  EXPECT_ERROR(decode_depth(encode_jpeg(ColorImage(4, 4), 90)), "is a JPEG");
  EXPECT_ERROR(decode_depth({}), "is empty");
}

TEST(Codec, RefusesWhatIsNoPicture) {
  EXPECT_ERROR(decode_color({}), "is empty");
  const Bytes text{'h', 'e', 'l', 'l', 'o'};
  EXPECT_ERROR(decode_color(text), "is neither a JPEG nor a PNG");
  const ScratchFolder folder;
  ASSERT_OK(write_file(folder / "note.jpg", text));
  EXPECT_ERROR(read_color(folder / "note.jpg"), (folder / "note.jpg").string());
  EXPECT_ERROR(read_color(folder / "none.jpg"), (folder / "none.jpg").string());
}

// A damaged header of a picture of 4 x 4 claims 60,000 x 60,000 pixels.
TEST(Codec, RefusesTooManyPixelsBeforeDecoding) {
  Bytes jpeg = encode_jpeg(ColorImage(4, 4), 90);
  const Bytes start_of_frame{0xFF, 0xC0};
  const auto frame =
      std::search(jpeg.begin(), jpeg.end(), start_of_frame.begin(), start_of_frame.end());
  ASSERT_NE(frame, jpeg.end());
  for (int i = 5; i < 9; i += 2) {
    frame[i] = 60'000 >> 8;
    frame[i + 1] = 60'000 & 0xFF;
  }
  EXPECT_ERROR(decode_color(jpeg), "has 60000x60000 pixels");
}

TEST(Codec, ReadsWebP) {
  const ColorImage image = gradient(37, 23);
  std::uint8_t* encoded = nullptr;
  const auto* const pixels = reinterpret_cast<const std::uint8_t*>(image.pixels().data());
  const std::size_t size = WebPEncodeLosslessRGB(pixels, 37, 23, 37 * 3, &encoded);
  const Bytes webp(encoded, encoded + size);
  WebPFree(encoded);
  ASSERT_TRUE(is_webp(webp));
  const auto decoded = decode_color(webp);
  ASSERT_OK(decoded);
  EXPECT_EQ(*decoded, image);
  EXPECT_ERROR(decode_color(webp, 37 * 23 - 1), "has 37x23 pixels");
  for (const std::size_t length : {size - 1, size / 2, std::size_t{16}}) {
    EXPECT_ERROR(decode_color(std::span(webp).first(length)), "truncated or damaged WebP");
  }
}

TEST(Codec, RefusesMorePixelsThanTheCallerTakes) {
  const Bytes jpeg = encode_jpeg(gradient(40, 30), 90);
  EXPECT_OK(decode_color(jpeg, 40 * 30));
  EXPECT_ERROR(decode_color(jpeg, 40 * 30 - 1), "has 40x30 pixels");
  EXPECT_ERROR(decode_color(encode_png(gradient(40, 30)), 1199), "has 40x30 pixels");
  EXPECT_ERROR(decode_depth(encode_png(random_depth(40, 30)), 1199), "has 40x30 pixels");
}

// No byte may be missing at the end: a picture that is half grey would poison a map silently.
TEST(Codec, RefusesEveryPrefixOfAPicture) {
  const ColorImage color = gradient(40, 32);
  const Bytes progressive = make_jpeg(samples_of(color), 40, 32, 3, JCS_RGB,
                                      [](auto& codec) { jpeg_simple_progression(&codec); });
  for (const Bytes& bytes : {encode_jpeg(color, 90), progressive, encode_png(color)}) {
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      ASSERT_FALSE(decode_color(std::span(bytes).first(size)).has_value())
          << size << " of " << bytes.size() << " bytes";
    }
  }
  const Bytes depth = encode_png(random_depth(20, 10));
  for (std::size_t size = 0; size < depth.size(); ++size) {
    ASSERT_FALSE(decode_depth(std::span(depth).first(size)).has_value()) << size;
  }
}

TEST(Codec, RefusesDamagedPixelsOfAPng) {
  const Bytes png = encode_png(gradient(40, 32));
  const Bytes data_chunk{'I', 'D', 'A', 'T'};
  const auto begin = std::search(png.begin(), png.end(), data_chunk.begin(), data_chunk.end());
  constexpr int kEndChunk = 12;
  for (auto i = begin - png.begin(); i < std::ssize(png) - kEndChunk; ++i) {
    Bytes damaged = png;
    damaged[static_cast<std::size_t>(i)] ^= 0x10;
    ASSERT_FALSE(decode_color(damaged).has_value()) << i;
  }
}

TEST(Codec, SurvivesRandomDamage) {
  const ColorImage color = gradient(40, 32);
  const Bytes progressive = make_jpeg(samples_of(color), 40, 32, 3, JCS_RGB,
                                      [](auto& codec) { jpeg_simple_progression(&codec); });
  RandomStream random(11);
  for (const Bytes& bytes :
       {encode_jpeg(color, 90), progressive, encode_png(color), encode_png(random_depth(20, 10))}) {
    for (int round = 0; round < 300; ++round) {
      Bytes damaged = bytes;
      for (std::uint64_t flips = 1 + random.index(8); flips > 0; --flips) {
        damaged[random.index(damaged.size())] = static_cast<std::uint8_t>(random.next());
      }
      // Whether it is refused depends on the damage; it must neither crash nor give no pixels.
      const auto color_image = decode_color(damaged);
      const auto depth_image = decode_depth(damaged);
      EXPECT_TRUE(!color_image || !color_image->empty());
      EXPECT_TRUE(!depth_image || !depth_image->empty());
    }
  }
}

// Some cameras leave stray bytes between a JPEG's segments; the picture is whole nevertheless.
TEST(Codec, ReadsAJpegWithStrayBytesButNotLostDataBehindThem) {
  const ColorImage color = gradient(64, 48);
  Bytes jpeg = encode_jpeg(color, 90);
  const Bytes tables{0xFF, 0xDB};
  const auto at = std::search(jpeg.begin(), jpeg.end(), tables.begin(), tables.end());
  ASSERT_NE(at, jpeg.end());
  jpeg.insert(at, {1, 2, 3});
  EXPECT_EQ(decode_color(jpeg).value(), decode_color(encode_jpeg(color, 90)).value());

  // Bytes after the end are none of the picture's business either.
  Bytes trailing = jpeg;
  trailing.insert(trailing.end(), {0, 0, 7});
  EXPECT_OK(decode_color(trailing));

  jpeg.resize(jpeg.size() - 40);
  EXPECT_ERROR(decode_color(jpeg), "is a truncated or damaged JPEG");
}

TEST(Codec, ReadsEveryRealPhoto) {
  for (const char* name : {"object_photos", "room_photos"}) {
    const auto photos = roomwise::testing::find_data(name);
    ROOMWISE_REQUIRE_FILE(photos);
    for (const auto& entry : std::filesystem::recursive_directory_iterator(*photos)) {
      if (!entry.is_regular_file()) continue;
      EXPECT_OK(read_color(entry.path()));
    }
  }
}

}  // namespace
}  // namespace roomwise::image
