#pragma once

#include <vector>

#include "roomwise/live/live_home.h"
#include "roomwise/service/router.h"

namespace roomwise::live {

// The plan of the home, what helpers change of it, and taking that back (docs/protocol.md). `home`
// must outlive them.
[[nodiscard]] std::vector<service::Route> edit_routes(LiveHome& home);

}  // namespace roomwise::live
