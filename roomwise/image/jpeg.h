#pragma once

#include <cstdint>
#include <span>

#include "roomwise/base/expected.h"
#include "roomwise/image/image.h"

// The JPEG half of codec.h (libjpeg-turbo); callers use codec.h.
namespace roomwise::image {

[[nodiscard]] Expected<ColorImage> decode_jpeg(std::span<const std::uint8_t> bytes,
                                               std::int64_t max_pixels);

}  // namespace roomwise::image
