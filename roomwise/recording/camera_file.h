#pragma once

#include <filesystem>
#include <string>

#include "roomwise/base/expected.h"
#include "roomwise/geometry/pinhole_camera.h"

namespace roomwise::recording {

// camera.txt: one line "fx fy cx cy width height depth_units_per_metre", focal lengths and
// principal point in px, optionally followed by the lens distortion "k1 k2 p1 p2 k3"; '#' begins a
// comment. Fails, naming the line and the value, where one is missing, not a number or impossible.
[[nodiscard]] Expected<geometry::PinholeCamera> read_camera(const std::filesystem::path& path);
[[nodiscard]] Expected<void> write_camera(const std::filesystem::path& path,
                                          const geometry::PinholeCamera& camera);

// What a user gives as --camera: the name of a preset (geometry::camera_preset) or a camera.txt.
[[nodiscard]] Expected<geometry::PinholeCamera> resolve_camera(const std::string& preset_or_file);

}  // namespace roomwise::recording
