#pragma once

#include <optional>

#include "command.h"
#include "roomwise/recording/camera_file.h"

namespace roomwise::app {

// Declares --camera. `otherwise`: which camera it is without.
inline CLI::Option* add_camera_option(CLI::App& command, std::string& camera,
                                      const std::string& otherwise) {
  return command.add_option("--camera", camera,
                            "Camera of the pictures: fr1, fr2, fr3, kinect-v1, xtion, or a "
                            "camera.txt; default: " +
                                otherwise);
}

// That of --camera, if it was given.
inline Expected<std::optional<geometry::PinholeCamera>> given_camera(const std::string& camera) {
  if (camera.empty()) return std::nullopt;
  return recording::resolve_camera(camera);
}

// Says to the user what is so unusual of a camera that it is likely a mistake, where anything is.
inline void warn_of_camera(const geometry::PinholeCamera& camera, Context& context) {
  if (const auto doubt = camera.doubt()) {
    context.progress.note(
        fmt::format("the camera of this recording may be wrong: {}; give the right one by --camera "
                    "where it is",
                    *doubt));
  }
}

}  // namespace roomwise::app
