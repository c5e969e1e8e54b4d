#include "laboratory/simulation/home/openings.h"

#include <cmath>

namespace roomwise::simulation {
namespace {

void cut_hole(std::vector<WallFace>& faces, const WallOpening& opening, double wall_thickness_m,
              bool is_door) {
  // The opening's middle lies half the wall's thickness behind the face; a centimetre of slack.
  const double reach = wall_thickness_m / 2 + 0.01;
  for (WallFace& face : faces) {
    if ((face.along.x() > 0.5F) != opening.along_x) continue;
    const Eigen::Vector3f center(static_cast<float>(opening.center.x()),
                                 static_cast<float>(opening.center.y()), 0);
    if (std::abs(face.normal.dot(center - face.origin)) > reach) continue;
    const float middle = face.along.dot(center - face.origin);
    const auto half = static_cast<float>(opening.width_m / 2);
    if (middle + half < 0 || middle - half > face.length_m) continue;
    face.holes.push_back({middle - half, middle + half, static_cast<float>(opening.bottom_m),
                          static_cast<float>(opening.top_m), is_door});
  }
}

}  // namespace

OpeningAxes::OpeningAxes(const WallOpening& opening)
    : center(static_cast<float>(opening.center.x()), static_cast<float>(opening.center.y()),
             static_cast<float>(opening.floor_m)),
      along(opening.along_x ? Eigen::Vector3f::UnitX() : Eigen::Vector3f::UnitY()),
      across(opening.along_x ? Eigen::Vector3f::UnitY() : Eigen::Vector3f::UnitX()) {}

std::vector<WallFace> wall_faces(const HomeModel& home, std::size_t room) {
  const Eigen::Vector2f low = home.rooms[room].interior.min.cast<float>();
  const Eigen::Vector2f high = home.rooms[room].interior.max.cast<float>();
  const Eigen::Vector2f size = high - low;
  const auto floor = static_cast<float>(home.rooms[room].floor_m);
  const Eigen::Vector3f corner(low.x(), low.y(), floor);
  const Eigen::Vector3f x = Eigen::Vector3f::UnitX(), y = Eigen::Vector3f::UnitY();
  std::vector<WallFace> faces{{corner, x, y, size.x(), {}},
                              {Eigen::Vector3f(low.x(), high.y(), floor), x, -y, size.x(), {}},
                              {corner, y, x, size.y(), {}},
                              {Eigen::Vector3f(high.x(), low.y(), floor), y, -x, size.y(), {}}};
  for (const Door& door : home.doors) {
    if (door.room == room || door.other_room == room) {
      cut_hole(faces, door.opening, home.wall_thickness_m, true);
    }
  }
  for (const Window& window : home.windows) {
    if (window.room == room) cut_hole(faces, window.opening, home.wall_thickness_m, false);
  }
  return faces;
}

}  // namespace roomwise::simulation
