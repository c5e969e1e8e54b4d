#pragma once

#include <vector>

#include "roomwise/live/live_home.h"
#include "roomwise/service/router.h"

namespace roomwise::live {

// The requests of docs/protocol.md that see and change the home. `home` must outlive them.
[[nodiscard]] std::vector<service::Route> home_routes(LiveHome& home);

}  // namespace roomwise::live
