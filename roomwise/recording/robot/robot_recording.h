#pragma once

#include <memory>

#include "roomwise/recording/recording.h"

// Recordings of robots and RealSense cameras in one file: messages with images, cameras and
// transforms (streams.h says which are taken). Depth that another camera measured is registered to
// colour; pictures have at most 640 px a side, larger ones are brought to that size. Time is that
// of the messages' headers, where they have one. Device poses are those of tf, else of odometry.
namespace roomwise::recording {

[[nodiscard]] bool is_mcap_file(const std::filesystem::path& path);
[[nodiscard]] bool is_ros1_bag_file(const std::filesystem::path& path);

// Fail where the file is damaged, and where no colour and depth images fit together. `options` may
// name another camera (working_camera.h).
[[nodiscard]] Expected<std::unique_ptr<Recording>> open_mcap_recording(
    const std::filesystem::path& path, const RecordingOptions& options);
[[nodiscard]] Expected<std::unique_ptr<Recording>> open_ros1_bag_recording(
    const std::filesystem::path& path, const RecordingOptions& options);

}  // namespace roomwise::recording
