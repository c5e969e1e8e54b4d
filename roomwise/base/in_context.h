#pragma once

#include <string_view>
#include <utility>

#include "roomwise/base/expected.h"

namespace roomwise {

// The outcome, whose error, if it is one, says where it was seen: "CONTEXT: message". For
//   ROOMWISE_TRY(const auto image, in_context(path.string(), decode(bytes)));
template <typename T>
[[nodiscard]] Expected<T> in_context(std::string_view context, Expected<T> outcome) {
  if (!outcome) return Unexpected(std::move(outcome).error().with_context(context));
  return outcome;
}

}  // namespace roomwise
