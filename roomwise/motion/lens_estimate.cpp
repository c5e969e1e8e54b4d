#include "roomwise/motion/lens_estimate.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

namespace roomwise::motion {
namespace {

// A focal length is drawn from so many standard deviations around the mean, evenly.
constexpr double kDrawnSigmas = 2;
// A pose that was found by a focal length this near to the true one, relative to it, is refined to
// the true one.
constexpr double kNearEnough = 0.06;

// How far a lens is from the name it has (26 mm), relative to it: makers round, it changes as it
// focuses, and its distortion is taken out of the picture.
constexpr double kNominalFocalSigma = 0.04;
// Of k1, before any picture.
constexpr double kDistortionSigma = 0.1;
// Sides, and focal lengths over the longer one, that are another picture's.
constexpr double kAspectTolerance = 0.02;
constexpr double kMinFocal = 0.2, kMaxFocal = 5;  // over the longer side, as PinholeCamera has them

double longer_over_shorter(int width, int height) {
  return 1.0 * std::max(width, height) / std::min(width, height);
}

// Focal lengths over the picture's longer side, by each way to read what Exif says.
std::vector<double> focal_readings(const image::ExifLens& exif, double shape) {
  std::vector<double> readings;
  if (exif.focal_length_35mm_mm) {
    constexpr double kFilmWidth_mm = 36, kFilmDiagonal_mm = 43.267;
    constexpr double kSensorDiagonal = 1.25;  // of 4 to 3, over its longer side
    const double focal_mm = *exif.focal_length_35mm_mm;
    readings.push_back(focal_mm / kFilmWidth_mm);
    readings.push_back(focal_mm / kFilmDiagonal_mm * std::hypot(1, 1 / shape));
    readings.push_back(focal_mm / kFilmDiagonal_mm * kSensorDiagonal);
  }
  const int longer = std::max(exif.width, exif.height);
  if (exif.focal_length_mm && exif.pixels_per_mm && longer > 0) {
    readings.push_back(*exif.focal_length_mm * *exif.pixels_per_mm / longer);
  }
  // Whether the zoom is in there is not said either.
  const double zoom = exif.digital_zoom.value_or(1);
  if (zoom > 1) {
    for (std::size_t i = readings.size(); i-- > 0;) readings.push_back(readings[i] * zoom);
  }
  return readings;
}

}  // namespace

IntrinsicsEstimate IntrinsicsEstimate::typical_of_phones() {
  constexpr double kFocal = 0.8, kFocalSigma = 0.35;
  IntrinsicsEstimate phones;
  phones.mean << std::log(kFocal), 0;
  phones.information.diagonal() << 1 / (kFocalSigma * kFocalSigma),
      1 / (kDistortionSigma * kDistortionSigma);
  return phones;
}

std::optional<IntrinsicsEstimate> IntrinsicsEstimate::from_exif(const image::ExifLens& exif,
                                                                int width, int height) {
  const double shape = longer_over_shorter(width, height);
  const bool has_size = exif.width > 0 && exif.height > 0;
  if (has_size &&
      std::abs(longer_over_shorter(exif.width, exif.height) / shape - 1) > kAspectTolerance) {
    return std::nullopt;
  }
  const std::vector<double> readings = focal_readings(exif, shape);
  if (readings.empty()) return std::nullopt;
  const auto [least, most] = std::ranges::minmax(readings);
  if (!(least >= kMinFocal && most <= kMaxFocal)) return std::nullopt;
  // Each reading is within a standard deviation of their middle.
  const double half_range = 0.5 * std::log(most / least);
  const double rounding = 1 / std::sqrt(12) / exif.focal_length_35mm_mm.value_or(1e9);
  const double sigma = std::hypot(half_range, rounding, kNominalFocalSigma);
  IntrinsicsEstimate photo = typical_of_phones();
  photo.mean[0] = 0.5 * std::log(least * most);
  photo.information(0, 0) = 1 / (sigma * sigma);
  return photo;
}

geometry::PinholeCamera IntrinsicsEstimate::camera(int width, int height) const {
  geometry::PinholeCamera camera;
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = std::exp(mean[0]) * std::max(width, height);
  camera.cx = 0.5 * (width - 1);
  camera.cy = 0.5 * (height - 1);
  camera.distortion.k1 = mean[1];
  return camera;
}

double IntrinsicsEstimate::relative_focal_sigma() const {
  return std::sqrt(information.inverse()(0, 0));
}

geometry::PinholeCamera IntrinsicsEstimate::sample_camera(int width, int height,
                                                          RandomStream& random) const {
  const double reach = kDrawnSigmas * relative_focal_sigma();
  IntrinsicsEstimate drawn = *this;
  drawn.mean[0] += random.between(-reach, reach);
  return drawn.camera(width, height);
}

double IntrinsicsEstimate::near_draw_probability() const {
  return std::min(1.0, kNearEnough / (kDrawnSigmas * relative_focal_sigma()));
}

}  // namespace roomwise::motion
