#pragma once

#include <filesystem>
#include <vector>

#include "roomwise/base/expected.h"

namespace roomwise::image {

// Whether it ends as photos do that people keep in folders: .jpg, .jpeg or .png, in any case.
[[nodiscard]] bool has_ending_of_picture(const std::filesystem::path& file);

// The files that end so, in the folder and those within it, by path; may be none. Fails where a
// folder cannot be read.
[[nodiscard]] Expected<std::vector<std::filesystem::path>> picture_files(
    const std::filesystem::path& folder);

}  // namespace roomwise::image
