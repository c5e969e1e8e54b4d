#pragma once

#include <cstddef>
#include <vector>

#include "laboratory/simulation/furniture/furniture_catalogue.h"
#include "laboratory/simulation/home/free_space.h"
#include "laboratory/simulation/home/home_model.h"
#include "laboratory/simulation/render/renderer.h"
#include "laboratory/simulation/walk/walk.h"
#include "roomwise/base/thread_pool.h"

// How a person with a camera looks at single pieces of furniture.
namespace roomwise::simulation {

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
[[nodiscard]] std::vector<PieceView> find_views(const HomeModel& home, std::size_t object,
                                                const TriangleMesh& mesh, const FreeSpace& space,
                                                const Renderer& renderer,
                                                const geometry::PinholeCamera& camera,
                                                std::size_t most, ThreadPool& pool);

// Where a person can stand before a piece, in its room.
struct StandingPlace {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
  double distance_m = 0;  // as in PieceView
  double aside_rad = 0;
};
// On a grid of 10 cm, not from behind.
[[nodiscard]] std::vector<StandingPlace> places_before(const HomeModel& home, std::size_t object,
                                                       const FreeSpace& space, double nearest_m,
                                                       double farthest_m);

// The radius of a person who stands somewhere.
constexpr double kStandingRadius_m = 0.25;

// Points all over a piece, evenly by area; world frame.
[[nodiscard]] std::vector<Eigen::Vector3d> points_on(const PlacedObject& piece,
                                                     const TriangleMesh& mesh);

// The share of an object's points that a frame shows: in the picture, and not behind something
// else.
[[nodiscard]] double share_seen(const std::vector<Eigen::Vector3d>& points_world,
                                std::size_t object, const RenderedFrame& frame,
                                const geometry::PinholeCamera& camera,
                                const geometry::RigidTransform& world_from_camera);

// The pose of a camera that is held upright.
[[nodiscard]] geometry::RigidTransform looking_at(const Eigen::Vector3d& from,
                                                  const Eigen::Vector3d& at);

// The same picture with a quarter of the pixels along each side, to test what it shows.
[[nodiscard]] geometry::PinholeCamera coarse(geometry::PinholeCamera camera);

// A person who turns and steps aside while the shutter is open, as long as on a walk. `pace` 1:
// at half of a walk's fastest.
[[nodiscard]] WalkPose moving_pose(const geometry::RigidTransform& world_from_camera,
                                   std::size_t room, double pace = 1);

}  // namespace roomwise::simulation
