#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace roomwise {

// The indices of at most `max_count` of `count` things, evenly spread over them from the first on.
[[nodiscard]] inline std::vector<std::size_t> spread_evenly(std::size_t count,
                                                            std::size_t max_count) {
  std::vector<std::size_t> chosen(std::min(count, max_count));
  for (std::size_t i = 0; i < chosen.size(); ++i) chosen[i] = i * count / chosen.size();
  return chosen;
}

// The things themselves.
template <typename T>
[[nodiscard]] std::vector<T> spread_evenly(const std::vector<T>& all, std::size_t max_count) {
  std::vector<T> chosen;
  for (const std::size_t i : spread_evenly(all.size(), max_count)) chosen.push_back(all[i]);
  return chosen;
}

}  // namespace roomwise
