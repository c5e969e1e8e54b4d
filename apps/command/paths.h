#pragma once

#include <filesystem>
#include <string>

// Files as users name them, and as they are named to users.
namespace roomwise::app {

// Where Debian's package sweethome3d-furniture puts its archives.
constexpr const char* kFurnitureFolder = "/usr/share/sweethome3d/furniture";

// The file itself, or the ground truth of a recording's folder.
[[nodiscard]] std::filesystem::path truth_file(const std::filesystem::path& truth);

// A path as it can be pasted into a shell.
[[nodiscard]] std::string shell_word(const std::filesystem::path& path);

}  // namespace roomwise::app
