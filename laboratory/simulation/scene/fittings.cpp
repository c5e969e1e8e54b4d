#include "laboratory/simulation/scene/fittings.h"

#include <array>
#include <cmath>
#include <numbers>

#include "laboratory/simulation/home/openings.h"
#include "laboratory/simulation/scene/color_math.h"
#include "laboratory/simulation/scene/door_fittings.h"
#include "laboratory/simulation/scene/noise.h"
#include "laboratory/simulation/scene/stair_fittings.h"
#include "laboratory/simulation/scene/window_fittings.h"

namespace roomwise::simulation {
namespace {

constexpr float kSkirtingHeight = 0.075F, kSkirtingDepth = 0.013F;

void add_skirting_piece(Fittings& fittings, const WallFace& face, float from_m, float to_m,
                        std::uint32_t look) {
  if (to_m - from_m < 0.02F) return;
  const Eigen::Vector3f start = face.origin + from_m * face.along;
  fittings.add_box(start, (to_m - from_m) * face.along, kSkirtingDepth * face.normal,
                   kSkirtingHeight * Eigen::Vector3f::UnitZ(), look);
}

void add_skirting(Fittings& fittings, const HomeModel& home) {
  const std::uint32_t white =
      fittings.add_look(Appearance::plain(Eigen::Vector3f(0.72F, 0.71F, 0.68F), 0.03F, 40));
  for (std::size_t room = 0; room < home.rooms.size(); ++room) {
    // Where tiles reach the floor there is no board.
    if (home.rooms[room].tiled_walls &&
        home.rooms[room].tiled_from_m - home.rooms[room].floor_m < 0.1)
      continue;
    if (home.rooms[room].open_floor) continue;  // nor where there is no floor
    for (const WallFace& face : wall_faces(home, room)) {
      std::vector<std::array<float, 2>> pieces{{0, face.length_m}};
      for (const WallFace::Hole& hole : face.holes) {
        if (!hole.is_door) continue;
        std::vector<std::array<float, 2>> left;
        for (const auto& [from, to] : pieces) {
          const float gap_from = hole.from_m - kArchitrave, gap_to = hole.to_m + kArchitrave;
          if (from < gap_from) left.push_back({from, std::min(to, gap_from)});
          if (to > gap_to) left.push_back({std::max(from, gap_to), to});
        }
        pieces = std::move(left);
      }
      for (const auto& [from, to] : pieces) add_skirting_piece(fittings, face, from, to, white);
    }
  }
}

void add_picture(Fittings& fittings, const WallPicture& picture) {
  static const std::array<Eigen::Vector3f, 4> kFrames{
      Eigen::Vector3f(0.03F, 0.02F, 0.015F), Eigen::Vector3f(0.25F, 0.13F, 0.05F),
      Eigen::Vector3f(0.65F, 0.63F, 0.6F), Eigen::Vector3f(0.35F, 0.25F, 0.1F)};
  const auto bits = scramble(static_cast<std::uint32_t>(picture.seed * 2654435761U + 1));
  const std::uint32_t frame =
      fittings.add_look(Appearance::plain(kFrames[bits % kFrames.size()], 0.04F, 50));
  const std::uint32_t paper =
      fittings.add_look(Appearance::plain(Eigen::Vector3f(0.75F, 0.74F, 0.7F)));
  const std::uint32_t art = fittings.add_look(Appearance::picture(picture.seed));

  const Eigen::Vector3f normal(static_cast<float>(picture.normal.x()),
                               static_cast<float>(picture.normal.y()), 0);
  const Eigen::Vector3f up = Eigen::Vector3f::UnitZ(), right = up.cross(normal);
  const auto width = static_cast<float>(picture.width_m);
  const auto height = static_cast<float>(picture.height_m);
  const Eigen::Vector3f corner = picture.center.cast<float>() - width / 2 * right - height / 2 * up;
  const float border = 0.025F, depth = 0.022F;
  const float margin = bits % 3 == 0 ? 0.0F : 0.14F * std::min(width, height);
  const auto bar = [&](float x, float y, float w, float h) {
    fittings.add_box(corner + x * right + y * up, w * right, h * up, depth * normal, frame);
  };
  bar(0, 0, width, border);
  bar(0, height - border, width, border);
  bar(0, border, border, height - 2 * border);
  bar(width - border, border, border, height - 2 * border);
  const auto sheet = [&](float inset, float z, std::uint32_t look) {
    fittings.add_quad(corner + inset * (right + up) + z * normal, (width - 2 * inset) * right,
                      (height - 2 * inset) * up, look);
  };
  if (margin > 0) sheet(border, 0.009F, paper);
  sheet(border + margin, 0.011F, art);
}

void add_ceiling_panel(Fittings& fittings, const Light& light, float ceiling_m) {
  const std::uint32_t rim =
      fittings.add_look(Appearance::plain(Eigen::Vector3f::Constant(0.7F), 0.03F, 40));
  const auto radius = static_cast<float>(light.radius_m);
  const Eigen::Vector3f radiance =
      light.is_on ? Eigen::Vector3f(color_of_temperature(light.color_temperature_k) *
                                    static_cast<float>(light.lumens) /
                                    (std::numbers::pi_v<float> * 4 * radius * radius))
                  : Eigen::Vector3f::Zero();
  const std::uint32_t glow = fittings.add_look(Appearance::emitter(radiance));
  const Eigen::Vector3f x = Eigen::Vector3f::UnitX(), y = Eigen::Vector3f::UnitY();
  const Eigen::Vector3f center(static_cast<float>(light.position.x()),
                               static_cast<float>(light.position.y()), ceiling_m);
  const float outer = radius + 0.02F;
  fittings.add_box(center - outer * (x + y) - 0.03F * Eigen::Vector3f::UnitZ(), 2 * outer * x,
                   2 * outer * y, 0.03F * Eigen::Vector3f::UnitZ(), rim);
  fittings.add_quad(center - radius * (x + y) - 0.031F * Eigen::Vector3f::UnitZ(), 2 * radius * y,
                    2 * radius * x, glow);
}

}  // namespace

std::uint32_t Fittings::add_look(Appearance look) {
  looks.push_back(std::move(look));
  return static_cast<std::uint32_t>(looks.size() - 1);
}

void Fittings::add_quad(const Eigen::Vector3f& origin, const Eigen::Vector3f& u,
                        const Eigen::Vector3f& v, std::uint32_t look) {
  add_slope({origin, origin + u, origin + u + v, origin + v}, u.cross(v), look);
}

void Fittings::add_slope(const std::array<Eigen::Vector3f, 4>& corners,
                         const Eigen::Vector3f& front, std::uint32_t look) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  const Eigen::Vector3f turn = (corners[2] - corners[0]).cross(corners[3] - corners[1]);
  const bool is_flipped = turn.dot(front) < 0;
  const Eigen::Vector3f normal = (is_flipped ? -turn : turn).normalized();
  static const std::array<Eigen::Vector2f, 4> kCorners{
      Eigen::Vector2f(0, 0), Eigen::Vector2f(1, 0), Eigen::Vector2f(1, 1), Eigen::Vector2f(0, 1)};
  for (std::size_t i = 0; i < corners.size(); ++i) {
    mesh.positions.push_back(corners[i]);
    mesh.normals.push_back(normal);
    mesh.texture_coordinates.push_back(kCorners[i]);
  }
  const std::uint32_t second = first + (is_flipped ? 3 : 1), last = first + (is_flipped ? 1 : 3);
  mesh.triangles.push_back({{first, second, first + 2}, look});
  mesh.triangles.push_back({{first, first + 2, last}, look});
}

