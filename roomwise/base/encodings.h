#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

// Bytes as text, and text that is none.
namespace roomwise {

[[nodiscard]] std::string hexadecimal(std::span<const std::uint8_t> bytes);  // in small letters
[[nodiscard]] std::string base64(std::span<const std::uint8_t> bytes);       // RFC 4648
// The same for addresses: with - and _, without the signs that fill it up.
[[nodiscard]] std::string base64url(std::span<const std::uint8_t> bytes);

// Whether it is one line of UTF-8: no broken character, no control character.
[[nodiscard]] bool is_plain_text(std::string_view text);

}  // namespace roomwise
