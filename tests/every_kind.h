#pragma once

#include <filesystem>
#include <string>

#include "roomwise/base/expected.h"

namespace roomwise::testing {

// Writes a made-up recording (write_made_up_recording) once more, below `folder`, as devices of a
// kind of recording::recording_kinds() write theirs, told by the kind's name. Where it lies.
[[nodiscard]] Expected<std::filesystem::path> write_as_kind(std::string_view kind,
                                                            const std::filesystem::path& walk,
                                                            const std::filesystem::path& folder);

}  // namespace roomwise::testing
