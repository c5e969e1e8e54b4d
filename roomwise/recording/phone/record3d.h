#pragma once

#include <memory>

#include "roomwise/recording/recording.h"

namespace roomwise::recording {

// What Record3D (iOS) shares as .r3d: a zip with "metadata" (JSON: sizes, cameras, poses, times),
// rgbd/0.jpg, rgbd/0.depth (LZFSE, float32, m) and, of LiDARs, rgbd/0.conf (LZFSE, 0 to 2). Depth
// of confidence 0 is left out. Each frame has a camera of its own; frames are as if one camera had
// taken them all (one_camera.h), with at most 640 px a side; depth is in mm.
[[nodiscard]] bool is_record3d_file(const std::filesystem::path& path);
// Fails, naming the file within, where the metadata is damaged, and where `options` ask for another
// camera. A frame of which the metadata says nothing that can be counts as damaged.
[[nodiscard]] Expected<std::unique_ptr<Recording>> open_record3d(const std::filesystem::path& path,
                                                                 const RecordingOptions& options);

// The same recording exported as "EXR + JPG", a folder with metadata.json, rgb/0.jpg and
// depth/0.exr (metres as 16- or 32-bit floats, without confidence), or one that holds EXR_RGBD.
[[nodiscard]] bool is_record3d_exr_folder(const std::filesystem::path& folder);
[[nodiscard]] Expected<std::unique_ptr<Recording>> open_record3d_exr_folder(
    const std::filesystem::path& folder, const RecordingOptions& options);

}  // namespace roomwise::recording
