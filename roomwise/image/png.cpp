#include "roomwise/image/decoders.h"

#include <png.h>

#include <array>
#include <bit>
#include <cstring>
#include <stdexcept>

#include "roomwise/image/codec.h"

namespace roomwise::image {
namespace {

using Reason = std::array<char, 160>;

// libpng reports a failure by a jump, which must not pass over a C++ destructor. So each call into
// it is made by a member function that sets the jump's target itself, owns nothing but numbers and
// pointers, and returns false after a jump.
[[noreturn]] void on_error(png_structp png, png_const_charp message) {
  Reason& reason = *static_cast<Reason*>(png_get_error_ptr(png));
  std::strncpy(reason.data(), message, reason.size() - 1);
  png_longjmp(png, 1);
}

void on_warning(png_structp, png_const_charp) {}

class PngReader {
 public:
  explicit PngReader(std::span<const std::uint8_t> bytes)
      : left_(bytes),
        png_(png_create_read_struct(PNG_LIBPNG_VER_STRING, &reason_, on_error, on_warning)),
        info_(png_ ? png_create_info_struct(png_) : nullptr) {
    if (info_ == nullptr) {
      png_destroy_read_struct(&png_, nullptr, nullptr);
      throw std::bad_alloc();
    }
  }
  ~PngReader() { png_destroy_read_struct(&png_, &info_, nullptr); }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;

  // Reads everything before the pixels.
  [[nodiscard]] bool open() {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_set_read_fn(png_, this, read_bytes);
    // All chunks but the picture's own (header, palette, transparency, pixels) are passed over, not
    // kept: texts and profiles could be packed to a thousandth of their size.
    png_set_keep_unknown_chunks(png_, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
    png_read_info(png_, info_);
    return true;
  }

  // Decodes all rows as 8-bit RGBA, 4 bytes a pixel.
  [[nodiscard]] bool read_rgba(std::uint8_t* pixels) {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_set_expand(png_);  // palette, 1 to 4 bits, transparent colours
    png_set_scale_16(png_);
    png_set_gray_to_rgb(png_);
    png_set_add_alpha(png_, 0xFF, PNG_FILLER_AFTER);
    return read_rows(pixels, 4);
  }

  // Decodes all rows of a 16-bit greyscale picture in the machine's byte order.
  [[nodiscard]] bool read_gray16(std::uint16_t* pixels) {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    if constexpr (std::endian::native == std::endian::little) png_set_swap(png_);
    return read_rows(reinterpret_cast<std::uint8_t*>(pixels), 2);
  }

  [[nodiscard]] const char* reason() const { return reason_.data(); }
  [[nodiscard]] std::int64_t width() const { return png_get_image_width(png_, info_); }
  [[nodiscard]] std::int64_t height() const { return png_get_image_height(png_, info_); }
  [[nodiscard]] int bit_depth() const { return png_get_bit_depth(png_, info_); }
  [[nodiscard]] int color_type() const { return png_get_color_type(png_, info_); }

 private:
  static void read_bytes(png_structp png, png_bytep out, std::size_t size) {
    auto& left = static_cast<PngReader*>(png_get_io_ptr(png))->left_;
    if (size > left.size()) png_error(png, "the file ends too early");
    std::memcpy(out, left.data(), size);
    left = left.subspan(size);
  }

  // Reached only under a jump target. An interlaced picture comes in several passes over the rows.
  [[nodiscard]] bool read_rows(std::uint8_t* pixels, std::size_t bytes_per_pixel) {
    const int passes = png_set_interlace_handling(png_);
    png_read_update_info(png_, info_);
    const std::size_t row_size = static_cast<std::size_t>(width()) * bytes_per_pixel;
    if (png_get_rowbytes(png_, info_) != row_size) png_error(png_, "rows of an unexpected size");
    const auto rows = static_cast<std::size_t>(height());
    for (int pass = 0; pass < passes; ++pass) {
      for (std::size_t y = 0; y < rows; ++y) {
        png_read_row(png_, pixels + y * row_size, nullptr);
      }
    }
    png_read_end(png_, nullptr);  // sees whether the end is there
    return true;
  }

  Reason reason_{};
  std::span<const std::uint8_t> left_;  // to be read
  png_structp png_;
  png_infop info_;
};

class PngWriter {
 public:
  PngWriter()
      : png_(png_create_write_struct(PNG_LIBPNG_VER_STRING, &reason_, on_error, on_warning)),
        info_(png_ ? png_create_info_struct(png_) : nullptr) {
    if (info_ == nullptr) {
      png_destroy_write_struct(&png_, nullptr);
      throw std::bad_alloc();
    }
  }
  ~PngWriter() { png_destroy_write_struct(&png_, &info_); }
  PngWriter(const PngWriter&) = delete;
  PngWriter& operator=(const PngWriter&) = delete;

  // filters: PNG_FILTER_..., compression: zlib's 0 to 9.
  [[nodiscard]] bool write(const std::uint8_t* pixels, int width, int height, int color_type,
                           int bit_depth, int filters, int compression) {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_set_write_fn(png_, &bytes_, append_bytes, nullptr);
    png_set_filter(png_, PNG_FILTER_TYPE_BASE, filters);
    png_set_compression_level(png_, compression);
    png_set_IHDR(png_, info_, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height),
                 bit_depth, color_type, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    png_write_info(png_, info_);
    if constexpr (std::endian::native == std::endian::little) {
      if (bit_depth == 16) png_set_swap(png_);
    }
    const std::size_t row_size = png_get_rowbytes(png_, info_);
    for (std::size_t y = 0; y < static_cast<std::size_t>(height); ++y) {
      png_write_row(png_, pixels + y * row_size);
    }
    png_write_end(png_, nullptr);
    return true;
  }

