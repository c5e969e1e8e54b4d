#pragma once

#include <vector>

#include "roomwise/live/routes/home_route.h"

namespace roomwise::live {

// A helper tries a question as the person would ask it, as docs/protocol.md has it.
[[nodiscard]] std::vector<HomeRoute> trial_routes();

}  // namespace roomwise::live
