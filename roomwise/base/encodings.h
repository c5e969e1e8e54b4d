#pragma once

#include <cstdint>
#include <span>
#include <string>

// Bytes as text.
namespace roomwise {

[[nodiscard]] std::string hexadecimal(std::span<const std::uint8_t> bytes);  // in small letters
[[nodiscard]] std::string base64(std::span<const std::uint8_t> bytes);       // RFC 4648
// The same for addresses: with - and _, without the signs that fill it up.
[[nodiscard]] std::string base64url(std::span<const std::uint8_t> bytes);

}  // namespace roomwise
