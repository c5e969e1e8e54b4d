#include "roomwise/network/vision/augmentation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "roomwise/image/resample.h"
#include "roomwise/network/vision/picture_light.h"

namespace roomwise::network {
namespace {

using image::ColorImage;

double radians(double degrees) {
  return degrees * std::numbers::pi / 180;
}

// From places of the new picture (pixels from its middle) to places of the old one (its pixels).
struct CameraView {
  double center_x = 0;
  double center_y = 0;
  double cosine = 1;
  double sine = 0;
  double pan = 0;  // change of depth per pixel
  double tilt = 0;

  [[nodiscard]] std::array<double, 2> old_place(double x, double y) const {
    const double nearer = 1 / (1 + pan * x + tilt * y);
    return {center_x + (cosine * x - sine * y) * nearer,
            center_y + (sine * x + cosine * y) * nearer};
  }
};

// A picture of this size, seen by this view, lies inside the old one. What a view makes of a
// rectangle is convex, so that the corners' pixels decide.
bool lies_inside(const CameraView& view, int width, int height, const ColorImage& image) {
  for (const double x : {0.5 - width / 2.0, width / 2.0 - 0.5}) {
    for (const double y : {0.5 - height / 2.0, height / 2.0 - 0.5}) {
      const auto [old_x, old_y] = view.old_place(x, y);
      if (old_x < 0 || old_y < 0 || old_x > image.width() - 1 || old_y > image.height() - 1) {
        return false;
      }
    }
  }
  return true;
}

// Between the four pixels around a place inside the picture.
Rgb8 interpolated(const ColorImage& image, double x, double y) {
  const int left = static_cast<int>(x);
  const int top = static_cast<int>(y);
  const int right = std::min(left + 1, image.width() - 1);
  const int bottom = std::min(top + 1, image.height() - 1);
  const auto wx = static_cast<float>(x - left);
  const auto wy = static_cast<float>(y - top);
  const auto mixed = [&](std::uint8_t Rgb8::*channel) {
    const auto value = [&](int column, int row) {
      return static_cast<float>(image.at(column, row).*channel);
    };
    const float above = value(left, top) * (1 - wx) + value(right, top) * wx;
    const float below = value(left, bottom) * (1 - wx) + value(right, bottom) * wx;
    return static_cast<std::uint8_t>(above * (1 - wy) + below * wy + 0.5F);
  };
  return {mixed(&Rgb8::r), mixed(&Rgb8::g), mixed(&Rgb8::b)};
}

int share_of(int side_px, double share) {
  return std::max(1, static_cast<int>(std::lround(side_px * share)));
}

// The first pixel of `part` pixels out of `whole`, by whole pixels.
int first_of_part(int part, int whole, double place) {
  return static_cast<int>(std::lround((whole - part) * place));
}

ColorImage turned(const ColorImage& image, int x, int y, int width, int height,
                  const PictureVariation& variation) {
  // With 53 degrees from side to side, the focal length is as long as the longer side.
  const double focal_px = std::max(image.width(), image.height());
  const CameraView view{x + (width - 1) / 2.0,
                        y + (height - 1) / 2.0,
                        std::cos(radians(variation.roll_deg)),
                        std::sin(radians(variation.roll_deg)),
                        std::tan(radians(variation.pan_deg)) / focal_px,
                        std::tan(radians(variation.tilt_deg)) / focal_px};
  const double height_of_width = static_cast<double>(height) / width;
  while (width > 1 && !lies_inside(view, width, height, image)) {
    --width;
    height = std::max(1, static_cast<int>(std::lround(width * height_of_width)));
  }
  ColorImage seen(width, height);
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      const auto [old_x, old_y] =
          view.old_place(column + 0.5 - width / 2.0, row + 0.5 - height / 2.0);
      // The clamp is for what rounding leaves over the edge, and for pictures of one pixel's width.
      seen.at(column, row) = interpolated(image, std::clamp(old_x, 0.0, image.width() - 1.0),
                                          std::clamp(old_y, 0.0, image.height() - 1.0));
    }
  }
  return seen;
}

