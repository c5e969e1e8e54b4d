#pragma once

#include <filesystem>
#include <functional>

#include "roomwise/base/expected.h"

namespace roomwise::pipeline {

// Fails where something of that name is there, or its parent is not: to be asked before long work.
[[nodiscard]] Expected<void> check_new_folder(const std::filesystem::path& folder);

// Makes a folder whole or not at all: fill() is given one beside it, which gets the name when it is
// full. What fill() left is removed where it fails.
[[nodiscard]] Expected<void> make_new_folder(
    const std::filesystem::path& folder,
    const std::function<Expected<void>(const std::filesystem::path&)>& fill);

}  // namespace roomwise::pipeline
