#include "laboratory/simulation/scene/door_fittings.h"

#include <array>
#include <cmath>

#include "laboratory/simulation/home/openings.h"
#include "laboratory/simulation/scene/color_math.h"

namespace roomwise::simulation {
namespace {

constexpr float kJamb = 0.03F;  // the frame inside the opening
constexpr float kArchitraveDepth = 0.015F;
constexpr float kLeafThickness = 0.04F;
constexpr float kField = 0.013F;  // how much deeper a leaf's panels lie

void add_frame(Fittings& fittings, const OpeningAxes& axes, float half_width, float top,
               float wall_thickness, std::uint32_t look) {
  const Eigen::Vector3f up = Eigen::Vector3f::UnitZ();
  const float half_depth = wall_thickness / 2 + kArchitraveDepth;
  for (const float side : {-1.0F, 1.0F}) {
    fittings.add_box(axes.at(side * half_width, -half_depth, 0), -side * kJamb * axes.along,
                     2 * half_depth * axes.across, top * up, look);
    fittings.add_box(axes.at(side * half_width, side * wall_thickness / 2, top),
                     kArchitraveDepth * side * axes.across, -side * half_width * 2 * axes.along,
                     kArchitrave * up, look);
    for (const float face : {-1.0F, 1.0F}) {
      fittings.add_box(axes.at(side * half_width, face * wall_thickness / 2, 0),
                       side * kArchitrave * axes.along, face * kArchitraveDepth * axes.across,
                       (top + kArchitrave) * up, look);
    }
  }
  fittings.add_box(axes.at(-half_width, -half_depth, top - kJamb), 2 * half_width * axes.along,
                   2 * half_depth * axes.across, kJamb * up, look);
}

// A leaf's own axes: from the hinge along the leaf, out of the face towards the side it opens to.
struct Leaf {
  Eigen::Vector3f hinge, along, out;
  float width = 0, height = 0;
};

void add_leaf_box(Fittings& fittings, const Leaf& leaf, std::array<float, 2> along,
                  std::array<float, 2> out, std::array<float, 2> up, std::uint32_t look) {
  fittings.add_box(
      leaf.hinge + along[0] * leaf.along + out[0] * leaf.out + up[0] * Eigen::Vector3f::UnitZ(),
      (along[1] - along[0]) * leaf.along, (out[1] - out[0]) * leaf.out,
      (up[1] - up[0]) * Eigen::Vector3f::UnitZ(), look);
}

void add_handles(Fittings& fittings, const Leaf& leaf) {
  const std::uint32_t metal =
      fittings.add_look(Appearance::plain(Eigen::Vector3f(0.35F, 0.34F, 0.32F), 0.4F, 200));
  const float at = leaf.width - 0.06F, height = 1.02F;
  for (const float side : {0.0F, 1.0F}) {
    const float face = side > 0 ? 0.0F : -kLeafThickness, sign = side > 0 ? 1.0F : -1.0F;
    add_leaf_box(fittings, leaf, {at - 0.018F, at + 0.018F}, {face, face + sign * 0.006F},
                 {height - 0.11F, height + 0.11F}, metal);
    add_leaf_box(fittings, leaf, {at - 0.01F, at + 0.01F}, {face, face + sign * 0.05F},
                 {height + 0.04F, height + 0.06F}, metal);
    add_leaf_box(fittings, leaf, {at - 0.12F, at + 0.01F},
                 {face + sign * 0.038F, face + sign * 0.056F}, {height + 0.04F, height + 0.06F},
                 metal);
  }
}

// Four slopes that lead from a field's edge down to it, on the face at `face` (0 or the leaf's
// thickness behind): they catch the light differently and so draw the panel.
void add_slopes(Fittings& fittings, const Leaf& leaf, std::array<float, 2> along,
                std::array<float, 2> up, float face, std::uint32_t look) {
  const float sign = face < 0 ? -1.0F : 1.0F;
  const auto at = [&](float x, float depth, float z) {
    return Eigen::Vector3f(leaf.hinge + x * leaf.along + (face - sign * depth) * leaf.out +
                           z * Eigen::Vector3f::UnitZ());
  };
  const std::array<std::array<float, 2>, 4> corners{
      {{along[0], up[0]}, {along[1], up[0]}, {along[1], up[1]}, {along[0], up[1]}}};
  const float inset = 0.022F;
  const auto inner = [&](std::size_t corner) {
    const auto [x, z] = corners[corner];
    return at(x + (x == along[0] ? inset : -inset), kField, z + (z == up[0] ? inset : -inset));
  };
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const std::size_t next = (i + 1) % corners.size();
    fittings.add_slope({at(corners[i][0], 0, corners[i][1]),
                        at(corners[next][0], 0, corners[next][1]), inner(next), inner(i)},
                       sign * leaf.out, look);
  }
}

// A thin core with stiles and rails on it, so that the fields between them lie deeper.
void add_leaf(Fittings& fittings, const Leaf& leaf, std::uint32_t style, std::uint32_t look) {
  const float stile = 0.11F;
  add_leaf_box(fittings, leaf, {0.002F, leaf.width - 0.002F}, {-kLeafThickness + kField, -kField},
               {0.012F, leaf.height - 0.002F}, look);
  std::vector<std::array<float, 2>> rails{{0.01F, 0.21F}};
  if (style % 3 != 2) rails.push_back({0.86F, 1.0F});
  if (style % 3 == 1) rails.push_back({1.45F, 1.54F});
  rails.push_back({leaf.height - stile, leaf.height});
  std::vector<std::array<float, 2>> columns{{stile, leaf.width - stile}};
  const float middle = leaf.width / 2;
  if (style % 3 != 2) columns = {{stile, middle - 0.05F}, {middle + 0.05F, leaf.width - stile}};

  const std::array<float, 2> whole{-kLeafThickness, 0};
  add_leaf_box(fittings, leaf, {0, stile}, whole, {0.01F, leaf.height}, look);
  add_leaf_box(fittings, leaf, {leaf.width - stile, leaf.width}, whole, {0.01F, leaf.height}, look);
  for (const auto& rail : rails) {
    add_leaf_box(fittings, leaf, {stile, leaf.width - stile}, whole, rail, look);
  }
  for (std::size_t i = 0; i + 1 < rails.size(); ++i) {
    const std::array<float, 2> up{rails[i][1], rails[i + 1][0]};
    if (columns.size() == 2) {
      add_leaf_box(fittings, leaf, {columns[0][1], columns[1][0]}, whole, up, look);
    }
    for (const auto& along : columns) {
      add_slopes(fittings, leaf, along, up, 0, look);
      add_slopes(fittings, leaf, along, up, -kLeafThickness, look);
    }
  }
  add_handles(fittings, leaf);
}

}  // namespace

