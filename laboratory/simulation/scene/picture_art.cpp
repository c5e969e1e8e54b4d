#include "laboratory/simulation/scene/picture_art.h"

#include <algorithm>
#include <cmath>

#include "laboratory/simulation/scene/color_math.h"
#include "laboratory/simulation/scene/noise.h"

namespace roomwise::simulation {
namespace {

// A colour of the wheel: hue in turns, saturation and value 0 to 1.
Eigen::Vector3f color_of_hue(float hue, float saturation, float value) {
  const auto channel = [&](float offset) {
    const float k = 6 * fraction(hue + offset);
    const float ramp = std::clamp(std::min(k, 4 - k), 0.0F, 1.0F);
    return value * (1 - saturation * ramp);
  };
  return {channel(5.0F / 6), channel(3.0F / 6), channel(1.0F / 6)};
}

Eigen::Vector3f mountains(std::uint32_t seed, float u, float v) {
  const float hue = 0.52F + 0.12F * unit_hash(1, 0, seed);
  const Eigen::Vector3f sky_low(0.75F, 0.72F, 0.66F);
  Eigen::Vector3f color = mix(sky_low, color_of_hue(hue, 0.55F, 0.6F), v);
  color += Eigen::Vector3f::Constant(
      0.25F * smooth_step(0.05F, 0.4F, layered_noise(3 * u, 7 * v, seed + 1, 4)) * v);
  constexpr int kRanges = 4;
  for (int range = 0; range < kRanges; ++range) {
    const float nearness = static_cast<float>(range) / (kRanges - 1);
    const float ridge = lerp(0.72F, 0.2F, nearness) +
                        lerp(0.3F, 0.08F, nearness) *
                            layered_noise(u * (2.5F + nearness), 3.7F * nearness,
                                          seed + 10 + static_cast<std::uint32_t>(range), 5);
    const Eigen::Vector3f slope =
        mix(color_of_hue(hue, 0.35F, 0.42F), Eigen::Vector3f(0.1F, 0.17F, 0.05F), nearness);
    const float light = 1 + 0.5F * layered_noise(14 * u, 14 * v, seed + 20, 3);
    color = mix(color, slope * light, smooth_step(-0.004F, 0.004F, ridge - v));
  }
  return color;
}

Eigen::Vector3f seascape(std::uint32_t seed, float u, float v) {
  const float horizon = 0.35F + 0.2F * unit_hash(2, 0, seed);
  const float sun_x = 0.2F + 0.6F * unit_hash(3, 0, seed);
  const Eigen::Vector3f glow(0.95F, 0.5F, 0.2F), high(0.15F, 0.28F, 0.5F), deep(0.03F, 0.1F, 0.17F);
  if (v > horizon) {
    const float height = (v - horizon) / (1 - horizon);
    Eigen::Vector3f color = mix(glow, high, smooth_step(0, 0.9F, height));
    const float distance = std::hypot(u - sun_x, 0.8F * (height - 0.15F));
    color += Eigen::Vector3f(0.6F, 0.5F, 0.3F) * (1 - smooth_step(0.04F, 0.06F, distance));
    const float cloud = smooth_step(0, 0.3F, layered_noise(2 * u, 9 * v, seed, 4));
    return mix(color, Eigen::Vector3f(0.5F, 0.32F, 0.35F), 0.6F * cloud);
  }
  const float nearness = 1 - v / horizon;
  const float waves = layered_noise(u * 12, 30 * nearness * nearness + 20 * v, seed + 4, 3);
  const float glitter = (1 - smooth_step(0, 0.22F, std::abs(u - sun_x))) * (0.5F + waves);
  return mix(mix(high, deep, nearness), glow, std::clamp(0.6F * glitter + 0.1F, 0.0F, 0.9F));
}

Eigen::Vector3f forest(std::uint32_t seed, float u, float v) {
  Eigen::Vector3f color =
      mix(Eigen::Vector3f(0.55F, 0.6F, 0.3F), Eigen::Vector3f(0.75F, 0.8F, 0.6F), v);
  color *= 0.8F + 0.5F * layered_noise(9 * u, 9 * v, seed, 4);
  for (int layer = 0; layer < 3; ++layer) {
    const float nearness = 0.4F + 0.3F * static_cast<float>(layer);
    const float count = 16 - 5 * static_cast<float>(layer);
    const float x = u * count + 0.3F * smooth_noise(0.5F, 3 * v, seed + 7);
    const int trunk = floor_to_int(x);
    const auto layer_seed = seed + 40 + static_cast<std::uint32_t>(layer);
    const float center = 0.3F + 0.4F * unit_hash(trunk, 0, layer_seed);
    const float width = 0.06F + 0.1F * unit_hash(trunk, 1, layer_seed);
    const float cover = 1 - smooth_step(width, width + 0.05F, std::abs(fraction(x) - center));
    const float bark = 0.8F + 0.4F * smooth_noise(30 * u, 80 * v, seed + 50);
    color = mix(color, Eigen::Vector3f(0.09F, 0.07F, 0.05F) * bark, nearness * cover);
  }
  const float ground = 0.14F + 0.05F * layered_noise(4 * u, 0, seed + 60, 3);
  return mix(color, Eigen::Vector3f(0.16F, 0.11F, 0.04F), smooth_step(-0.03F, 0.02F, ground - v));
}

// Fields of colour, split again and again.
Eigen::Vector3f color_fields(std::uint32_t seed, float u, float v) {
  float left = 0, right = 1, low = 0, high = 1;
  std::uint32_t cell = seed;
  for (int split = 0; split < 4; ++split) {
    cell = scramble(cell + 77);
    const float at = 0.3F + 0.4F * unit_from_bits(cell);
    if ((right - left) * (0.7F + unit_from_bits(scramble(cell))) > high - low) {
      const float x = lerp(left, right, at);
      (u < x ? right : left) = x;
      cell += u < x ? 1 : 2;
    } else {
      const float y = lerp(low, high, at);
      (v < y ? high : low) = y;
      cell += v < y ? 3 : 4;
    }
  }
  const float edge = std::min({u - left, right - u, v - low, high - v});
  const float hue = unit_hash(5, 5, seed) + 0.25F * unit_from_bits(scramble(cell + 5));
  const Eigen::Vector3f color = color_of_hue(hue, 0.2F + 0.6F * unit_from_bits(cell),
                                             0.15F + 0.7F * unit_from_bits(scramble(cell + 9)));
  const float brush = 1 + 0.15F * layered_noise(25 * u, 6 * v, seed + 3, 3);
  return mix(Eigen::Vector3f::Constant(0.7F), color * brush, smooth_step(0.004F, 0.012F, edge));
}

Eigen::Vector3f circles(std::uint32_t seed, float u, float v) {
  const float hue = unit_hash(6, 6, seed);
  Eigen::Vector3f color = color_of_hue(hue, 0.15F, 0.75F);
  for (int i = 0; i < 9; ++i) {
    const float x = unit_hash(i, 1, seed), y = unit_hash(i, 2, seed);
    const float radius = 0.08F + 0.2F * unit_hash(i, 3, seed);
    const float distance = std::hypot(u - x, v - y);
    const Eigen::Vector3f paint = color_of_hue(hue + 0.6F * unit_hash(i, 4, seed), 0.75F,
                                               0.2F + 0.6F * unit_hash(i, 5, seed));
    color = mix(color, paint, 0.85F * (1 - smooth_step(radius - 0.006F, radius, distance)));
  }
  return color * (1 + 0.06F * layered_noise(40 * u, 40 * v, seed, 2));
}

}  // namespace

Eigen::Vector3f picture_color(std::uint64_t seed, float u, float v) {
  const auto bits = scramble(static_cast<std::uint32_t>(seed ^ (seed >> 32)));
  Eigen::Vector3f color;
  switch (bits % 6) {
    case 0:
    case 1:
      color = mountains(bits, u, v);
      break;
    case 2:
      color = seascape(bits, u, v);
      break;
    case 3:
      color = forest(bits, u, v);
      break;
    case 4:
      color = color_fields(bits, u, v);
      break;
    default:
      color = circles(bits, u, v);
      break;
  }
  return color.cwiseMax(0.0F).cwiseMin(0.9F);
}

}  // namespace roomwise::simulation
