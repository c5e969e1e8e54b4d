#pragma once

#include <vector>

#include "roomwise/live/live_home.h"
#include "roomwise/service/router.h"

namespace roomwise::live {

// The requests by which a recording is handed in as a file (docs/protocol.md); `home` must outlive
// them.
[[nodiscard]] std::vector<service::Route> upload_routes(LiveHome& home);

}  // namespace roomwise::live
