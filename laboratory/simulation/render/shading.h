#pragma once

#include <Eigen/Core>
#include <optional>

#include "laboratory/simulation/render/emitters.h"
#include "laboratory/simulation/render/light_bake.h"
#include "laboratory/simulation/scene/scene.h"

namespace roomwise::simulation {

// A ray that a camera looks along; its footprint grows with the distance.
struct ViewRay {
  Eigen::Vector3f origin, direction;
  float spread = 0;  // width of the footprint per unit of distance along the direction
  std::uint32_t seed = 0;
  std::optional<bool> in_sun = {};  // whether the sun shines on what it meets, where that is known
  float faintest_mirror = 0.012F;   // mirror images weaker than this are not looked for
};

// The radiance that reaches the camera: baked light, the sun's own light, what is mirrored and what
// shows through glass.
class Shading {
 public:
  Shading(const Scene& scene, const Emitters& emitters, const BakedLight& light)
      : scene_(scene), emitters_(emitters), light_(light) {}

  // The first hit of a ray, if there is one, is known to the caller.
  [[nodiscard]] Eigen::Vector3f radiance(const ViewRay& ray,
                                         const std::optional<RayHit>& first) const;
  // Whether the sun's middle shines on the place that is hit.
  [[nodiscard]] bool is_in_sun(const ViewRay& ray, const RayHit& hit) const;

 private:
  [[nodiscard]] Eigen::Vector3f surface(const ViewRay& ray, const RayHit& hit,
                                        bool with_mirror) const;
  [[nodiscard]] Eigen::Vector3f sunlight(const ViewRay& ray, const Eigen::Vector3f& point,
                                         const Eigen::Vector3f& normal) const;
  [[nodiscard]] Eigen::Vector3f mirrored(const ViewRay& ray, const Eigen::Vector3f& point,
                                         const Eigen::Vector3f& normal,
                                         const SurfaceLook& look) const;
  [[nodiscard]] Eigen::Vector3f outside(const ViewRay& ray) const;

  const Scene& scene_;
  const Emitters& emitters_;
  const BakedLight& light_;
};

}  // namespace roomwise::simulation
