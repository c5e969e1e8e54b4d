#pragma once

#include <cstdlib>
#include <utility>

#include "roomwise/base/expected.h"

namespace roomwise {

// What the program's own data says: a test reads it, so that a fault in it is one of the program.
template <typename T>
[[nodiscard]] T own_data(Expected<T> parsed) {
  if (!parsed) std::abort();
  return *std::move(parsed);
}

}  // namespace roomwise