void Fittings::add_box(const Eigen::Vector3f& origin, const Eigen::Vector3f& u,
                       const Eigen::Vector3f& v, const Eigen::Vector3f& w, std::uint32_t look) {
  // The faces' fronts must point outwards whichever way the three edges turn.
  const bool is_right_handed = u.cross(v).dot(w) > 0;
  const Eigen::Vector3f& a = is_right_handed ? u : v;
  const Eigen::Vector3f& b = is_right_handed ? v : u;
  add_quad(origin, b, a, look);
  add_quad(origin + w, a, b, look);
  add_quad(origin, a, w, look);
  add_quad(origin + b, w, a, look);
  add_quad(origin, w, b, look);
  add_quad(origin + a, b, w, look);
}

Fittings make_fittings(const HomeModel& home) {
  Fittings fittings;
  add_skirting(fittings, home);
  for (std::size_t door = 0; door < home.doors.size(); ++door) {
    add_door(fittings, home.doors[door], static_cast<float>(home.wall_thickness_m),
             scramble(static_cast<std::uint32_t>(home.seed)));
  }
  for (std::size_t window = 0; window < home.windows.size(); ++window) {
    add_window(fittings, home.windows[window], static_cast<float>(home.wall_thickness_m),
               scramble(static_cast<std::uint32_t>(home.seed + 31 * window)));
  }
  for (const WallPicture& picture : home.pictures) add_picture(fittings, picture);
  add_stair_rails(fittings, home);
  for (const Light& light : home.lights) {
    if (light.is_ceiling_panel) {
      const double ceiling_m = home.rooms[light.room].floor_m + home.ceiling_height_m;
      add_ceiling_panel(fittings, light, static_cast<float>(ceiling_m));
    }
  }
  return fittings;
}

}  // namespace roomwise::simulation
