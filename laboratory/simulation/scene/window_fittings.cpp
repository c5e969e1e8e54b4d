#include "laboratory/simulation/scene/window_fittings.h"

#include <cmath>
#include <numbers>

#include "laboratory/simulation/home/openings.h"
#include "laboratory/simulation/scene/color_math.h"
#include "laboratory/simulation/scene/noise.h"

namespace roomwise::simulation {
namespace {

constexpr float kProfile = 0.055F;  // width of a bar of the frame

// A window in its opening, with the inner side at positive `in`.
struct Place {
  OpeningAxes axes;
  float inwards;  // +1 or -1: the room lies towards positive or negative across
  float half_width, bottom, top, half_wall;

  [[nodiscard]] Eigen::Vector3f at(float along, float in, float up) const {
    return axes.at(along, inwards * in, up);
  }
  [[nodiscard]] Eigen::Vector3f in() const { return inwards * axes.across; }
};

void add_box(Fittings& fittings, const Place& place, float along_from, float along_to,
             float in_from, float in_to, float up_from, float up_to, std::uint32_t look) {
  fittings.add_box(place.at(along_from, in_from, up_from),
                   (along_to - along_from) * place.axes.along, (in_to - in_from) * place.in(),
                   (up_to - up_from) * Eigen::Vector3f::UnitZ(), look);
}

void add_bars(Fittings& fittings, const Place& p, std::uint32_t look) {
  const float from = -0.035F, to = 0.03F;
  add_box(fittings, p, -p.half_width, p.half_width, from, to, p.bottom, p.bottom + kProfile, look);
  add_box(fittings, p, -p.half_width, p.half_width, from, to, p.top - kProfile, p.top, look);
  for (const float side : {-1.0F, 1.0F}) {
    add_box(fittings, p, side * p.half_width, side * (p.half_width - kProfile), from, to,
            p.bottom + kProfile, p.top - kProfile, look);
  }
  const int sashes = std::max(1, static_cast<int>(std::lround(2 * p.half_width / 0.75F)));
  for (int sash = 1; sash < sashes; ++sash) {
    const float middle =
        -p.half_width + 2 * p.half_width * static_cast<float>(sash) / static_cast<float>(sashes);
    add_box(fittings, p, middle - 0.04F, middle + 0.04F, from, to, p.bottom + kProfile,
            p.top - kProfile, look);
  }
}

// The lining of the hole and the sill.
void add_reveal(Fittings& fittings, const Place& p, std::uint32_t look) {
  const Eigen::Vector3f along = 2 * p.half_width * p.axes.along;
  const Eigen::Vector3f depth = 2 * p.half_wall * p.in();
  const Eigen::Vector3f up = (p.top - p.bottom) * Eigen::Vector3f::UnitZ();
  const Eigen::Vector3f low = p.at(-p.half_width, -p.half_wall, p.bottom);
  fittings.add_quad(low, along, depth, look);
  fittings.add_quad(low + up, along, depth, look);
  fittings.add_quad(low, depth, up, look);
  fittings.add_quad(low + along, depth, up, look);
  add_box(fittings, p, -p.half_width - 0.05F, p.half_width + 0.05F, p.half_wall,
          p.half_wall + 0.11F, p.bottom - 0.015F, p.bottom + 0.015F, look);
}

// One curtain, drawn aside into folds.
void add_curtain(Fittings& fittings, const Place& p, float from, float to, std::uint32_t look) {
  constexpr int kRows = 16;
  constexpr float kFold = 0.085F, kDepth = 0.028F, kStep = 0.0107F;
  const int columns = static_cast<int>((to - from) / kStep);
  const float high = p.top + 0.14F, low = 0.04F, off_wall = p.half_wall + 0.075F;
  const auto first = static_cast<std::uint32_t>(fittings.mesh.positions.size());
  for (int row = 0; row <= kRows; ++row) {
    const float t = static_cast<float>(row) / kRows;
    for (int column = 0; column <= columns; ++column) {
      const float along = from + static_cast<float>(column) * kStep;
      const float phase = 2 * std::numbers::pi_v<float> * along / kFold +
                          0.8F * smooth_noise(3 * t, along / 0.2F, 77);
      const float depth = kDepth * (0.45F + 0.55F * t);
      const float slope = depth * 2 * std::numbers::pi_v<float> / kFold * std::cos(phase);
      fittings.mesh.positions.push_back(
          p.at(along, off_wall + depth * std::sin(phase), lerp(high, low, t)));
      fittings.mesh.normals.emplace_back((p.in() - slope * p.axes.along).normalized());
      fittings.mesh.texture_coordinates.emplace_back(along, t);
    }
  }
  const auto stride = static_cast<std::uint32_t>(columns + 1);
  // Its front is towards the room.
  const bool is_flipped =
      p.axes.along.cross(Eigen::Vector3f(-Eigen::Vector3f::UnitZ())).dot(p.in()) < 0;
  for (std::uint32_t row = 0; row < kRows; ++row) {
    for (std::uint32_t column = 0; column + 1 < stride; ++column) {
      const std::uint32_t a = first + row * stride + column;
      const std::uint32_t b = is_flipped ? a + stride : a + 1;
      const std::uint32_t c = is_flipped ? a + 1 : a + stride;
      fittings.mesh.triangles.push_back({{a, b, a + stride + 1}, look});
      fittings.mesh.triangles.push_back({{a, a + stride + 1, c}, look});
    }
  }
}

void add_curtains(Fittings& fittings, const Place& p, std::uint32_t seed) {
  const float hue = unit_from_bits(scramble(seed));
  const Eigen::Vector3f cloth = hue < 0.5F    ? Eigen::Vector3f(0.62F, 0.57F, 0.47F)
                                : hue < 0.7F  ? Eigen::Vector3f(0.30F, 0.36F, 0.42F)
                                : hue < 0.85F ? Eigen::Vector3f(0.42F, 0.20F, 0.16F)
                                              : Eigen::Vector3f(0.33F, 0.40F, 0.27F);
  const std::uint32_t look = fittings.add_look(Appearance::plain(cloth));
  const std::uint32_t metal =
      fittings.add_look(Appearance::plain(Eigen::Vector3f(0.3F, 0.29F, 0.28F), 0.3F, 100));
  const float outer = p.half_width + 0.16F, inner = p.half_width * 0.72F;
  add_curtain(fittings, p, -outer, -inner, look);
  add_curtain(fittings, p, inner, outer, look);
  add_box(fittings, p, -outer - 0.08F, outer + 0.08F, p.half_wall + 0.065F, p.half_wall + 0.085F,
          p.top + 0.135F, p.top + 0.155F, metal);
}

}  // namespace

void add_window(Fittings& fittings, const Window& window, float wall_thickness_m,
                std::uint32_t seed) {
  const Place place{OpeningAxes(window.opening),
                    window.outside_is_positive ? -1.0F : 1.0F,
                    static_cast<float>(window.opening.width_m / 2),
                    static_cast<float>(window.opening.bottom_m),
                    static_cast<float>(window.opening.top_m),
                    wall_thickness_m / 2};
  const std::uint32_t white =
      fittings.add_look(Appearance::plain(Eigen::Vector3f(0.76F, 0.76F, 0.74F), 0.04F, 80));
  const std::uint32_t glass = fittings.add_look(Appearance::glass());
  add_bars(fittings, place, white);
  add_reveal(fittings, place, white);
  fittings.add_quad(place.at(-place.half_width, 0, place.bottom),
                    2 * place.half_width * place.axes.along,
                    (place.top - place.bottom) * Eigen::Vector3f::UnitZ(), glass);
  if (window.has_curtains) add_curtains(fittings, place, seed);
}

}  // namespace roomwise::simulation
