#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "roomwise/base/file.h"

namespace roomwise::recording {

// Whether it begins as LZFSE's blocks do.
[[nodiscard]] bool is_lzfse(std::span<const std::uint8_t> packed);

// Decodes Apple's LZFSE: blocks of LZFSE (bvx1, bvx2), of LZVN (bvxn) and plain ones (bvx-), up to
// the block that ends them. Memory grows with what comes out, at most to `max_size`. Fails on
// damaged data, on data that is cut off, and where more than `max_size` bytes come out.
// Source of the format: https://github.com/lzfse/lzfse, the published reference.
[[nodiscard]] Expected<Bytes> decode_lzfse(std::span<const std::uint8_t> packed,
                                           std::size_t max_size);

}  // namespace roomwise::recording
