#pragma once

#include <cstdint>

// Repeatable noise for made-up surfaces: a function of place and seed, so that nothing is stored.
namespace roomwise::simulation {

// Rounds down. (std::floor is a call of the C library on plain x86-64.)
inline int floor_to_int(float x) {
  const int truncated = static_cast<int>(x);
  return static_cast<float>(truncated) > x ? truncated - 1 : truncated;
}

inline float fraction(float x) {
  return x - static_cast<float>(floor_to_int(x));
}

inline float lerp(float a, float b, float t) {
  return a + (b - a) * t;
}

// From 0 to 1 as x goes from `low` to `high`, with no corner.
inline float smooth_step(float low, float high, float x) {
  const float t = (x - low) / (high - low);
  if (t <= 0) return 0;
  if (t >= 1) return 1;
  return t * t * (3 - 2 * t);
}

inline std::uint32_t scramble(std::uint32_t x) {
  x ^= x >> 16;
  x *= 0x7feb352dU;
  x ^= x >> 15;
  x *= 0x846ca68bU;
  x ^= x >> 16;
  return x;
}

inline std::uint32_t hash_cell(int x, int y, std::uint32_t seed) {
  return scramble(static_cast<std::uint32_t>(x) * 0x9e3779b1U +
                  scramble(static_cast<std::uint32_t>(y) + seed * 0x85ebca6bU));
}

// Uniform in [0, 1).
inline float unit_from_bits(std::uint32_t bits) {
  return static_cast<float>(bits >> 8) * 0x1.0p-24F;
}

inline float unit_hash(int x, int y, std::uint32_t seed) {
  return unit_from_bits(hash_cell(x, y, seed));
}

// Smooth noise in [-1, 1] whose features are one unit wide.
inline float smooth_noise(float x, float y, std::uint32_t seed) {
  const int cell_x = floor_to_int(x), cell_y = floor_to_int(y);
  const float fx = x - static_cast<float>(cell_x), fy = y - static_cast<float>(cell_y);
  const float sx = fx * fx * (3 - 2 * fx), sy = fy * fy * (3 - 2 * fy);
  const float low = lerp(unit_hash(cell_x, cell_y, seed), unit_hash(cell_x + 1, cell_y, seed), sx);
  const float high =
      lerp(unit_hash(cell_x, cell_y + 1, seed), unit_hash(cell_x + 1, cell_y + 1, seed), sx);
  return 2 * lerp(low, high, sy) - 1;
}

// Octaves of smooth noise, each half as wide and half as strong as the one before; in [-1, 1].
inline float layered_noise(float x, float y, std::uint32_t seed, int octaves) {
  float sum = 0, strength = 0.5F;
  for (int octave = 0; octave < octaves; ++octave) {
    sum += strength * smooth_noise(x, y, seed + static_cast<std::uint32_t>(octave) * 101U);
    x = 2 * x + 17.3F;
    y = 2 * y + 5.7F;
    strength *= 0.5F;
  }
  return sum;
}

}  // namespace roomwise::simulation
