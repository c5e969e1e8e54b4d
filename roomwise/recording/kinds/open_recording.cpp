#include "roomwise/recording/open_recording.h"

#include <algorithm>
#include <array>

#include "roomwise/recording/phone/folders.h"
#include "roomwise/recording/phone/record3d.h"
#include "roomwise/recording/phone/scanner_app.h"
#include "roomwise/recording/phone/stray_scanner.h"
#include "roomwise/recording/robot/robot_recording.h"
#include "roomwise/recording/sens/sens_recording.h"
#include "roomwise/recording/tum_recording.h"

namespace roomwise::recording {
namespace {

namespace fs = std::filesystem;

template <typename Kind>
Expected<std::unique_ptr<Recording>> open_as(const fs::path& path,
                                             const RecordingOptions& options) {
  return Kind::open(path, options);
}

constexpr std::array kKinds{
    RecordingKind{"TUM folder", "rgb.txt and depth.txt", &TumRecording::recognises,
                  &open_as<TumRecording>},
    RecordingKind{"3D Scanner App, All Data", "frame_00000.json and depth_00000.png",
                  &is_scanner_app_export, &open_scanner_app_export},
    RecordingKind{"Stray Scanner", "rgb.mp4 and odometry.csv", &is_stray_scanner_folder,
                  &open_stray_scanner_folder},
    RecordingKind{"Polycam, raw data", "keyframes/cameras", &is_polycam_folder,
                  &open_polycam_folder},
    RecordingKind{"ARKitScenes", "lowres_depth and lowres_wide_intrinsics", &is_arkitscenes_folder,
                  &open_arkitscenes_folder},
    RecordingKind{"7-Scenes", "frame-000000.color.png (or .jpg) and .depth.png",
                  &is_seven_scenes_folder, &open_seven_scenes_folder},
    RecordingKind{"MCAP", "the first bytes of an .mcap file", &is_mcap_file, &open_mcap_recording},
    RecordingKind{"ROS 1 bag, RealSense", "the first bytes of a .bag file", &is_ros1_bag_file,
                  &open_ros1_bag_recording},
    RecordingKind{"ScanNet .sens", "the head of the file", &is_sens_file, &open_sens_recording},
    RecordingKind{"Record3D .r3d", "a zip with metadata and rgbd/0.jpg", &is_record3d_file,
                  &open_record3d},
    RecordingKind{"Record3D, EXR and JPG", "metadata.json, rgb/0.jpg and depth",
                  &is_record3d_exr_folder, &open_record3d_exr_folder},
};

std::string what_is_read() {
  std::string kinds;
  for (const RecordingKind& kind : kKinds) {
    kinds += fmt::format("{}{} ({})", kinds.empty() ? "" : ", ", kind.name, kind.told_by);
  }
  return kinds;
}

}  // namespace

std::span<const RecordingKind> recording_kinds() {
  return kKinds;
}

const RecordingKind* find_recording_kind(const fs::path& path) {
  const auto kind =
      std::ranges::find_if(kKinds, [&](const RecordingKind& one) { return one.recognises(path); });
  return kind == kKinds.end() ? nullptr : &*kind;
}

Expected<std::unique_ptr<Recording>> open_recording(const fs::path& path,
                                                    const RecordingOptions& options) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  std::error_code error;
  if (!fs::exists(path, error)) {
    return fail("{}: there is no such file or folder", path.string());
  }
  const RecordingKind* kind = find_recording_kind(path);
  if (kind == nullptr) {
    return fail("{}: is no recording of a kind that is read; these are: {}", path.string(),
                what_is_read());
  }
  return kind->open(path, options);
}

Expected<Trajectory> read_truth(const fs::path& path) {
  std::error_code error;
  const fs::path file = path / "groundtruth.txt";
  if (fs::exists(file, error)) return read_trajectory(file);
  if (fs::is_regular_file(path, error) && find_recording_kind(path) == nullptr) {
    return read_trajectory(path);
  }
  ROOMWISE_TRY(const auto recording, open_recording(path));
  if (recording->device_poses().empty()) {
    return fail("{}: has no groundtruth.txt, and its device wrote no poses; give a trajectory",
                path.string());
  }
  return recording->device_poses();
}

}  // namespace roomwise::recording
