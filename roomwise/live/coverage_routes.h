#pragma once

#include <vector>

#include "roomwise/live/live_home.h"
#include "roomwise/service/router.h"

namespace roomwise::live {

// What the walks have not shown yet, as docs/protocol.md has it. `home` must outlive them.
[[nodiscard]] std::vector<service::Route> coverage_routes(LiveHome& home);

}  // namespace roomwise::live
