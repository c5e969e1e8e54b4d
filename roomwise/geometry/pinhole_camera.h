#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>

#include "roomwise/base/expected.h"

namespace roomwise::geometry {

// Brown's lens distortion as OpenCV and the TUM calibration have it; all zero means none.
struct LensDistortion {
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0;

  [[nodiscard]] bool is_none() const { return k1 == 0 && k2 == 0 && p1 == 0 && p2 == 0 && k3 == 0; }
};

// A pinhole camera with lens distortion whose depth image is registered to its colour image. The
// camera frame has x right, y down, z forward; pixel (0, 0) is the centre of the top left pixel.
struct PinholeCamera {
  double fx = 0, fy = 0;  // focal lengths, px
  double cx = 0, cy = 0;  // principal point, px
  int width = 0, height = 0;
  LensDistortion distortion;
  double depth_units_per_metre = 1000;  // a depth image holds metres times this

  // Fails, saying why, on what cannot be: a focal length out of 0.2 to 5 picture widths, a principal
  // point outside the picture, depth units out of 100 to 100,000 a metre, a lens that folds it.
  [[nodiscard]] Expected<void> validate() const;
  // What of a valid camera is so unusual that it is likely a mistake; nothing where all is as
  // cameras of rooms have it.
  [[nodiscard]] std::optional<std::string> doubt() const;

  // The pixel that sees a point of the camera frame (s p = C [R|T] P with [R|T] applied already).
  // The point must lie in front of the camera (z > 0).
  [[nodiscard]] Eigen::Vector2d project(const Eigen::Vector3d& point_camera) const;
  // Without the lens: the pixel in an ideal pinhole camera of the same fx, fy, cx, cy.
  [[nodiscard]] Eigen::Vector2d project_undistorted(const Eigen::Vector3d& point_camera) const {
    return {fx * point_camera.x() / point_camera.z() + cx,
            fy * point_camera.y() / point_camera.z() + cy};
  }
  // The pixel where the ideal pinhole camera sees what this camera sees at `pixel` (inverts the
  // distortion by fixed-point iteration).
  [[nodiscard]] Eigen::Vector2d undistort(const Eigen::Vector2d& pixel) const;
  // The point at `depth_m` along the optical axis that an undistorted pixel sees.
  [[nodiscard]] Eigen::Vector3d unproject_undistorted(const Eigen::Vector2d& pixel,
                                                      double depth_m) const {
    return {(pixel.x() - cx) / fx * depth_m, (pixel.y() - cy) / fy * depth_m, depth_m};
  }
  // The same for a pixel of the real image.
  [[nodiscard]] Eigen::Vector3d unproject(const Eigen::Vector2d& pixel, double depth_m) const {
    return unproject_undistorted(undistort(pixel), depth_m);
  }

  friend bool operator==(const PinholeCamera& a, const PinholeCamera& b);
};

// The calibrations that TUM publishes for its recordings (fr1, fr2, fr3; depth at 5000 units per
// metre), and the factory values of the first Kinect and the Asus Xtion (kinect-v1, xtion; depth in
// mm). Source of fr1 to fr3: https://cvg.cit.tum.de/data/datasets/rgbd-dataset/file_formats
[[nodiscard]] Expected<PinholeCamera> camera_preset(std::string_view name);

}  // namespace roomwise::geometry
