#pragma once

#include <span>
#include <vector>

#include "roomwise/evaluation/errors/object_error.h"
#include "roomwise/objects/instances/instances.h"

namespace roomwise::trials {

// What a plain clustering makes of a detector's boxes: a yardstick with nothing to tune, beside
// what find_instances() and the paper's rules make of the same pictures. A box stands at the median
// of its surface. Boxes of one class, the best first, join the nearest thing whose mean lies within
// 0.35 m; a thing counts where four key-frames or more show it and one scored 0.5 or more. Places
// are in the key-frames' world, m.
[[nodiscard]] std::vector<evaluation::FoundObject> naive_objects(
    std::span<const objects::ObservedKeyframe> keyframes);

}  // namespace roomwise::trials
