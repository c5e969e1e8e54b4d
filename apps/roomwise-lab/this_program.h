#pragma once

#include <filesystem>
#include <string>

#include "roomwise/base/expected.h"

namespace roomwise::app {

[[nodiscard]] Expected<std::filesystem::path> this_program();

// The release, and the bytes of this program, of roomwise beside it and of the networks that are
// installed: others may measure something else.
[[nodiscard]] Expected<std::string> version_of_programs();

}  // namespace roomwise::app
