#pragma once

#include <filesystem>
#include <memory>

#include "roomwise/recording/recording.h"

// What 3D Scanner App (Laan Labs) exports as "All Data": of each depth frame frame_00012.json
// (camera, pose, time) and depth_00012.png (16-bit, mm), of every few
// frame_00012.jpg. The number in the name is the index. Of where the phone was by GPS it is only
// seen that it is there.
namespace roomwise::recording {

[[nodiscard]] bool is_scanner_app_export(const std::filesystem::path& folder);
// A picture whose JSON is damaged or not there counts as damaged.
[[nodiscard]] Expected<std::unique_ptr<Recording>> open_scanner_app_export(
    const std::filesystem::path& folder, const RecordingOptions& options);

}  // namespace roomwise::recording
