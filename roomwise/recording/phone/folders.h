#pragma once

#include <filesystem>
#include <memory>

#include "roomwise/recording/recording.h"

// Folders of pictures that other apps and collections write; made after their documentation and
// source. A picture whose camera or pose is damaged or not there counts as damaged.
namespace roomwise::recording {

// Polycam's raw data: keyframes/{images,cameras,depth}/MICROSECONDS, or corrected_images and
// corrected_cameras, which it makes itself of shorter captures, where both are there. The index is
// the place in the order of time.
[[nodiscard]] bool is_polycam_folder(const std::filesystem::path& folder);
[[nodiscard]] Expected<std::unique_ptr<Recording>> open_polycam_folder(
    const std::filesystem::path& folder, const RecordingOptions& options);

// ARKitScenes (Baruch et al., "ARKitScenes", NeurIPS 2021): lowres_wide or vga_wide with their
// _intrinsics (.pincam), lowres_depth, lowres_wide.traj; files are named by scene and time. The
// index is the place in the order of time. A picture's depth is that of its own time.
[[nodiscard]] bool is_arkitscenes_folder(const std::filesystem::path& folder);
[[nodiscard]] Expected<std::unique_ptr<Recording>> open_arkitscenes_folder(
    const std::filesystem::path& folder, const RecordingOptions& options);

// 7-Scenes (Shotton et al., "Scene Coordinate Regression Forests", CVPR 2013):
// frame-000012.color.png, .depth.png and .pose.txt. The index is the number; there are no times, so
// 30 frames a second are taken. Its colour and depth cameras are those that go with it in the
// literature, 525 and 585 px; that they lie some 2 cm apart is not known to the data.
[[nodiscard]] bool is_seven_scenes_folder(const std::filesystem::path& folder);
[[nodiscard]] Expected<std::unique_ptr<Recording>> open_seven_scenes_folder(
    const std::filesystem::path& folder, const RecordingOptions& options);

}  // namespace roomwise::recording
