#pragma once

#include <filesystem>

#include "roomwise/base/expected.h"

namespace roomwise::service {

// Makes the folder where it is missing, readable by its owner alone. Fails where it is there and
// others may read it, or it is somebody else's.
[[nodiscard]] Expected<void> make_private_folder(const std::filesystem::path& folder);

}  // namespace roomwise::service
