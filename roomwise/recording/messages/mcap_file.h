#pragma once

#include "roomwise/recording/messages/message_log.h"

namespace roomwise::recording {

// Whether the first bytes are those of MCAP.
[[nodiscard]] bool is_mcap(std::span<const std::uint8_t> first_bytes);

// Reads which messages an MCAP file holds (https://mcap.dev/spec, version 0): chunks of LZ4,
// Zstandard or none, messages outside of chunks. Where there is an index at the end, chunks without
// a channel that is read are passed over; where there is none, or the file was cut off by a crash,
// all records up to there are read, and a note says so. Fails where the file is damaged elsewhere,
// a chunk's CRC-32 among it.
[[nodiscard]] Expected<MessageLog> read_mcap(const std::filesystem::path& path);

}  // namespace roomwise::recording
