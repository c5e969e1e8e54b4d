#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "roomwise/base/expected.h"
#include "roomwise/image/image.h"

namespace roomwise::recording {

[[nodiscard]] bool is_exr(std::span<const std::uint8_t> bytes);

// Decodes one channel of an OpenEXR file: the only one, or R or Z of several. Files as apps write
// depth are read: one part of scan lines, 16- and 32-bit floats, not packed or packed by ZIP or
// ZIPS. Fails where the file is of another kind, is damaged or cut off, or has more than
// `max_pixels`, before memory for them is taken.
// Source of the format: https://openexr.com/en/latest/OpenEXRFileLayout.html
[[nodiscard]] Expected<image::Image<float>> decode_exr(std::span<const std::uint8_t> bytes,
                                                       std::int64_t max_pixels);

}  // namespace roomwise::recording
