#pragma once

#include <algorithm>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "roomwise/base/expected.h"
#include "roomwise/pipeline/run_context.h"

namespace roomwise::pipeline {

// Works through `count` items without holding all of them: read(i), which may fail, in their order;
// make(i, what was read), which may fail, on the pool's threads; then take(i, what was made), which
// may fail, in their order again. Fails as the first of these does, and when the user interrupts.
template <typename Read, typename Make, typename Take>
[[nodiscard]] Expected<void> in_blocks(std::size_t count, std::string_view work, RunContext& run,
                                       const Read& read, const Make& make, const Take& take) {
  using Item = typename std::invoke_result_t<Read, std::size_t>::value_type;
  using Made = std::invoke_result_t<Make, std::size_t, const Item&>;
  run.progress.begin(work, count);
  const std::size_t block = 2 * run.pool.size();
  for (std::size_t first = 0; first < count; first += block) {
    ROOMWISE_RETURN_IF_ERROR(run.progress.check(work));
    const std::size_t size = std::min(block, count - first);
    std::vector<Item> items;
    for (std::size_t i = 0; i < size; ++i) {
      ROOMWISE_TRY(Item item, read(first + i));
      items.push_back(std::move(item));
    }
    std::vector<Made> made(size, fail("not made yet"));
    run.pool.parallel_for(size, [&](std::size_t i) { made[i] = make(first + i, items[i]); });
    for (std::size_t i = 0; i < size; ++i) {
      if (!made[i]) return Unexpected(std::move(made[i]).error());
      ROOMWISE_RETURN_IF_ERROR(take(first + i, *std::move(made[i])));
    }
    run.progress.advance(first + size, "");
  }
  run.progress.end();
  return {};
}

}  // namespace roomwise::pipeline
