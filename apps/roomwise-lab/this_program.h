#pragma once

#include <filesystem>
#include <string>

#include "laboratory/studies/known_digests.h"
#include "roomwise/base/expected.h"

namespace roomwise::app {

[[nodiscard]] Expected<std::filesystem::path> this_program();

// The release, and the bytes of this program, of roomwise beside it and of the networks that are
// installed: others may measure something else. `known`: what is known of these files, and is then
// known of them all.
[[nodiscard]] Expected<std::string> version_of_programs(studies::KnownDigests& known);

}  // namespace roomwise::app
