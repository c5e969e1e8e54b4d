#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "roomwise/base/expected.h"

namespace roomwise {

// Time stamps are integer nanoseconds since the recording's epoch (names end in _ns).
using TimestampNs = std::int64_t;

constexpr double kSecondsPerNs = 1e-9;
[[nodiscard]] constexpr double seconds_between(TimestampNs from, TimestampNs to) {
  return static_cast<double>(to - from) * kSecondsPerNs;
}

// Reads seconds with any number of decimals ("1305031229.528748", "-0.5"), exactly to the
// nanosecond. Fails on anything else, NaN, infinity and what does not fit (about +-292 years).
[[nodiscard]] Expected<TimestampNs> parse_timestamp(std::string_view seconds);

// Seconds with six decimals, as the TUM files have them; nine where the nanoseconds need them.
[[nodiscard]] std::string format_timestamp(TimestampNs timestamp_ns);

}  // namespace roomwise
