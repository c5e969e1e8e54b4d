#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "roomwise/image/image.h"

namespace roomwise::image {

// How a camera was held, as the Exif tag Orientation (0x0112) numbers it: what has to be done to
// the stored picture to show it upright. 1 is nothing; 5 to 8 exchange width and height.
constexpr int kUpright = 1;

// The orientation (1 to 8) in the payload of a JPEG's APP1 segment ("Exif\0\0" and a TIFF header);
// kUpright where there is none or the bytes make no sense: they come from outside, and a photo
// without a usable orientation is still a photo. Source: Exif 2.3 (CIPA DC-008), TIFF 6.0.
[[nodiscard]] int exif_orientation(std::span<const std::uint8_t> app1);

// What a camera wrote into a photo of the lens that took it; absent what it did not write or what
// makes no sense. Nothing is known of a picture that was cropped since.
struct ExifLens {
  std::optional<double> focal_length_mm;       // FocalLength
  std::optional<double> focal_length_35mm_mm;  // FocalLengthIn35mmFilm: of a 36 x 24 mm picture
  std::optional<double> pixels_per_mm;         // FocalPlaneXResolution, on the sensor
  std::optional<double> digital_zoom;          // DigitalZoomRatio, at least 1
  int width = 0, height = 0;  // PixelXDimension, PixelYDimension: of the stored picture; 0: unknown

  [[nodiscard]] bool tells_focal_length() const {
    return focal_length_35mm_mm.has_value() || (focal_length_mm && pixels_per_mm);
  }
  friend bool operator==(const ExifLens&, const ExifLens&) = default;
};

// Of the payload of a JPEG's APP1 segment; nothing where it does not tell a focal length. Only the
// tags above are read: no place on the earth, no owner, no maker's notes.
[[nodiscard]] std::optional<ExifLens> exif_lens(std::span<const std::uint8_t> app1);

// The picture turned and mirrored upright. orientation: 1 to 8.
[[nodiscard]] ColorImage apply_orientation(ColorImage image, int orientation);

}  // namespace roomwise::image
