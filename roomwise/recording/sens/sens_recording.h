#pragma once

#include <memory>

#include "roomwise/recording/recording.h"

namespace roomwise::recording {

// A .sens file of ScanNet (Dai et al., "ScanNet: Richly-annotated 3D Reconstructions of Indoor
// Scenes", CVPR 2017), version 4: in one file cameras, poses, colour as JPEG or PNG and depth
// packed by zlib or not. Pictures have at most 640 px a side, larger ones are brought to that size,
// depth to them. Poses that are no numbers (tracking was lost) are left out. Source of the format:
// https://github.com/ScanNet/ScanNet, SensReader.
[[nodiscard]] bool is_sens_file(const std::filesystem::path& path);

// A file that was cut off gives the frames before, and a note. Fails where there is none, where the
// cameras are not registered to each other, and where the file is of another version or packing.
[[nodiscard]] Expected<std::unique_ptr<Recording>> open_sens_recording(
    const std::filesystem::path& path, const RecordingOptions& options);

}  // namespace roomwise::recording