ColorImage look(const ColorImage& image, const PictureVariation& variation) {
  const int width = share_of(image.width(), variation.side);
  const int height = share_of(image.height(), variation.side);
  const int x = first_of_part(width, image.width(), variation.place_x);
  const int y = first_of_part(height, image.height(), variation.place_y);
  const bool straight =
      variation.roll_deg == 0 && variation.pan_deg == 0 && variation.tilt_deg == 0;
  ColorImage seen = straight ? image::crop(image, x, y, width, height)
                             : turned(image, x, y, width, height, variation);
  return variation.mirrored ? image::mirror(seen) : seen;
}

Expected<void> check_range(const char* name, double value, double least, double most) {
  if (value >= least && value <= most) return {};
  return fail("{} is {}; expected {} to {}", name, value, least, most);
}

}  // namespace

Expected<void> AugmentationOptions::validate() const {
  ROOMWISE_RETURN_IF_ERROR(check_range("exposure_stops", exposure_stops, 0, 4));
  ROOMWISE_RETURN_IF_ERROR(check_range("lamp_mired", lamp_mired, 0, kMaxLampMired));
  ROOMWISE_RETURN_IF_ERROR(check_range("tint_stops", tint_stops, 0, 1));
  ROOMWISE_RETURN_IF_ERROR(check_range("blur", blur, 0, 0.05));
  ROOMWISE_RETURN_IF_ERROR(check_range("noise", noise, 0, 0.5));
  ROOMWISE_RETURN_IF_ERROR(check_range("gamma_stops", gamma_stops, 0, 1));
  ROOMWISE_RETURN_IF_ERROR(check_range("min_side", min_side, 0.1, 1));
  ROOMWISE_RETURN_IF_ERROR(check_range("roll_deg", roll_deg, 0, 45));
  ROOMWISE_RETURN_IF_ERROR(check_range("pan_deg", pan_deg, 0, 30));
  return check_range("tilt_deg", tilt_deg, 0, 30);
}

std::string AugmentationOptions::key() const {
  // The number is to be raised when the same options give other pictures.
  return fmt::format("1: {} {} {} {} {} {} {} {} {} {} {}", exposure_stops, lamp_mired, tint_stops,
                     blur, noise, gamma_stops, min_side, roll_deg, pan_deg, tilt_deg,
                     mirror ? 1 : 0);
}

PictureVariation sample_variation(const AugmentationOptions& options, RandomStream& random) {
  const auto either_side = [&](double most) { return most * (2 * random.uniform() - 1); };
  PictureVariation variation;
  variation.exposure_stops = either_side(options.exposure_stops);
  variation.lamp_mired = either_side(options.lamp_mired);
  variation.tint_stops = either_side(options.tint_stops);
  variation.blur = options.blur * random.uniform();
  variation.noise = options.noise * random.uniform();
  variation.gamma_stops = either_side(options.gamma_stops);
  variation.side = 1 - (1 - options.min_side) * random.uniform();
  variation.place_x = random.uniform();
  variation.place_y = random.uniform();
  variation.roll_deg = either_side(options.roll_deg);
  variation.pan_deg = either_side(options.pan_deg);
  variation.tilt_deg = either_side(options.tilt_deg);
  variation.mirrored = random.index(2) == 1 && options.mirror;
  variation.noise_seed = random.next();
  return variation;
}

ColorImage vary(const ColorImage& image, const PictureVariation& variation) {
  if (image.empty()) return image;
  ColorImage varied = look(image, variation);
  change_light(varied, variation);
  return varied;
}

ColorImage augment(const ColorImage& image, const AugmentationOptions& options,
                   RandomStream& random) {
  return vary(image, sample_variation(options, random));
}

}  // namespace roomwise::network
