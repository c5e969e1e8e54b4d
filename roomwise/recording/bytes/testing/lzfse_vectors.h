#pragma once

#include <string_view>

#include "roomwise/base/file.h"

namespace roomwise::recording::testing {

// Packed by Apple's published encoder: walls(4200) of lzfse_test.cpp as one block of LZFSE (bvx2),
// walls(400) as one of LZVN, walls(5) as a plain one, and nothing.
constexpr std::string_view kLzfseBlock =
    "6276783268100000bc00d0040031007040ca79cb79560070a600000024c8b00307af00b2810d142c0814de010000"
    "38e743380100d6e27d801300801700b8e69a1316000000000000009fe5bab939bcb959373737eb70dd1cde70c35a"
    "8b9bb5d6e2909bc5ba81b5b861ddc062b1586b010b586b018b050b160b58002c0016000000000000000000000000"
    "000000000000000000000000000000000000000000000000000000003f1eefdf3d08a48fa287141feda09759cec8"
    "1e8cc86206dfd1e196971aebf1767d8fb90dbf5c99ce4d41286fcd2f3ed709957aee8e9e4d98935b0be5458792f9"
    "a0132ea9e09e5832560fcb01780000000000000000000053000611f0ac503c06047a5d1cf49bb5518035511bcb01"
    "60a0f52a1f604524013cd8f61a4c8840592c9c350cadaf64c0ac61804903560f185532f06af887c8aa902001cc6b"
    "1019865901f99862767824";
constexpr std::string_view kLzvnBlock =
    "6276786e9001000025000000680100f0e7400401460246034604460598010600381cf056e4010000000600000000"
    "00000062767824";
constexpr std::string_view kPlainBlock = "6276782d05000000000000000062767824";
constexpr std::string_view kNoBlock = "6276782d0000000062767824";

inline Bytes from_hex(std::string_view hex) {
  const auto digit = [](char c) { return c <= '9' ? c - '0' : c - 'a' + 10; };
  Bytes bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
    bytes.push_back(static_cast<std::uint8_t>(16 * digit(hex[i]) + digit(hex[i + 1])));
  }
  return bytes;
}

}  // namespace roomwise::recording::testing
