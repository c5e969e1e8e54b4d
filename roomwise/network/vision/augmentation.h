#pragma once

#include <cstdint>
#include <string>

#include "roomwise/base/expected.h"
#include "roomwise/base/random.h"
#include "roomwise/image/image.h"

namespace roomwise::network {

// One other picture of the same place: as the camera might have taken it in other light, set
// otherwise, or held a little differently. The default changes nothing.
//
// Applied in the order of what happens to light: where the camera looks, then (on linear light, as
// sRGB is defined in IEC 61966-2-1) exposure and the colour of the light, the lens's blur, the
// sensor's noise, and at last the camera's tone curve.
struct PictureVariation {
  double exposure_stops = 0;  // linear values are multiplied by 2^stops; what is over white is lost
  // The lamps are this much warmer (over 0) or bluer (below 0) than the camera thinks: a shift of
  // the light's temperature from 6504 K, in mired (10^6 / kelvin), in which equal steps look alike.
  double lamp_mired = 0;
  double tint_stops = 0;   // green (over 0) or magenta (below 0), as of fluorescent lamps
  double blur = 0;         // standard deviation, in parts of the picture's longer side
  double noise = 0;        // standard deviation of a white pixel's linear value
  double gamma_stops = 0;  // sRGB values, 0 to 1, are raised to 2^gamma_stops

  double side = 1;      // of the picture a part of this share of both sides is seen
  double place_x = 0;   // where that lies, from 0 (left) to 1 (right), and
  double place_y = 0;   // from 0 (top) to 1 (bottom)
  double roll_deg = 0;  // the camera is turned about the direction in which it looks
  // The camera is turned aside or up, but looks at the same middle: lines converge. For a lens that
  // sees 53 degrees along the longer side, to the first order of the angle.
  double pan_deg = 0;
  double tilt_deg = 0;
  bool mirrored = false;
  std::uint64_t noise_seed = 0;

  friend bool operator==(const PictureVariation&, const PictureVariation&) = default;
};

// How far pictures are varied: each value of a variation is drawn evenly from zero to its largest
// size, to both sides where it has two. The defaults stay within what a phone's pictures of one
// room show from day to evening; kNoAugmentation varies nothing.
struct AugmentationOptions {
  double exposure_stops = 0.8;
  double lamp_mired = 60;
  double tint_stops = 0.1;
  double blur = 0.002;
  double noise = 0.03;
  double gamma_stops = 0.25;
  double min_side = 0.7;  // what is seen is at least this share of the picture's sides
  double roll_deg = 5;
  double pan_deg = 8;
  double tilt_deg = 8;
  bool mirror = false;  // every second picture; not where left and right matter

  // Fails, naming the option, on what is not finite or beyond what a picture bears.
  [[nodiscard]] Expected<void> validate() const;
  // A text that tells these options, and what this version of the code makes of them, from others:
  // what was computed from varied pictures is good for the same text.
  [[nodiscard]] std::string key() const;

  friend bool operator==(const AugmentationOptions&, const AugmentationOptions&) = default;
};
inline constexpr AugmentationOptions kNoAugmentation{0, 0, 0, 0, 0, 0, 1, 0, 0, 0, false};

// Draws always as much from the stream, so that one option does not shift what others draw.
[[nodiscard]] PictureVariation sample_variation(const AugmentationOptions& options,
                                                RandomStream& random);

// The picture varied. It is `side` times as large; turned, it becomes as much smaller as keeps it
// inside of what was seen. A picture without pixels stays without.
[[nodiscard]] image::ColorImage vary(const image::ColorImage& image,
                                     const PictureVariation& variation);

// Both. `random` is keyed by what the picture is, so that the same picture is always varied alike:
// RandomStream(seed, {picture, variant}).
[[nodiscard]] image::ColorImage augment(const image::ColorImage& image,
                                        const AugmentationOptions& options, RandomStream& random);

}  // namespace roomwise::network
