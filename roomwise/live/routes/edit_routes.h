#pragma once

#include <vector>

#include "roomwise/live/routes/home_route.h"

namespace roomwise::live {

// The plan of the home, what helpers change of it, and taking that back (docs/protocol.md).
[[nodiscard]] std::vector<HomeRoute> edit_routes();

}  // namespace roomwise::live
