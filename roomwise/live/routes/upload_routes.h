#pragma once

#include <vector>

#include "roomwise/live/routes/home_route.h"

namespace roomwise::live {

// The requests by which a recording is handed in as a file (docs/protocol.md).
[[nodiscard]] std::vector<HomeRoute> upload_routes();

}  // namespace roomwise::live
