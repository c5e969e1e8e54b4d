#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "laboratory/simulation/scene/home_meshes.h"
#include "laboratory/simulation/walk/piece_views.h"

// Pictures of a home to teach a network by: what each shows is known beforehand.
namespace roomwise::simulation {

struct HomeViewOptions {
  std::uint64_t seed = 0;
  std::size_t of_kind = 4;   // views of the pieces of one kind, at most
  std::size_t of_room = 8;   // views of a room, at most
  int longer_side_px = 184;  // of the pictures
};

struct SampledView {
  std::string shows;  // "bed", "coffee table"; a room is "room: bedroom"
  geometry::PinholeCamera camera;
  geometry::RigidTransform world_from_camera;
  std::size_t room = 0;  // in which the camera is
  double pace = 0;       // of moving_pose()
};

// What a view of such a piece is said to show ("television" of a "tv"); empty for kinds that are
// not looked at: small things, and those that hang high or lie flat.
[[nodiscard]] std::string_view name_in_views(std::string_view furniture_kind);
// "room: living room".
[[nodiscard]] std::string name_in_views(RoomKind kind);

// Views of the pieces and rooms of a home, drawn by the seed: a person stands anywhere near the
// piece, or in the room, and holds a camera (upright, lying or square; its lens as a phone's, or
// drawn nearer) at 1.2 to 1.6 m, not quite level and not quite at the middle. At least half of a
// piece is seen and it takes a good part of the picture; a view of a room is not filled by one
// piece or a near wall. What finds no such view in a few draws has fewer.
[[nodiscard]] Expected<std::vector<SampledView>> choose_home_views(const HomeModel& home,
                                                                   const MeshLoader& load,
                                                                   const Renderer& renderer,
                                                                   const HomeViewOptions& options,
                                                                   ThreadPool& pool);

}  // namespace roomwise::simulation
