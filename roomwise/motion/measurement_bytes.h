#pragma once

#include <cstddef>
#include <span>

#include "roomwise/base/file.h"
#include "roomwise/motion/frame_measurements.h"

namespace roomwise::motion {

// How much memory the measurements take, but for the objects themselves. Finds the features.
[[nodiscard]] std::size_t memory_bytes(const FrameMeasurements& measurements);

// Measurements as plain bytes and back, to the bit: for this program alone, which wrote them. Finds
// the features.
[[nodiscard]] Bytes to_bytes(const FrameMeasurements& measurements);
// Fails where the bytes are not what to_bytes() gave.
[[nodiscard]] Expected<FrameMeasurements> measurements_from_bytes(
    std::span<const std::uint8_t> bytes);

}  // namespace roomwise::motion
