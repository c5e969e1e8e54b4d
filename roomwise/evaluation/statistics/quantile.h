#pragma once

#include <string>
#include <vector>

namespace roomwise::evaluation {

// The value that `share` (0 to 1) of them do not exceed, interpolated between neighbours; 0 of
// none.
[[nodiscard]] double quantile(std::vector<double> values, double share);

// As tables say several runs of one thing: "0.0062 (0.0060 to 0.0063)", the value in the middle and
// the range, or the one value where all are the same. At least one value.
[[nodiscard]] std::string middle_and_range(std::vector<double> values, int decimals);

}  // namespace roomwise::evaluation
