#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

#include "roomwise/base/color.h"

namespace roomwise::simulation {

// The linear value, 0 to 1, of an sRGB byte.
inline float linear_from_srgb(std::uint8_t value) {
  static const std::array<float, 256> kTable = [] {
    std::array<float, 256> table{};
    for (std::size_t i = 0; i < table.size(); ++i) {
      const double s = static_cast<double>(i) / 255;
      table[i] = static_cast<float>(s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4));
    }
    return table;
  }();
  return kTable[value];
}

inline Eigen::Vector3f linear_from_srgb(Rgb8 color) {
  return {linear_from_srgb(color.r), linear_from_srgb(color.g), linear_from_srgb(color.b)};
}

inline float luminance(const Eigen::Vector3f& linear) {
  return 0.2126F * linear.x() + 0.7152F * linear.y() + 0.0722F * linear.z();
}

inline Eigen::Vector3f mix(const Eigen::Vector3f& a, const Eigen::Vector3f& b, float t) {
  return a + (b - a) * t;
}

// The colour of a glowing body, linear RGB of luminance 1; 6500 K is white. A fit to Planck's law
// that is good to a few percent from 1900 to 12000 K.
inline Eigen::Vector3f color_of_temperature(double kelvin) {
  const double t = std::clamp(kelvin, 1900.0, 12000.0) / 100;
  const auto byte = [](double value) {
    return static_cast<std::uint8_t>(std::clamp(value, 0.0, 255.0));
  };
  const double red = t <= 66 ? 255 : 329.7 * std::pow(t - 60, -0.1332);
  const double green = t <= 66 ? 99.47 * std::log(t) - 161.1 : 288.1 * std::pow(t - 60, -0.0755);
  const double blue = t >= 66 ? 255 : (t <= 19 ? 0 : 138.5 * std::log(t - 10) - 305.0);
  const Eigen::Vector3f linear = linear_from_srgb(Rgb8{byte(red), byte(green), byte(blue)});
  return linear / luminance(linear);
}

}  // namespace roomwise::simulation
