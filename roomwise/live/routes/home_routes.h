#pragma once

#include <vector>

#include "roomwise/live/routes/home_route.h"

namespace roomwise::live {

// The requests of docs/protocol.md that see and change a home.
[[nodiscard]] std::vector<HomeRoute> home_routes();
// Those of a home that is open, which must outlive them.
[[nodiscard]] std::vector<service::Route> home_routes(LiveHome& home);

}  // namespace roomwise::live
