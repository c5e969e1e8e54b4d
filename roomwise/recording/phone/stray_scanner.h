#pragma once

#include <filesystem>
#include <memory>

#include "roomwise/recording/recording.h"

// What Stray Scanner writes: rgb.mp4, odometry.csv (a line a frame: time, number, pose, and in
// newer ones the camera), camera_matrix.csv, depth/000012.png (16-bit, mm). The n-th line belongs
// to the n-th picture of the video, whose own times are not used. The index is the number.
namespace roomwise::recording {

[[nodiscard]] bool is_stray_scanner_folder(const std::filesystem::path& folder);
// A line that is damaged counts as a damaged frame. Lines beyond the end of the video, and a last
// one that was cut off, are no frames.
[[nodiscard]] Expected<std::unique_ptr<Recording>> open_stray_scanner_folder(
    const std::filesystem::path& folder, const RecordingOptions& options);

}  // namespace roomwise::recording
