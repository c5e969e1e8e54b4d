#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <vector>

namespace roomwise {

// The value that stands at size / 2 when they are sorted by the projection. Needs a value; changes
// their order.
template <typename T, typename Projection = std::identity>
T median_of(std::vector<T>& values, Projection projection = {}) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle, {}, projection);
  return *middle;
}

}  // namespace roomwise
