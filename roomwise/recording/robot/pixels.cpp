#include "roomwise/recording/robot/pixels.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "roomwise/base/byte_reader.h"
#include "roomwise/image/codec.h"

namespace roomwise::recording {
namespace {

using image::ColorImage;
using image::DepthImage;
using Row = std::span<const std::uint8_t>;

constexpr std::size_t kConfigBytes = 12;  // of compressedDepth, in front of its picture
constexpr double kMillimetres = 1000;
constexpr double kMaxDepth = 65535;
constexpr std::uint64_t kMaxRvlPixels = std::uint64_t{1} << 24;  // ten times what cameras have

// How the pixels of an encoding lie in a row.
struct Layout {
  std::string_view name;
  PixelKind kind;
  std::size_t bytes;               // of a pixel
  std::array<std::size_t, 3> rgb;  // where red, green and blue are; luma, first and second chroma
};

constexpr std::array kLayouts{
    Layout{"rgb8", PixelKind::kColor, 3, {0, 1, 2}},
    Layout{"bgr8", PixelKind::kColor, 3, {2, 1, 0}},
    Layout{"8UC3", PixelKind::kColor, 3, {2, 1, 0}},
    Layout{"rgba8", PixelKind::kColor, 4, {0, 1, 2}},
    Layout{"bgra8", PixelKind::kColor, 4, {2, 1, 0}},
    Layout{"8UC4", PixelKind::kColor, 4, {2, 1, 0}},
    Layout{"mono8", PixelKind::kGray, 1, {0, 0, 0}}, Layout{"8UC1", PixelKind::kGray, 1, {0, 0, 0}},
    Layout{"16UC1", PixelKind::kDepth, 2, {}}, Layout{"mono16", PixelKind::kDepth, 2, {}},
    Layout{"32FC1", PixelKind::kDepth, 4, {}},
    // Two bytes a pixel: every second one has the first chroma, the others the second.
    Layout{"yuv422", PixelKind::kColor, 2, {1, 0, 2}},
    Layout{"UYVY", PixelKind::kColor, 2, {1, 0, 2}},
    Layout{"yuv422_yuy2", PixelKind::kColor, 2, {0, 1, 3}},
    Layout{"YUYV", PixelKind::kColor, 2, {0, 1, 3}}};

const Layout* layout_of(std::string_view pixels) {
  const auto found = std::ranges::find(kLayouts, pixels, &Layout::name);
  return found == kLayouts.end() ? nullptr : &*found;
}

Expected<void> check_size(const ImageMessage& image, const Layout& layout) {
  const std::uint64_t pixels = std::uint64_t{image.width} * image.height;
  if (pixels == 0 || pixels > static_cast<std::uint64_t>(image::kMaxPixels)) {
    return fail("its picture claims {}x{} pixels", image.width, image.height);
  }
  const std::uint64_t row = std::uint64_t{image.width} * layout.bytes;
  const std::uint64_t needed = std::uint64_t{image.step} * (image.height - 1) + row;
  if (image.step < row || image.data.size() < needed) {
    return fail("its picture of {}x{} pixels ({}) has {} bytes, {} a row", image.width,
                image.height, image.pixels, image.data.size(), image.step);
  }
  return {};
}

Unexpected unknown_pixels(std::string_view pixels, std::string_view expected) {
  return fail("its pixels are '{}', which are not read; record {}", pixels, expected);
}

std::uint8_t to_byte(double value) {
  return static_cast<std::uint8_t>(std::clamp(std::lround(value), 0L, 255L));
}

// BT.601 with the range 16 to 235.
Rgb8 from_luma(int luma, int first_chroma, int second_chroma) {
  const double y = 1.164 * (luma - 16);
  const double u = first_chroma - 128, v = second_chroma - 128;
  return {to_byte(y + 1.596 * v), to_byte(y - 0.392 * u - 0.813 * v), to_byte(y + 2.017 * u)};
}

void read_luma_row(Row row, const Layout& layout, std::span<Rgb8> pixels) {
  for (std::size_t x = 0; x < pixels.size(); ++x) {
    // The last pixel of an odd row has its neighbour's second chroma.
    const std::size_t pair = std::min(x & ~std::size_t{1}, (pixels.size() & ~std::size_t{1}) - 2);
    pixels[x] = from_luma(row[2 * x + layout.rgb[0]], row[2 * pair + layout.rgb[1]],
                          row[2 * pair + layout.rgb[2]]);
  }
}

void read_color_row(Row row, const Layout& layout, std::span<Rgb8> pixels) {
  const auto [r, g, b] = layout.rgb;
  for (std::size_t x = 0; x < pixels.size(); ++x) {
    const std::uint8_t* pixel = row.data() + x * layout.bytes;
    pixels[x] = {pixel[r], pixel[g], pixel[b]};
  }
}

std::uint16_t to_millimetres(double depth_m) {
  const double depth = std::round(depth_m * kMillimetres);
  return depth >= 1 && depth <= kMaxDepth ? static_cast<std::uint16_t>(depth) : std::uint16_t{0};
}

void read_depth_row(Row row, const ImageMessage& image, std::span<std::uint16_t> pixels) {
  const auto order = image.is_big_endian ? std::endian::big : std::endian::little;
  const bool is_float = image.pixels == "32FC1";
  for (std::size_t x = 0; x < pixels.size(); ++x) {
    pixels[x] = is_float ? to_millimetres(load<float>(row.data() + 4 * x, order))
                         : load<std::uint16_t>(row.data() + 2 * x, order);
  }
}

Row row_of(const ImageMessage& image, const Layout& layout, int y) {
  return Row(image.data)
      .subspan(static_cast<std::size_t>(y) * image.step, image.width * layout.bytes);
}

bool is_compressed_depth(const CompressedImageMessage& image) {
  return image.format.find("compressedDepth") != std::string::npos;
}

// Sixteen bits of grey a pixel, by the head of the file.
bool is_depth_png(Row bytes) {
  constexpr std::size_t kBits = 24, kColorType = 25;
  return image::is_png(bytes) && bytes.size() > kColorType && bytes[kBits] == 16 &&
         bytes[kColorType] == 0;
}

// RVL (A. Wilson, "Fast Lossless Depth Image Compression", ISS 2017): runs of zeros and of
// differences to the last depth, as numbers of three bits a nibble, eight nibbles a word.
class RvlReader {
 public:
  explicit RvlReader(Row bytes) : reader_(bytes) {}
  [[nodiscard]] bool ok() const { return reader_.ok(); }
  std::uint32_t number() {
    std::uint32_t value = 0;
    for (unsigned shift = 0; shift < 32; shift += 3) {
      const std::uint32_t nibble = next_nibble();
      value |= (nibble & 7U) << shift;
      if ((nibble & 8U) == 0 || !ok()) break;
    }
    return value;
  }

