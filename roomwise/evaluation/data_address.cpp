#include "roomwise/evaluation/data_address.h"

#include <fmt/format.h>
#include <openssl/evp.h>

namespace roomwise::evaluation {

std::string data_address(std::string_view media_type, std::span<const std::uint8_t> bytes) {
  std::string base64((bytes.size() + 2) / 3 * 4 + 1, '\0');  // OpenSSL ends it with a zero
  EVP_EncodeBlock(reinterpret_cast<unsigned char*>(base64.data()), bytes.data(),
                  static_cast<int>(bytes.size()));
  base64.pop_back();
  return fmt::format("data:{};base64,{}", media_type, base64);
}

std::string jpeg_address(const image::ColorImage& picture, int quality) {
  return data_address("image/jpeg", image::encode_jpeg(picture, quality));
}

}  // namespace roomwise::evaluation
