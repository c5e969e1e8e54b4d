#pragma once

#include <cstddef>
#include <vector>

#include "roomwise/base/thread_pool.h"
#include "roomwise/simulation/free_space.h"
#include "roomwise/simulation/furniture_catalogue.h"
#include "roomwise/simulation/home_model.h"
#include "roomwise/simulation/renderer.h"

namespace roomwise::bench {

// How a person with a camera looks at a piece of furniture.
struct PieceView {
  geometry::RigidTransform world_from_camera;
  double distance_m = 0;  // over the floor, to the piece's middle
  double aside_rad = 0;   // from straight before its front
  double share_seen = 0;  // of its surface: in the picture, and not behind something else
};

// At most `most` views of an object from where a person can stand in its room: 1 to 2.4 m from its
// middle, the camera 1.3 to 1.5 m high and aimed at it, not from behind, at least three quarters of
// it to be seen. Of these, those from slantwise before it, as near as shows it whole, half a metre
// apart.
[[nodiscard]] std::vector<PieceView> find_views(
    const simulation::HomeModel& home, std::size_t object, const simulation::TriangleMesh& mesh,
    const simulation::FreeSpace& space, const simulation::Renderer& renderer,
    const geometry::PinholeCamera& camera, std::size_t most, ThreadPool& pool);

}  // namespace roomwise::bench
