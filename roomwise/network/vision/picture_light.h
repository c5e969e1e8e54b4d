#pragma once

#include <array>

#include "roomwise/network/vision/augmentation.h"

namespace roomwise::network {

// Lamps from 3950 to 18,600 K.
inline constexpr double kMaxLampMired = 100;

// What a grey surface's linear red, green and blue become, of the same luminance, where the light
// is so much warmer than 6504 K (PictureVariation::lamp_mired, at most kMaxLampMired to either
// side) and so much greener.
[[nodiscard]] std::array<double, 3> light_color(double lamp_mired, double tint_stops);

// Changes the picture by the variation's light: exposure, colour, blur, noise, tone curve.
void change_light(image::ColorImage& image, const PictureVariation& variation);

}  // namespace roomwise::network
