#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "roomwise/base/file.h"

namespace roomwise::recording {

enum class Packing { kNone, kLz4, kZstd, kBz2, kZlib };

// The packing that a bag or an MCAP file names: "", "none", "lz4", "zstd", "bz2". Fails on others.
[[nodiscard]] Expected<Packing> packing_named(std::string_view name);

// Unpacks to exactly `size` bytes (LZ4 and Zstandard frames, bzip2 and zlib streams). Memory grows
// with what comes out, at most to `size`, so that a file that lies about it costs nothing. Fails
// where the data is damaged, or holds more or less.
[[nodiscard]] Expected<Bytes> unpack(Packing packing, std::span<const std::uint8_t> packed,
                                     std::uint64_t size);

}  // namespace roomwise::recording
