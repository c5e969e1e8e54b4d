#pragma once

#include <cstdint>
#include <initializer_list>

namespace roomwise {

// A stream of random numbers (xoshiro256++ of Blackman and Vigna, seeded by SplitMix64) that is the
// same on every machine. Work that must not depend on what ran before it draws from a stream of its
// own, keyed by what it works on: RandomStream(seed, {frame_index, keyframe_id}).
class RandomStream {
 public:
  explicit RandomStream(std::uint64_t seed, std::initializer_list<std::uint64_t> key = {});

  std::uint64_t next();
  // Uniform in [0, 1).
  double uniform();
  // Uniform in [0, count); count must be positive.
  std::uint64_t index(std::uint64_t count);
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
