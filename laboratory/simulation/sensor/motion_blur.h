#pragma once

#include <Eigen/Core>

#include "laboratory/simulation/render/renderer.h"
#include "laboratory/simulation/walk/walk.h"
#include "roomwise/geometry/pinhole_camera.h"

namespace roomwise::simulation {

// The light that the sensor gathers while the shutter is open: every pixel's mean along the way
// that the point it sees takes over the sensor. rays: of every pixel, at depth 1.
class MotionBlur {
 public:
  MotionBlur(const RenderedFrame& frame, const WalkPose& pose,
             const geometry::PinholeCamera& camera, const image::Image<Eigen::Vector2f>& rays);

  [[nodiscard]] Eigen::Vector3f light_at(int x, int y) const;

 private:
  struct Motion {
    Eigen::Matrix3f rotation;  // from the frame's camera to the one at the shutter's end
    Eigen::Vector3f translation;
  };

  [[nodiscard]] Motion motion_to(const geometry::RigidTransform& world_from_end,
                                 const WalkPose& pose) const;
  [[nodiscard]] Eigen::Vector2f shift(const Motion& motion, const Eigen::Vector2f& ray,
                                      float depth_m) const;
  [[nodiscard]] Eigen::Vector4f interpolated(const Eigen::Vector2f& pixel) const;

  const RenderedFrame& frame_;
  image::Image<Eigen::Vector4f> radiance_;  // the frame's, and a 0: four numbers at a time
  const image::Image<Eigen::Vector2f>& rays_;
  Eigen::Vector2f focal_px_;
  Motion open_, close_;
};

}  // namespace roomwise::simulation
