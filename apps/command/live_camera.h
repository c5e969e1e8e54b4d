#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "command.h"
#include "roomwise/recording/frame_source.h"

namespace roomwise::app {

// Which live camera a user names, and what is known of its lenses.
struct LiveCamera {
  // openni2, openni2:URI, v4l2, v4l2:DEPTH-DEVICE or v4l2:DEPTH-DEVICE,COLOUR-DEVICE.
  std::string source;
  std::string camera;                 // --camera; for OpenNI 2; empty: what the camera says
  std::filesystem::path calibration;  // --calibration; for V4L2, which needs it
};

// What `source` may be, for --help.
inline constexpr const char* kLiveCameras =
    "openni2 (the first camera found), openni2:URI (one camera, or an .oni file), v4l2 (the first "
    "video device with depth, such as RealSense's), v4l2:/dev/videoN (that one) or "
    "v4l2:/dev/videoN,/dev/videoM (and its colour)";

// Whether it is one of these, and not a recording.
[[nodiscard]] bool is_live_camera(const std::string& source);
// Fails where it is none, where what is known of its lenses is of the wrong kind, and where the
// camera cannot be opened.
[[nodiscard]] Expected<std::unique_ptr<recording::FrameSource>> open_live_camera(
    const LiveCamera& chosen);

// Declares --calibration.
CLI::Option* add_calibration_option(CLI::App& command, std::filesystem::path& calibration);

}  // namespace roomwise::app
