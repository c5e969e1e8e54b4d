#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "laboratory/simulation/render/emitters.h"
#include "laboratory/simulation/render/renderer.h"
#include "laboratory/simulation/scene/scene.h"
#include "roomwise/base/expected.h"
#include "roomwise/base/progress.h"
#include "roomwise/base/thread_pool.h"

namespace roomwise::simulation {

// The diffuse light of a home at rest, without the sun's direct light: the illuminance at the
// texels of floors, walls and ceilings, and at the corners of all other triangles on both sides.
struct BakedLight {
  std::vector<Eigen::Vector3f> texels;                  // Patch::first_texel
  std::array<std::vector<Eigen::Vector3f>, 2> corners;  // front and back, by index of position

  // The illuminance where a ray hits, on the side that it comes from.
  [[nodiscard]] Eigen::Vector3f at(const Scene& scene, const RayHit& hit,
                                   const Eigen::Vector3f& point,
                                   const Eigen::Vector3f& direction) const;
};

// Gathers direct light and two bounces at points spread over all surfaces, smooths away the noise
// and keeps the result. Fails where the user interrupts.
[[nodiscard]] Expected<BakedLight> bake_light(const Scene& scene, const Emitters& emitters,
                                              double effort, ThreadPool& pool, Progress& progress,
                                              BakeStatistics& statistics);

}  // namespace roomwise::simulation
