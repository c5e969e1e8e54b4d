#pragma once

#include <filesystem>

#include "roomwise/base/expected.h"
#include "roomwise/fusion/floor_grid.h"

namespace roomwise::fusion {

// Writes a grid as the map_server of ROS reads it (http://wiki.ros.org/map_server): YAML at
// `yaml_path`, and beside it a picture of the same name that ends in .pgm, one pixel a cell, y up:
// white is free, black occupied, grey unknown. `origin` in the YAML is the grid's in the level
// frame. Each file is whole or unchanged; the picture is written first.
[[nodiscard]] Expected<void> write_floor_map(const std::filesystem::path& yaml_path,
                                             const FloorGrid& grid);

// Where the picture lies.
[[nodiscard]] std::filesystem::path floor_map_picture(const std::filesystem::path& yaml_path);

}  // namespace roomwise::fusion
