#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace roomwise::network {

// A piece of memory that is needed from step `first` to step `last`.
struct Buffer {
  std::size_t bytes = 0;
  std::size_t first = 0;
  std::size_t last = 0;
};

struct MemoryPlan {
  std::vector<std::size_t> offsets;  // a buffer each, multiples of 64
  std::size_t bytes = 0;             // of all together
};

// Lays buffers into one piece of memory so that those that are needed at the same time do not
// overlap: the largest first, each at the lowest place that is free as long as it is needed.
[[nodiscard]] MemoryPlan plan_memory(std::span<const Buffer> buffers);

}  // namespace roomwise::network
