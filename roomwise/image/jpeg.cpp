#include "roomwise/image/decoders.h"

// jpeglib.h needs the first two, and jerror.h numbers its messages by what jpeglib.h defines.
#include <cstddef>
#include <cstdio>

#include <jpeglib.h>

#include <jerror.h>

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstdlib>
#include <stdexcept>

#include "roomwise/image/codec.h"
#include "roomwise/image/exif.h"

namespace roomwise::image {
namespace {

// libjpeg reports a failure by a jump, which must not pass over a C++ destructor. So each call into
// it is made by a member function that sets the jump's target itself, owns nothing but numbers and
// pointers, and returns false after a jump. libjpeg's plain API is used rather than TurboJPEG's
// because only here each warning is seen: TurboJPEG keeps the text of the first one, behind which
// lost data could hide.
class JumpTarget {
 public:
  JumpTarget() {
    jpeg_std_error(&errors_.manager);
    errors_.manager.error_exit = jump;
    errors_.manager.emit_message = on_message;
    errors_.owner = this;
  }
  JumpTarget(const JumpTarget&) = delete;
  JumpTarget& operator=(const JumpTarget&) = delete;

  // What went wrong, in libjpeg's words.
  [[nodiscard]] const char* reason() const { return reason_.data(); }

 protected:
  jpeg_error_mgr* errors() { return &errors_.manager; }
  // Gives up for a reason that is not libjpeg's.
  [[noreturn]] void give_up(std::string_view reason) {
    reason.copy(reason_.data(), reason_.size() - 1);
    std::longjmp(target_, 1);
  }

  std::jmp_buf target_;

 private:
  [[noreturn]] static void jump(j_common_ptr codec) {
    // libjpeg hands back the address of its error manager; the owner stands behind it.
    JumpTarget& self = *reinterpret_cast<Errors*>(codec->err)->owner;
    codec->err->format_message(codec, self.reason_.data());
    std::longjmp(self.target_, 1);
  }

  // Warnings (level below 0) after which libjpeg makes up pixels are failures; the others, such as
  // stray bytes between segments, are common in photos and change nothing.
  static void on_message(j_common_ptr codec, int level) {
    constexpr std::array<int, 5> kLostData{JWRN_JPEG_EOF, JWRN_HIT_MARKER, JWRN_HUFF_BAD_CODE,
                                           JWRN_ARITH_BAD_CODE, JWRN_MUST_RESYNC};
    if (level < 0 && std::ranges::find(kLostData, codec->err->msg_code) != kLostData.end()) {
      jump(codec);
    }
  }

  struct Errors {
    jpeg_error_mgr manager{};
    JumpTarget* owner = nullptr;
  };
  Errors errors_;
  std::array<char, JMSG_LENGTH_MAX> reason_{};
};

// A progressive picture comes in scans, usually some ten. Each is decoded over the whole picture,
// so that a small file of very many would take minutes.
constexpr int kMaxScans = 64;

class JpegReader : public JumpTarget {
 public:
  JpegReader() {
    progress_.manager.progress_monitor = count_scans;
    progress_.owner = this;
  }
  ~JpegReader() { jpeg_destroy_decompress(&codec_); }

  // Reads everything before the pixels.
  [[nodiscard]] bool open(const std::uint8_t* bytes, std::size_t size) {
    codec_.err = errors();
    if (setjmp(target_) != 0) return false;
    jpeg_create_decompress(&codec_);
    codec_.progress = &progress_.manager;
    jpeg_mem_src(&codec_, bytes, static_cast<unsigned long>(size));
    jpeg_save_markers(&codec_, JPEG_APP0 + 1, 0xFFFF);
    jpeg_read_header(&codec_, TRUE);
    return true;
  }

  // Decodes all rows as RGB into the picture, which has the size of the JPEG.
  [[nodiscard]] bool read(Rgb8* pixels) {
    if (setjmp(target_) != 0) return false;
    codec_.out_color_space = JCS_RGB;
    jpeg_start_decompress(&codec_);
    while (codec_.output_scanline < codec_.output_height) {
      static_assert(sizeof(Rgb8) == 3);
      JSAMPROW row = reinterpret_cast<JSAMPROW>(
          pixels + static_cast<std::size_t>(codec_.output_scanline) * codec_.output_width);
      jpeg_read_scanlines(&codec_, &row, 1);
    }
    jpeg_finish_decompress(&codec_);  // sees whether the end is there
    return true;
  }

  [[nodiscard]] const jpeg_decompress_struct& header() const { return codec_; }

  [[nodiscard]] std::optional<ExifLens> lens() const {
    for (const jpeg_marker_struct* marker = codec_.marker_list; marker; marker = marker->next) {
      if (auto lens = exif_lens({marker->data, marker->data_length})) return lens;
    }
    return std::nullopt;
  }

