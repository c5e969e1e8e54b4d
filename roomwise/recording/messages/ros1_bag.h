#pragma once

#include "roomwise/recording/messages/message_log.h"

namespace roomwise::recording {

// Whether the first bytes are those of a ROS 1 bag, version 2.0.
[[nodiscard]] bool is_ros1_bag(std::span<const std::uint8_t> first_bytes);

// Reads which messages a ROS 1 bag holds (http://wiki.ros.org/Bags/Format/2.0): chunks of LZ4,
// bzip2 or none. Chunks without a connection that is read are passed over. The index at the end is
// not needed; a file that was cut off by a crash is read up to there, and a note says so. Fails
// where the file is damaged elsewhere.
[[nodiscard]] Expected<MessageLog> read_ros1_bag(const std::filesystem::path& path);

}  // namespace roomwise::recording
