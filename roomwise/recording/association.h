#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "roomwise/base/timestamp.h"

namespace roomwise::recording {

// Two measurements taken at nearly the same time, by their places in their lists.
struct Association {
  std::size_t first = 0;
  std::size_t second = 0;

  friend bool operator==(const Association&, const Association&) = default;
};

// Pairs the entries of two lists of time stamps (each strictly increasing) as the `associate` tool
// of the TUM RGB-D benchmark does: of all pairs less than `tolerance_ns` apart the closest is taken
// first, and each entry serves once. Equally close pairs are taken in the order of `first`, then of
// `second`. Returns the pairs in the order of `first`. O(n log n), whatever the tolerance.
[[nodiscard]] std::vector<Association> associate(std::span<const TimestampNs> first,
                                                 std::span<const TimestampNs> second,
                                                 TimestampNs tolerance_ns);

}  // namespace roomwise::recording
