#pragma once

#include <filesystem>
#include <string>

namespace roomwise {

// A path as it can be pasted into a shell.
[[nodiscard]] std::string shell_word(const std::filesystem::path& path);

}  // namespace roomwise
