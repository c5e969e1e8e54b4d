#pragma once

#include <cstdint>
#include <span>

#include "roomwise/base/expected.h"
#include "roomwise/image/exif.h"
#include "roomwise/image/image.h"

// The decoders that codec.h chooses from: libjpeg-turbo, libpng and libwebp; callers use codec.h.
namespace roomwise::image {

// `by_exif`: turned as its Exif says.
[[nodiscard]] Expected<ColorImage> decode_jpeg(std::span<const std::uint8_t> bytes,
                                               std::int64_t max_pixels, bool by_exif);
// What its Exif says of the lens.
[[nodiscard]] std::optional<ExifLens> lens_of_jpeg(std::span<const std::uint8_t> bytes);
[[nodiscard]] Expected<ColorImage> decode_png_color(std::span<const std::uint8_t> bytes,
                                                    std::int64_t max_pixels);
[[nodiscard]] Expected<DepthImage> decode_png_depth(std::span<const std::uint8_t> bytes,
                                                    std::int64_t max_pixels);
[[nodiscard]] Expected<ColorImage> decode_webp(std::span<const std::uint8_t> bytes,
                                               std::int64_t max_pixels);

}  // namespace roomwise::image
