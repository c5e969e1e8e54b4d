#pragma once

#include <vector>

#include "roomwise/live/routes/home_route.h"

namespace roomwise::live {

// The requests by which a home is begun with photos of its rooms (docs/protocol.md).
[[nodiscard]] std::vector<HomeRoute> photo_routes();

}  // namespace roomwise::live
