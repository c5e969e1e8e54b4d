#include "roomwise/image/decoders.h"

#include <webp/decode.h>

#include <cstring>

#include "roomwise/image/codec.h"

namespace roomwise::image {

bool is_webp(std::span<const std::uint8_t> bytes) {
  return bytes.size() >= 12 && std::memcmp(bytes.data(), "RIFF", 4) == 0 &&
         std::memcmp(bytes.data() + 8, "WEBP", 4) == 0;
}

Expected<ColorImage> decode_webp(std::span<const std::uint8_t> bytes, std::int64_t max_pixels) {
  const auto damaged = [] {
    return fail("is a truncated or damaged WebP; copy or take the picture again");
  };
  WebPBitstreamFeatures header{};
  if (WebPGetFeatures(bytes.data(), bytes.size(), &header) != VP8_STATUS_OK) return damaged();
  if (header.has_animation != 0) return fail("is an animated WebP; save one picture of it");
  if (std::int64_t{header.width} * header.height > max_pixels) {
    return fail("has {}x{} pixels, more than the {} that are read; make it smaller", header.width,
                header.height, max_pixels);
  }
  // Premultiplied by its alpha, a picture is itself over black.
  WebPDecoderConfig config;
  if (WebPInitDecoderConfig(&config) == 0) return fail("libwebp is of another version");
  Bytes rgba(4 * static_cast<std::size_t>(header.width) * static_cast<std::size_t>(header.height));
  config.output.colorspace = MODE_rgbA;
  config.output.is_external_memory = 1;
  config.output.u.RGBA = {rgba.data(), 4 * header.width, rgba.size()};
  if (WebPDecode(bytes.data(), bytes.size(), &config) != VP8_STATUS_OK) return damaged();
  ColorImage image(header.width, header.height);
  const std::uint8_t* from = rgba.data();
  for (Rgb8& to : image.pixels()) {
    to = {from[0], from[1], from[2]};
    from += 4;
  }
  return image;
}

}  // namespace roomwise::image
