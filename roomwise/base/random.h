#pragma once

#include <bit>
#include <cstdint>
#include <initializer_list>

namespace roomwise {

// A stream of random numbers (xoshiro256++ of Blackman and Vigna, seeded by SplitMix64) that is the
// same on every machine. Work that must not depend on what ran before it draws from a stream of its
// own, keyed by what it works on: RandomStream(seed, {frame_index, keyframe_id}).
class RandomStream {
 public:
  explicit RandomStream(std::uint64_t seed, std::initializer_list<std::uint64_t> key = {});

  std::uint64_t next() {
    const std::uint64_t result = std::rotl(state_[0] + state_[3], 23) + state_[0];
    const std::uint64_t shifted = state_[1] << 17;
    state_[2] ^= state_[0];
    state_[3] ^= state_[1];
    state_[1] ^= state_[2];
    state_[0] ^= state_[3];
    state_[2] ^= shifted;
    state_[3] = std::rotl(state_[3], 45);
    return result;
  }
  // Uniform in [0, 1).
  double uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }
  // Uniform in [low, high).
  double between(double low, double high) { return low + (high - low) * uniform(); }

  // Uniform in [0, count); count must be positive.
  std::uint64_t index(std::uint64_t count) {
    // Rejection of the last incomplete block keeps every index equally likely.
    const std::uint64_t limit = max() - max() % count;
    std::uint64_t value = next();
    while (value >= limit) value = next();
    return value % count;
  }
  // Standard normal.
  double normal();

  // For std::shuffle and the like.
  using result_type = std::uint64_t;
  static constexpr result_type min() { return 0; }
  static constexpr result_type max() { return ~result_type{0}; }
  result_type operator()() { return next(); }

 private:
  std::uint64_t state_[4];
};

}  // namespace roomwise
