#pragma once

#include <filesystem>
#include <string_view>

#include "roomwise/base/expected.h"

namespace roomwise::service {

// Writes a file that nobody but its owner can open (0600), not even for a moment, whole or not at
// all.
[[nodiscard]] Expected<void> write_private_file(const std::filesystem::path& path,
                                                std::string_view text);

}  // namespace roomwise::service
