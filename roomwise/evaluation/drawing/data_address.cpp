#include "roomwise/evaluation/drawing/data_address.h"

#include <fmt/format.h>

#include "roomwise/base/encodings.h"

namespace roomwise::evaluation {

std::string data_address(std::string_view media_type, std::span<const std::uint8_t> bytes) {
  return fmt::format("data:{};base64,{}", media_type, base64(bytes));
}

std::string jpeg_address(const image::ColorImage& picture, int quality) {
  return data_address("image/jpeg", image::encode_jpeg(picture, quality));
}

}  // namespace roomwise::evaluation
