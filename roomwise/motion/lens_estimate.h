#pragma once

#include <Eigen/Core>
#include <optional>

#include "roomwise/base/random.h"
#include "roomwise/geometry/pinhole_camera.h"
#include "roomwise/image/exif.h"

namespace roomwise::motion {

// What is known of a camera that nobody calibrated, a phone's for example. Its pixels are taken to
// be square and its principal point to be the middle of the picture, so that the same is known of
// the picture turned; its focal length and one term of distortion are uncertain.
struct IntrinsicsEstimate {
  // The natural logarithm of the focal length over the picture's longer side, and k1.
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();  // inverse covariance

  // Before any picture. Main cameras of phones say 24 to 28 mm in their EXIF data, which is 0.7 to
  // 0.8 of the longer side of a picture of 4 to 3; video is cut out of that, webcams lie about
  // there, wide-angle lenses at half of it, telephoto lenses at twice.
  [[nodiscard]] static IntrinsicsEstimate typical_of_phones();

  // Of a photo of so many pixels, by what its Exif says; nothing where it was cropped since, so
  // that what it says is of another picture. Exif gives a focal length in whole millimetres, does
  // not say whether it compares diagonals or widths, nor whether of the whole sensor or of the
  // picture cut out of it: these ways to read it and its rounding, and how lenses differ from their
  // names, make its uncertainty.
  [[nodiscard]] static std::optional<IntrinsicsEstimate> from_exif(const image::ExifLens& exif,
                                                                   int width, int height);

  [[nodiscard]] geometry::PinholeCamera camera(int width, int height) const;
  // Standard deviation of the focal length, relative to it.
  [[nodiscard]] double relative_focal_sigma() const;

  // A camera with a focal length drawn from what is known, and how probable it is that such a one
  // is near enough to the true one for its poses to be refined.
  [[nodiscard]] geometry::PinholeCamera sample_camera(int width, int height,
                                                      RandomStream& random) const;
  [[nodiscard]] double near_draw_probability() const;
};

}  // namespace roomwise::motion
