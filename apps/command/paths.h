#pragma once

#include <filesystem>
#include <string>

// Files as users name them, and as they are named to users.
namespace roomwise::app {

// Where Debian's package sweethome3d-furniture puts its archives.
constexpr const char* kFurnitureFolder = "/usr/share/sweethome3d/furniture";

// A path as it can be pasted into a shell.
[[nodiscard]] std::string shell_word(const std::filesystem::path& path);

}  // namespace roomwise::app
