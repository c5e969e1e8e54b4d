#pragma once

#include <vector>

#include "roomwise/live/live_home.h"
#include "roomwise/service/router.h"

namespace roomwise::live {

// The requests by which a home is begun with photos of its rooms (docs/protocol.md); `home` must
// outlive them.
[[nodiscard]] std::vector<service::Route> photo_routes(LiveHome& home);

}  // namespace roomwise::live
