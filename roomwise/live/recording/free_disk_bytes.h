#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>

#include "roomwise/base/expected.h"

namespace roomwise::live {

// How many bytes are free where a file lies, which need not be there yet.
[[nodiscard]] Expected<std::uint64_t> free_bytes_at(const std::filesystem::path& path);
using FreeBytesQuery = std::function<Expected<std::uint64_t>(const std::filesystem::path&)>;

}  // namespace roomwise::live
