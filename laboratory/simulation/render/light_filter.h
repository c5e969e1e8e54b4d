#pragma once

#include <Eigen/Core>
#include <vector>

#include "laboratory/simulation/scene/scene.h"
#include "roomwise/base/thread_pool.h"

namespace roomwise::simulation {

// Smooths the noise of gathered light on floors, walls and ceilings, and keeps the edges of
// shadows: texels are averaged with those around that differ by no more than the noise does.
// Bounced light has no sharp edges and takes more smoothing than direct light does.
enum class Smoothness { kDirect, kBounced };
// is_buried: a texel a place; nobody sees those, and they take the light of open ones beside them,
// so that their darkness does not show along skirting boards and frames.
void fill_buried_texels(const Scene& scene, std::vector<std::uint8_t> is_buried,
                        std::vector<Eigen::Vector3f>& texels);
void filter_texels(const Scene& scene, Smoothness smoothness, ThreadPool& pool,
                   std::vector<Eigen::Vector3f>& texels);

}  // namespace roomwise::simulation
