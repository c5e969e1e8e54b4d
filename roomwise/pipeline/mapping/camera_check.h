#pragma once

#include <optional>

#include "roomwise/mapping/frontend/mapper.h"
#include "roomwise/motion/focal_length_fit.h"
#include "roomwise/pipeline/run_context.h"

namespace roomwise::pipeline {

// Which focal length the pictures of a walk fit, by key-frames of it, those from `first` on, that
// lie one, two and four apart; at most 120 pairs, spread evenly. `camera` is the one that measured
// them. Nothing where they do not tell. Fails where key-frames cannot be read, and when the user
// interrupts.
[[nodiscard]] Expected<std::optional<motion::FocalLengthFit>> check_focal_length(
    mapping::Mapper& mapper, mapping::KeyframeId first, const geometry::PinholeCamera& camera,
    std::uint64_t seed, RunContext& run);

}  // namespace roomwise::pipeline
