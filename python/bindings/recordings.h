#pragma once

#include <memory>
#include <optional>

#include "python/bindings/arrays.h"
#include "roomwise/image/rgbd_frame.h"

namespace roomwise::python {

// A frame as Python holds it: its arrays show its pixels.
struct Frame {
  image::RgbdFrame frame;
  geometry::PinholeCamera camera;
};

// What users give as a camera: None, a Camera, the name of a preset, or the path of a camera.txt.
[[nodiscard]] std::optional<geometry::PinholeCamera> camera_of(const py::object& camera);

}  // namespace roomwise::python
