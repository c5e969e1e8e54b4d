#pragma once

// Files as users name them, and as they are named to users.
namespace roomwise::app {

// Where Debian's package sweethome3d-furniture puts its archives.
constexpr const char* kFurnitureFolder = "/usr/share/sweethome3d/furniture";

}  // namespace roomwise::app
