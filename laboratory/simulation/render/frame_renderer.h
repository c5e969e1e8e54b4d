#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "laboratory/simulation/render/renderer.h"
#include "laboratory/simulation/render/shading.h"
#include "laboratory/simulation/scene/scene.h"
#include "roomwise/base/thread_pool.h"
#include "roomwise/geometry/pinhole_camera.h"
#include "roomwise/image/image.h"

namespace roomwise::simulation {

// Where every pixel of a camera looks: the point of the plane z = 1, and how it changes over the
// pixel.
class ViewDirections {
 public:
  explicit ViewDirections(const geometry::PinholeCamera& camera);

  [[nodiscard]] const geometry::PinholeCamera& camera() const { return camera_; }
  // The direction through a pixel's centre and a part of a pixel beside it; z = 1.
  [[nodiscard]] Eigen::Vector3f at(int x, int y, const Eigen::Vector2f& beside_px) const;

 private:
  [[nodiscard]] const Eigen::Vector2f& center(int x, int y) const {
    return centers_.at(x + 1, y + 1);
  }
  geometry::PinholeCamera camera_;
  image::Image<Eigen::Vector2f> centers_;  // with a border of one pixel
};

// Draws one frame. First a ray goes through every pixel's centre: depth and truth come from there.
// A pixel whose neighbours see the same flat surface in the same light is shaded there, with its
// textures blurred to the pixel's width; all others, where edges are, by several rays.
class FrameRenderer {
 public:
  FrameRenderer(const Scene& scene, const Shading& shading, const ViewDirections& directions,
                const geometry::RigidTransform& world_from_camera, int samples_per_pixel);

  [[nodiscard]] RenderedFrame render(ThreadPool& pool);

 private:
  [[nodiscard]] ViewRay ray_of(int x, int y, int sample) const;
  using Hits = std::array<std::optional<RayHit>, RayCaster::kBundle>;
  [[nodiscard]] Hits first_hits(std::span<const Eigen::Vector2i> pixels, int sample) const;
  void look_through_center(int x, int y, std::optional<RayHit> hit, RenderedFrame& frame);
  void note_surface(const ViewRay& ray, const RayHit& hit, int x, int y,
                    RenderedFrame& frame) const;
  [[nodiscard]] bool is_even(int x, int y) const;
  [[nodiscard]] bool continues(int x, int y, int other_x, int other_y) const;
  void shade(std::span<const Eigen::Vector2i> pixels, RenderedFrame& frame) const;

  struct Center {
    std::optional<RayHit> hit;
    bool in_sun = false;
  };
  const Scene& scene_;
  const Shading& shading_;
  const ViewDirections& directions_;
  Eigen::Matrix3f rotation_;
  Eigen::Vector3f origin_;
  int samples_;
  float pixel_width_;  // at distance 1
  image::Image<Center> centers_;
};

}  // namespace roomwise::simulation
