#pragma once

#include <vector>

namespace roomwise::evaluation {

// The value that `share` (0 to 1) of them do not exceed, interpolated between neighbours; 0 of
// none.
[[nodiscard]] double quantile(std::vector<double> values, double share);

}  // namespace roomwise::evaluation
