#pragma once

#include "roomwise/base/timestamp.h"

// Times of the simulated clock. Only for tests.
namespace roomwise::guide {

constexpr TimestampNs kSecond = 1'000'000'000;
constexpr TimestampNs kNow = 5 * kSecond;
constexpr TimestampNs kTick = kSecond / 5;  // of who is led

}  // namespace roomwise::guide