void add_door(Fittings& fittings, const Door& door, float wall_thickness_m, std::uint32_t style) {
  const OpeningAxes axes(door.opening);
  const auto half_width = static_cast<float>(door.opening.width_m / 2);
  const auto top = static_cast<float>(door.opening.top_m);
  const std::uint32_t paint =
      fittings.add_look(Appearance::plain(linear_from_srgb(door.color), 0.035F, 25));
  const std::uint32_t threshold =
      fittings.add_look(Appearance::plain(Eigen::Vector3f(0.25F, 0.19F, 0.13F), 0.05F, 30));
  add_frame(fittings, axes, half_width, top, wall_thickness_m, paint);
  fittings.add_quad(axes.at(-half_width, -wall_thickness_m / 2 - 0.012F, 0.002F),
                    2 * half_width * axes.along, (wall_thickness_m + 0.024F) * axes.across,
                    threshold);
  if (!door.has_leaf) return;

  const float from_hinge = door.hinge_at_min ? 1.0F : -1.0F;
  const float opening_side = door.opens_to_positive ? 1.0F : -1.0F;
  const auto cosine = static_cast<float>(std::cos(door.open_rad));
  const auto sine = static_cast<float>(std::sin(door.open_rad));
  const Eigen::Vector3f shut = from_hinge * axes.along, side = opening_side * axes.across;
  Leaf leaf;
  leaf.hinge = axes.at(-from_hinge * (half_width - kJamb), opening_side * wall_thickness_m / 2, 0);
  leaf.along = cosine * shut + sine * side;
  leaf.out = cosine * side - sine * shut;
  leaf.width = 2 * (half_width - kJamb) - 0.003F;
  leaf.height = top - kJamb - 0.003F;
  add_leaf(fittings, leaf, style, paint);
}

}  // namespace roomwise::simulation
