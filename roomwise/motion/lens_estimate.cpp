#include "roomwise/motion/lens_estimate.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace roomwise::motion {
namespace {

// A focal length is drawn from so many standard deviations around the mean, evenly.
constexpr double kDrawnSigmas = 2;
// A pose that was found by a focal length this near to the true one, relative to it, is refined to
// the true one.
constexpr double kNearEnough = 0.06;

}  // namespace

LensEstimate LensEstimate::of_phones() {
  constexpr double kFocal = 0.8, kFocalSigma = 0.35, kDistortionSigma = 0.1;
  LensEstimate phones;
  phones.mean << std::log(kFocal), 0;
  phones.information.diagonal() << 1 / (kFocalSigma * kFocalSigma),
      1 / (kDistortionSigma * kDistortionSigma);
  return phones;
}

geometry::PinholeCamera LensEstimate::camera(int width, int height) const {
  geometry::PinholeCamera camera;
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = std::exp(mean[0]) * std::max(width, height);
  camera.cx = 0.5 * (width - 1);
  camera.cy = 0.5 * (height - 1);
  camera.distortion.k1 = mean[1];
  return camera;
}

double LensEstimate::focal_sigma() const {
  return std::sqrt(information.inverse()(0, 0));
}

geometry::PinholeCamera LensEstimate::sample_camera(int width, int height,
                                                    RandomStream& random) const {
  const double reach = kDrawnSigmas * focal_sigma();
  LensEstimate drawn = *this;
  drawn.mean[0] += random.between(-reach, reach);
  return drawn.camera(width, height);
}

double LensEstimate::right_draw() const {
  return std::min(1.0, kNearEnough / (kDrawnSigmas * focal_sigma()));
}

}  // namespace roomwise::motion
