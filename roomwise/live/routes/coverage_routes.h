#pragma once

#include <vector>

#include "roomwise/live/routes/home_route.h"

namespace roomwise::live {

// What the walks have not shown yet, as docs/protocol.md has it.
[[nodiscard]] std::vector<HomeRoute> coverage_routes();

}  // namespace roomwise::live
