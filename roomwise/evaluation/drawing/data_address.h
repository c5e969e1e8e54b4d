#pragma once

#include <span>
#include <string>
#include <string_view>

#include "roomwise/image/codec.h"

namespace roomwise::evaluation {

// A file as a data: address (RFC 2397, Base64), which makes a page hold its pictures itself.
// media_type: "image/jpeg".
[[nodiscard]] std::string data_address(std::string_view media_type,
                                       std::span<const std::uint8_t> bytes);

// quality: 1 to 100.
[[nodiscard]] std::string jpeg_address(const image::ColorImage& picture, int quality);

}  // namespace roomwise::evaluation
