#include "roomwise/image/codec.h"

#include "roomwise/base/in_context.h"
#include "roomwise/image/decoders.h"
#include "roomwise/image/metadata.h"

namespace roomwise::image {
namespace {

template <typename Decode>
auto read_decoded(const std::filesystem::path& path, Decode decode) -> decltype(decode(Bytes())) {
  ROOMWISE_TRY(const Bytes bytes, read_file(path));
  return in_context(path.string(), decode(bytes));
}

Expected<ColorImage> decode(std::span<const std::uint8_t> bytes, std::int64_t max_pixels,
                            bool by_exif) {
  if (bytes.empty()) return fail("is empty; expected a JPEG, PNG or WebP picture");
  if (is_jpeg(bytes)) return decode_jpeg(bytes, max_pixels, by_exif);
  if (is_png(bytes)) return decode_png_color(bytes, max_pixels);
  if (is_webp(bytes)) return decode_webp(bytes, max_pixels);
  return fail("is neither a JPEG nor a PNG nor a WebP picture; convert it to one of them");
}

}  // namespace

Expected<ColorImage> decode_color(std::span<const std::uint8_t> bytes, std::int64_t max_pixels) {
  return decode(bytes, max_pixels, true);
}

Expected<ColorImage> read_color_as_taken(const std::filesystem::path& path) {
  return read_decoded(path, [](const Bytes& bytes) { return decode(bytes, kMaxPixels, false); });
}

Expected<DepthImage> decode_depth(std::span<const std::uint8_t> bytes, std::int64_t max_pixels) {
  if (is_png(bytes)) return decode_png_depth(bytes, max_pixels);
  const char* found = bytes.empty() ? "empty" : is_jpeg(bytes) ? "a JPEG" : "not a PNG";
  return fail("is {}; a depth image must be a 16-bit greyscale PNG", found);
}

Expected<ColorImage> read_color(const std::filesystem::path& path) {
  return read_decoded(path, [](const Bytes& bytes) { return decode_color(bytes); });
}

Expected<DepthImage> read_depth(const std::filesystem::path& path) {
  return read_decoded(path, [](const Bytes& bytes) { return decode_depth(bytes); });
}

Expected<Photo> decode_photo(std::span<const std::uint8_t> bytes, std::int64_t max_pixels) {
  Photo photo;
  ROOMWISE_TRY(photo.color, decode_color(bytes, max_pixels));
  if (is_jpeg(bytes)) photo.lens = lens_of_jpeg(bytes);
  return photo;
}

Expected<Photo> read_photo(const std::filesystem::path& path) {
  return read_decoded(path, [](const Bytes& bytes) { return decode_photo(bytes); });
}

Bytes color_file(const RgbdFrame& frame) {
  auto bare = without_metadata(frame.encoded_color);
  return bare ? *std::move(bare) : encode_png(frame.color);
}

Bytes depth_file(const RgbdFrame& frame) {
  auto bare = without_metadata(frame.encoded_depth);
  return bare ? *std::move(bare) : encode_png(frame.depth);
}

}  // namespace roomwise::image