  template <typename Pixel>
  [[nodiscard]] static Bytes encode(const Image<Pixel>& image, int color_type, int bit_depth,
                                    int filters, int compression) {
    if (image.empty()) throw std::invalid_argument("encode_png: empty image");
    PngWriter writer;
    if (!writer.write(reinterpret_cast<const std::uint8_t*>(image.pixels().data()), image.width(),
                      image.height(), color_type, bit_depth, filters, compression)) {
      throw std::runtime_error(writer.reason_.data());
    }
    return std::move(writer.bytes_);
  }

 private:
  static void append_bytes(png_structp png, png_bytep data, std::size_t size) {
    auto& bytes = *static_cast<Bytes*>(png_get_io_ptr(png));
    bytes.insert(bytes.end(), data, data + size);
  }

  Reason reason_{};
  Bytes bytes_;
  png_structp png_;
  png_infop info_;
};

Unexpected damaged(const PngReader& reader) {
  return fail("is a truncated or damaged PNG ({}); copy or take the picture again",
              reader.reason());
}

// Reads the header and refuses a picture too large to be one.
Expected<void> open(PngReader& reader, std::int64_t max_pixels) {
  if (!reader.open()) return damaged(reader);
  if (reader.width() * reader.height() > max_pixels) {
    return fail("has {}x{} pixels, more than the {} that are read; make it smaller", reader.width(),
                reader.height(), max_pixels);
  }
  return {};
}

// "an 8-bit RGB picture"
std::string describe(const PngReader& reader) {
  const char* article = reader.bit_depth() == 8 ? "an" : "a";
  const char* colors = [&] {
    switch (reader.color_type()) {
      case PNG_COLOR_TYPE_GRAY:
        return "greyscale";
      case PNG_COLOR_TYPE_GRAY_ALPHA:
        return "greyscale and alpha";
      case PNG_COLOR_TYPE_PALETTE:
        return "palette";
      case PNG_COLOR_TYPE_RGB_ALPHA:
        return "RGB and alpha";
      default:
        return "RGB";
    }
  }();
  return fmt::format("{} {}-bit {} picture", article, reader.bit_depth(), colors);
}

// A part of `value`, alpha of 255, rounded.
std::uint8_t blend_over_black(std::uint8_t value, std::uint8_t alpha) {
  return static_cast<std::uint8_t>((value * alpha + 127) / 255);
}

}  // namespace

bool is_png(std::span<const std::uint8_t> bytes) {
  constexpr std::size_t kSignature = 8;
  return bytes.size() >= kSignature && png_sig_cmp(bytes.data(), 0, kSignature) == 0;
}

Expected<ColorImage> decode_png_color(std::span<const std::uint8_t> bytes,
                                      std::int64_t max_pixels) {
  PngReader reader(bytes);
  ROOMWISE_RETURN_IF_ERROR(open(reader, max_pixels));
  ColorImage image(static_cast<int>(reader.width()), static_cast<int>(reader.height()));
  Bytes rgba(image.pixels().size() * 4);
  if (!reader.read_rgba(rgba.data())) return damaged(reader);
  const std::uint8_t* from = rgba.data();
  for (Rgb8& to : image.pixels()) {
    const std::uint8_t alpha = from[3];
    to = {blend_over_black(from[0], alpha), blend_over_black(from[1], alpha),
          blend_over_black(from[2], alpha)};
    from += 4;
  }
  return image;
}

Expected<DepthImage> decode_png_depth(std::span<const std::uint8_t> bytes,
                                      std::int64_t max_pixels) {
  PngReader reader(bytes);
  ROOMWISE_RETURN_IF_ERROR(open(reader, max_pixels));
  if (reader.color_type() != PNG_COLOR_TYPE_GRAY || reader.bit_depth() != 16) {
    return fail("is {}; a depth image must be a 16-bit greyscale PNG", describe(reader));
  }
  DepthImage image(static_cast<int>(reader.width()), static_cast<int>(reader.height()));
  if (!reader.read_gray16(image.pixels().data())) return damaged(reader);
  return image;
}

Bytes encode_png(const ColorImage& image) {
  return PngWriter::encode(image, PNG_COLOR_TYPE_RGB, 8, PNG_ALL_FILTERS, 6);
}

Bytes encode_png(const DepthImage& image) {
  // Fast enough for a live camera: on 640x480 Kinect images 5 CPU-ms and 116 kB, where libpng's
  // defaults (all filters, level 6) take 28 CPU-ms for 92 kB.
  return PngWriter::encode(image, PNG_COLOR_TYPE_GRAY, 16, PNG_FILTER_NONE, 1);
}

Bytes encode_smooth_png(const DepthImage& image) {
  // A phone's 256x192 brought to 640x480: 4.8 CPU-ms and 134 kB, where encode_png() takes 8.3 and
  // 280 kB.
  return PngWriter::encode(image, PNG_COLOR_TYPE_GRAY, 16, PNG_FILTER_UP, 1);
}

}  // namespace roomwise::image
