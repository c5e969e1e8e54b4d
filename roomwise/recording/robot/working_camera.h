#pragma once

#include <optional>

#include "roomwise/base/expected.h"
#include "roomwise/geometry/pinhole_camera.h"

namespace roomwise::recording {

// The camera of pictures as they were recorded, and as they are given: with at most 640 px a side.
struct WorkingCamera {
  geometry::PinholeCamera recorded, working;

  [[nodiscard]] bool is_recorded_size() const { return recorded == working; }
};

// `given` replaces the camera, but not its unit of depth; it is of the recorded or of the working
// size (a home keeps the latter). Fails where it is of another one.
[[nodiscard]] Expected<WorkingCamera> working_camera(
    const geometry::PinholeCamera& recorded, const std::optional<geometry::PinholeCamera>& given);

}  // namespace roomwise::recording
