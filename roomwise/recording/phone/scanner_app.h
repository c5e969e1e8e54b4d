#pragma once

#include <filesystem>
#include <memory>

#include "roomwise/recording/recording.h"

// What 3D Scanner App (Laan Labs) exports as "All Data": of each depth frame frame_00012.json
// (camera, pose, time) and depth_00012.png (16-bit, mm), of every few
// frame_00012.jpg. The number in the name is the index. Where the phone was by GPS is never read.
namespace roomwise::recording {

[[nodiscard]] bool is_scanner_app_export(const std::filesystem::path& folder);
// Fails, naming the file, where one is damaged, or a picture has no JSON.
[[nodiscard]] Expected<std::unique_ptr<Recording>> open_scanner_app_export(
    const std::filesystem::path& folder, const RecordingOptions& options);

}  // namespace roomwise::recording