  [[nodiscard]] int orientation() const {
    for (const jpeg_marker_struct* marker = codec_.marker_list; marker; marker = marker->next) {
      const int orientation = exif_orientation({marker->data, marker->data_length});
      if (orientation != kUpright) return orientation;
    }
    return kUpright;
  }

 private:
  static void count_scans(j_common_ptr codec) {
    JpegReader& self = *reinterpret_cast<ScanCounter*>(codec->progress)->owner;
    if (self.codec_.input_scan_number > kMaxScans) self.give_up("more than 64 scans");
  }

  struct ScanCounter {
    jpeg_progress_mgr manager{};
    JpegReader* owner = nullptr;
  };
  ScanCounter progress_;
  jpeg_decompress_struct codec_{};
};

class JpegWriter : public JumpTarget {
 public:
  ~JpegWriter() {
    jpeg_destroy_compress(&codec_);
    std::free(bytes_);
  }

  [[nodiscard]] bool write(const Rgb8* pixels, int width, int height, int quality) {
    codec_.err = errors();
    if (setjmp(target_) != 0) return false;
    jpeg_create_compress(&codec_);
    jpeg_mem_dest(&codec_, &bytes_, &size_);
    codec_.image_width = static_cast<JDIMENSION>(width);
    codec_.image_height = static_cast<JDIMENSION>(height);
    codec_.input_components = 3;
    codec_.in_color_space = JCS_RGB;
    jpeg_set_defaults(&codec_);
    jpeg_set_quality(&codec_, quality, TRUE);
    jpeg_start_compress(&codec_, TRUE);
    while (codec_.next_scanline < codec_.image_height) {
      // libjpeg does not write to the rows but takes them as not const.
      JSAMPROW row = reinterpret_cast<JSAMPROW>(const_cast<Rgb8*>(
          pixels + static_cast<std::size_t>(codec_.next_scanline) * codec_.image_width));
      jpeg_write_scanlines(&codec_, &row, 1);
    }
    jpeg_finish_compress(&codec_);
    return true;
  }

  [[nodiscard]] std::span<const std::uint8_t> bytes() const { return {bytes_, size_}; }

 private:
  jpeg_compress_struct codec_{};
  unsigned char* bytes_ = nullptr;
  unsigned long size_ = 0;
};

}  // namespace

bool is_jpeg(std::span<const std::uint8_t> bytes) {
  return bytes.size() >= 3 && bytes[0] == 0xFF && bytes[1] == 0xD8 && bytes[2] == 0xFF;
}

Expected<ColorImage> decode_jpeg(std::span<const std::uint8_t> bytes, std::int64_t max_pixels,
                                 bool by_exif) {
  JpegReader reader;
  const auto damaged = [&] {
    return fail("is a truncated or damaged JPEG ({}); copy or take the picture again",
                reader.reason());
  };
  if (!reader.open(bytes.data(), bytes.size())) return damaged();
  const auto& header = reader.header();
  if (header.jpeg_color_space == JCS_CMYK || header.jpeg_color_space == JCS_YCCK) {
    return fail("is a CMYK JPEG, made for printing; save it as an RGB picture");
  }
  if (std::int64_t{header.image_width} * std::int64_t{header.image_height} > max_pixels) {
    return fail("has {}x{} pixels, more than the {} that are read; make it smaller",
                header.image_width, header.image_height, max_pixels);
  }
  ColorImage image(static_cast<int>(header.image_width), static_cast<int>(header.image_height));
  const int orientation = reader.orientation();  // libjpeg forgets it with the last row
  if (!reader.read(image.pixels().data())) return damaged();
  return by_exif ? apply_orientation(std::move(image), orientation) : std::move(image);
}

std::optional<ExifLens> lens_of_jpeg(std::span<const std::uint8_t> bytes) {
  JpegReader reader;
  return reader.open(bytes.data(), bytes.size()) ? reader.lens() : std::nullopt;
}

Bytes encode_jpeg(const ColorImage& image, int quality) {
  if (image.empty() || image.width() > JPEG_MAX_DIMENSION || image.height() > JPEG_MAX_DIMENSION) {
    throw std::invalid_argument("encode_jpeg: no such size in a JPEG");
  }
  if (quality < 1 || quality > 100) throw std::invalid_argument("encode_jpeg: quality");
  JpegWriter writer;
  if (!writer.write(image.pixels().data(), image.width(), image.height(), quality)) {
    throw std::runtime_error(writer.reason());
  }
  return {writer.bytes().begin(), writer.bytes().end()};
}

}  // namespace roomwise::image