 private:
  std::uint32_t next_nibble() {
    if (left_ == 0) {
      word_ = reader_.number<std::uint32_t>();
      left_ = 8;
    }
    const std::uint32_t nibble = word_ >> 28U;
    word_ <<= 4U;
    --left_;
    return nibble;
  }
  ByteReader reader_;
  std::uint32_t word_ = 0;
  int left_ = 0;
};

Expected<DepthImage> decode_rvl(Row bytes) {
  ByteReader head(bytes);
  const auto width = head.number<std::uint32_t>();
  const auto height = head.number<std::uint32_t>();
  const std::uint64_t count = std::uint64_t{width} * height;
  // A few bytes can say that millions of pixels are zero.
  if (!head.ok() || count == 0 || count > kMaxRvlPixels) {
    return fail("its RVL picture claims {}x{} pixels", width, height);
  }
  RvlReader reader(bytes.subspan(8));
  DepthImage depth(static_cast<int>(width), static_cast<int>(height));
  std::uint32_t last = 0;
  for (std::uint64_t i = 0; i < count && reader.ok();) {
    i += reader.number();
    for (std::uint32_t run = reader.number(); run > 0 && reader.ok(); --run, ++i) {
      const std::uint32_t difference = reader.number();
      last += (difference >> 1U) ^ (0U - (difference & 1U));
      if (i >= count) return fail("its RVL picture has more pixels than it claims");
      depth.pixels()[i] = static_cast<std::uint16_t>(last);
    }
  }
  if (!reader.ok()) return fail("its RVL picture is cut off");
  return depth;
}

// 32FC1 is stored as a / depth + b, rounded.
void invert_depth(const CompressedImageMessage& image, DepthImage& depth) {
  const double a = load<float>(image.data.data() + 4);
  const double b = load<float>(image.data.data() + 8);
  for (std::uint16_t& pixel : depth.pixels()) {
    pixel = pixel == 0 ? std::uint16_t{0} : to_millimetres(a / (pixel - b));
  }
}

}  // namespace

PixelKind pixel_kind(const ImageMessage& image) {
  const Layout* layout = layout_of(image.pixels);
  return layout == nullptr ? PixelKind::kOther : layout->kind;
}

PixelKind pixel_kind(const CompressedImageMessage& image) {
  if (is_compressed_depth(image) || is_depth_png(image.data)) return PixelKind::kDepth;
  const bool is_picture =
      image::is_jpeg(image.data) || image::is_png(image.data) || image::is_webp(image.data);
  if (!is_picture) return PixelKind::kOther;
  return image.format.starts_with("mono8") || image.format.starts_with("8UC1") ? PixelKind::kGray
                                                                               : PixelKind::kColor;
}

Expected<ColorImage> color_of(const ImageMessage& image) {
  const Layout* layout = layout_of(image.pixels);
  if (layout == nullptr || layout->kind == PixelKind::kDepth) {
    return unknown_pixels(image.pixels, "rgb8 or bgr8");
  }
  ROOMWISE_RETURN_IF_ERROR(check_size(image, *layout));
  const bool is_luma = layout->bytes == 2;
  if (is_luma && image.width < 2) return unknown_pixels(image.pixels, "pictures that are wider");
  ColorImage color(static_cast<int>(image.width), static_cast<int>(image.height));
  for (int y = 0; y < color.height(); ++y) {
    const Row row = row_of(image, *layout, y);
    is_luma ? read_luma_row(row, *layout, color.row(y))
            : read_color_row(row, *layout, color.row(y));
  }
  return color;
}

Expected<ColorImage> color_of(const CompressedImageMessage& image) {
  return image::decode_color(image.data);
}

Expected<DepthImage> depth_of(const ImageMessage& image) {
  const Layout* layout = layout_of(image.pixels);
  if (layout == nullptr || layout->kind != PixelKind::kDepth) {
    return unknown_pixels(image.pixels, "16UC1 or 32FC1");
  }
  ROOMWISE_RETURN_IF_ERROR(check_size(image, *layout));
  DepthImage depth(static_cast<int>(image.width), static_cast<int>(image.height));
  for (int y = 0; y < depth.height(); ++y) {
    read_depth_row(row_of(image, *layout, y), image, depth.row(y));
  }
  return depth;
}

std::span<const std::uint8_t> depth_png_of(const CompressedImageMessage& image) {
  if (!is_compressed_depth(image)) return image.data;
  const bool is_as_it_is = image.format.starts_with("16UC1") || image.format.starts_with("mono16");
  if (!is_as_it_is || image.data.size() < kConfigBytes) return {};
  const Row png = Row(image.data).subspan(kConfigBytes);
  return is_depth_png(png) ? png : Row();
}

Expected<DepthImage> depth_of(const CompressedImageMessage& image) {
  if (const Row png = depth_png_of(image); !png.empty()) return image::decode_depth(png);
  if (image.data.size() <= kConfigBytes) return fail("its depth has {} bytes", image.data.size());
  const bool is_rvl = image.format.ends_with("rvl");
  const bool is_inverse = image.format.starts_with("32FC1");
  if (!is_rvl && !is_inverse) {
    return fail("its depth is of the format '{}', which is not read; record 16UC1 as PNG",
                image.format);
  }
  const Row picture = Row(image.data).subspan(kConfigBytes);
  ROOMWISE_TRY(DepthImage depth, is_rvl ? decode_rvl(picture) : image::decode_depth(picture));
  if (is_inverse) invert_depth(image, depth);
  return depth;
}

}  // namespace roomwise::recording
