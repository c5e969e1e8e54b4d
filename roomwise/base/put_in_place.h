#pragma once

#include <filesystem>

#include "roomwise/base/expected.h"

namespace roomwise {

// Gives a file or folder its name, for good even if the power goes. Fails where something has that
// name, also if it came just now.
[[nodiscard]] Expected<void> put_in_place(const std::filesystem::path& from,
                                          const std::filesystem::path& to);

}  // namespace roomwise
