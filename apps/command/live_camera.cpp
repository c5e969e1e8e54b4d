#include "live_camera.h"

#include <optional>

#include "camera_option.h"
#include "roomwise/recording/openni2_source.h"
#include "roomwise/recording/v4l2/v4l2_source.h"

namespace roomwise::app {
namespace {

using Opened = Expected<std::unique_ptr<recording::FrameSource>>;

// "" of "v4l2", "/dev/video2" of "v4l2:/dev/video2"; nothing of another kind's.
std::optional<std::string> device_of(const std::string& source, const std::string& kind) {
  if (source == kind) return "";
  if (source.starts_with(kind + ":")) return source.substr(kind.size() + 1);
  return std::nullopt;
}

Opened open_openni2(const LiveCamera& chosen, const std::string& uri) {
  if (!chosen.calibration.empty()) {
    return fail(
        "--calibration is for v4l2; give --camera for openni2, which registers depth itself");
  }
  ROOMWISE_TRY(const auto camera, given_camera(chosen.camera));
  return recording::OpenNi2Source::open({.uri = uri, .camera = camera});
}

Opened open_v4l2(const LiveCamera& chosen, const std::string& devices) {
  if (!chosen.camera.empty()) {
    return fail("--camera is not for v4l2; give --calibration, which has both of its cameras");
  }
  if (chosen.calibration.empty()) {
    return fail(
        "v4l2 needs --calibration FILE: a video device does not tell its lenses nor its unit of "
        "depth (docs/recordings.md says what is in it). There is: {}",
        recording::describe_video_cameras());
  }
  recording::V4l2Options options;
  const std::size_t comma = devices.find(',');
  options.depth_device = devices.substr(0, comma);
  if (comma != std::string::npos) options.color_device = devices.substr(comma + 1);
  ROOMWISE_TRY(options.calibration, recording::read_rgbd_calibration(chosen.calibration));
  return recording::V4l2Source::open(options);
}

}  // namespace

bool is_live_camera(const std::string& source) {
  return device_of(source, "openni2").has_value() || device_of(source, "v4l2").has_value();
}

Opened open_live_camera(const LiveCamera& chosen) {
  if (const auto uri = device_of(chosen.source, "openni2")) return open_openni2(chosen, *uri);
  if (const auto devices = device_of(chosen.source, "v4l2")) return open_v4l2(chosen, *devices);
  return fail("'{}' is no camera; expected {}", chosen.source, kLiveCameras);
}

CLI::Option* add_calibration_option(CLI::App& command, std::filesystem::path& calibration) {
  return command.add_option("--calibration", calibration,
                            "Of a v4l2 camera: a text file with its colour and depth cameras and "
                            "how they stand to each other");
}

}  // namespace roomwise::app
