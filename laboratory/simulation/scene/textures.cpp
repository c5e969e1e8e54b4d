#include "laboratory/simulation/scene/textures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "laboratory/simulation/scene/color_math.h"
#include "laboratory/simulation/scene/noise.h"

namespace roomwise::simulation {
namespace {

constexpr float kTurn = 2 * std::numbers::pi_v<float>;
// No real surface gives back more than this of the light.
constexpr float kWhitest = 0.85F;
// How much of the accent's colour the wallpapers show: stripes, ornaments, dots, print.
constexpr std::array<float, 4> kWallpaperShare{0.45F, 0.35F, 0.11F, 0.35F};

// How much of a feature of this width is left when seen through the footprint: 1 when it is much
// wider, 0 when it is narrower.
float visible_share(float feature_m, float footprint_m) {
  return 1 - smooth_step(0.3F, 1.1F, footprint_m / feature_m);
}

// The length of [.., x] that lies in lines of this width, centred on the multiples of the period.
float length_in_lines(float x, float period, float width) {
  const float shifted = x + width / 2;
  const int lines = floor_to_int(shifted / period);
  const float rest = shifted - static_cast<float>(lines) * period;
  return static_cast<float>(lines) * width + std::min(rest, width);
}

// The share of the footprint around x that lies in such lines.
float line_cover(float x, float period, float width, float footprint) {
  const float half = std::max(footprint, 1e-4F) / 2;
  return (length_in_lines(x + half, period, width) - length_in_lines(x - half, period, width)) /
         (2 * half);
}

float share_of_accent(Material material, std::uint32_t seed) {
  switch (material) {
    case Material::kWallpaper:
      return kWallpaperShare[seed % kWallpaperShare.size()];
    case Material::kBoards:
    case Material::kParquet:
      return 0.35F;
    case Material::kTiles:
      return 0.04F;
    case Material::kStone:
      return 0.15F;
    case Material::kPaint:
    case Material::kPlaster:
    case Material::kCarpet:
      break;
  }
  return 0;
}

}  // namespace

FinishTexture::FinishTexture(const Finish& finish)
    : material_(finish.material),
      color_(linear_from_srgb(finish.color).cwiseMin(kWhitest)),
      accent_(linear_from_srgb(finish.accent).cwiseMin(kWhitest)),
      scale_m_(std::max(0.02F, static_cast<float>(finish.scale_m))),
      seed_(static_cast<std::uint32_t>(finish.seed ^ (finish.seed >> 32))) {
  mean_albedo_ = mix(color_, accent_, share_of_accent(material_, seed_));
}

SurfaceLook FinishTexture::look(const Eigen::Vector2f& place_m, float footprint_m) const {
  SurfaceLook look = pattern(place_m, footprint_m);
  look.albedo = look.albedo.cwiseMin(kWhitest + 0.05F);
  return look;
}

SurfaceLook FinishTexture::pattern(const Eigen::Vector2f& place_m, float footprint_m) const {
  switch (material_) {
    case Material::kPaint:
      return paint(place_m, footprint_m);
    case Material::kWallpaper:
      return wallpaper(place_m, footprint_m);
    case Material::kPlaster:
      return plaster(place_m, footprint_m);
    case Material::kTiles:
      return tiles(place_m, footprint_m);
    case Material::kBoards:
      return boards(place_m, footprint_m);
    case Material::kParquet:
      return parquet(place_m, footprint_m);
    case Material::kCarpet:
      return carpet(place_m, footprint_m);
    case Material::kStone:
      return stone(place_m, footprint_m);
  }
  return {color_, 0, 0};
}

// Rolled-on paint: large faint clouds and the roller's fine grain.
SurfaceLook FinishTexture::paint(const Eigen::Vector2f& p, float footprint_m) const {
  float tone = 1 + 0.012F * smooth_noise(p.x() / 0.6F, p.y() / 0.6F, seed_);
  const float grain = visible_share(0.008F, footprint_m);
  if (grain > 0) {
    tone += 0.025F * grain * smooth_noise(p.x() / 0.008F, p.y() / 0.008F, seed_ + 1);
  }
  return {color_ * tone, 0, 0};
}

SurfaceLook FinishTexture::wallpaper(const Eigen::Vector2f& p, float footprint_m) const {
  const float x = p.x() / scale_m_, y = p.y() / scale_m_;
  const float shown = visible_share(scale_m_ / 4, footprint_m);
  float accent = 0;
  switch (seed_ % 4) {
    case 0:  // stripes, a broad and a narrow one
      accent = std::min(
          1.0F, line_cover(p.x(), scale_m_, 0.4F * scale_m_, footprint_m) +
                    line_cover(p.x() + 0.35F * scale_m_, scale_m_, 0.05F * scale_m_, footprint_m));
      break;
    case 1: {  // ornaments in staggered rows
      const float column = std::sin(kTurn * x), row = std::sin(kTurn * y);
      const float petal = column * row + 0.5F * std::cos(2 * kTurn * x) * std::cos(kTurn * y);
      accent = lerp(kWallpaperShare[1], smooth_step(0.05F, 0.25F, petal), shown);
      break;
    }
    case 2: {  // dots in a diamond lattice
      const float row = static_cast<float>(floor_to_int(2 * y));
      const float dx = fraction(2 * x + 0.5F * row) - 0.5F, dy = fraction(2 * y) - 0.5F;
      const float dot = 1 - smooth_step(0.15F, 0.22F, std::sqrt(dx * dx + dy * dy));
      accent = lerp(kWallpaperShare[2], dot, shown);
      break;
    }
    default:  // leaves of a soft, irregular print
      accent = lerp(0.35F,
                    smooth_step(0.0F, 0.12F,
                                layered_noise(3 * x + 0.7F * std::sin(kTurn * y), 2 * y, seed_, 3)),
                    shown);
      break;
  }
  const float fibre = visible_share(0.004F, footprint_m);
  float tone = 1;
  if (fibre > 0) tone += 0.03F * fibre * smooth_noise(p.x() / 0.004F, p.y() / 0.02F, seed_ + 3);
  return {mix(color_, accent_, accent) * tone, 0, 0};
}

SurfaceLook FinishTexture::plaster(const Eigen::Vector2f& p, float footprint_m) const {
  float tone = 1 + 0.02F * smooth_noise(p.x() / 0.4F, p.y() / 0.4F, seed_);
  const float trowel = visible_share(0.03F, footprint_m);
  if (trowel > 0) {
    tone += 0.06F * trowel * layered_noise(p.x() / 0.05F, p.y() / 0.03F, seed_ + 1, 3);
  }
  return {color_ * tone, 0, 0};
}

SurfaceLook FinishTexture::tiles(const Eigen::Vector2f& p, float footprint_m) const {
  const float joint_m = std::min(0.004F, scale_m_ / 15);
  const bool staggered = scale_m_ < 0.12F && seed_ % 2 == 0;  // as small wall tiles often are
  const float width_m = staggered ? 2 * scale_m_ : scale_m_;
  const int row = floor_to_int(p.y() / scale_m_);
  const float x = p.x() + (staggered && row % 2 != 0 ? width_m / 2 : 0);
  const int column = floor_to_int(x / width_m);
  const float across = line_cover(x, width_m, joint_m, footprint_m);
  const float along = line_cover(p.y(), scale_m_, joint_m, footprint_m);
  const float joint = across + along - across * along;
  const float shown = visible_share(scale_m_ / 2, footprint_m);
  float tone = 1 + 0.08F * shown * (unit_hash(column, row, seed_) - 0.5F);
  tone += 0.03F * visible_share(0.05F, footprint_m) *
          layered_noise(p.x() / 0.12F + static_cast<float>(column) * 3.1F,
                        p.y() / 0.12F + static_cast<float>(row) * 7.7F, seed_ + 5, 2);
  return {mix(color_ * tone, accent_, joint), 0.05F * (1 - joint), 400};
}

// The colour of one piece of wood with its grain along the first coordinate.
Eigen::Vector3f FinishTexture::wood(float along_m, float across_m, std::uint32_t piece,
                                    float footprint_m) const {
  const float tint = unit_from_bits(piece);
  const float shift = 13 * unit_from_bits(scramble(piece));
  float grain = 0;
  const float broad = visible_share(0.02F, footprint_m);
  if (broad > 0) {
    const float warp = 0.02F * smooth_noise(along_m / 0.4F + shift, across_m / 0.1F, seed_ + 7);
    grain += 0.5F * broad *
             smooth_noise(along_m / 0.8F + shift, (across_m + warp) / 0.012F + shift, seed_ + 8);
  }
  const float fine = visible_share(0.004F, footprint_m);
  if (fine > 0) {
    grain += 0.4F * fine * smooth_noise(along_m / 0.15F + shift, across_m / 0.003F, seed_ + 9);
  }
  const float accent = std::clamp(0.7F * tint + 0.28F * grain, 0.0F, 1.0F);
  return mix(color_, accent_, accent);
}

SurfaceLook FinishTexture::boards(const Eigen::Vector2f& p, float footprint_m) const {
  const bool turned = seed_ % 2 == 1;
  const float along = turned ? p.y() : p.x(), across = turned ? p.x() : p.y();
  const float length_m = 8 * scale_m_ + 0.4F;
  const int row = floor_to_int(across / scale_m_);
  const float shifted = along + length_m * unit_hash(row, 0, seed_ + 11);
  const int column = floor_to_int(shifted / length_m);
  const float sides = line_cover(across, scale_m_, 0.002F, footprint_m);
  const float ends = line_cover(shifted, length_m, 0.002F, footprint_m);
  const float joint = sides + ends - sides * ends;
  const float shown = visible_share(scale_m_ / 2, footprint_m);
  const Eigen::Vector3f piece =
      wood(shifted, across, hash_cell(column, row, seed_ + 12), footprint_m);
  return {mix(mean_albedo_, piece, shown) * (1 - 0.65F * joint), 0.035F * (1 - joint), 60};
}

// Squares of small strips, laid crosswise in turn.
SurfaceLook FinishTexture::parquet(const Eigen::Vector2f& p, float footprint_m) const {
  constexpr int kStrips = 5;
  const float square_m = scale_m_;
  const int column = floor_to_int(p.x() / square_m), row = floor_to_int(p.y() / square_m);
  const bool turned = (column + row) % 2 != 0;
  const float along = turned ? p.y() : p.x(), across = turned ? p.x() : p.y();
  const float strip_m = square_m / kStrips;
  const int strip = floor_to_int(across / strip_m);
  const float sides = line_cover(across, strip_m, 0.001F, footprint_m);
  const float ends = line_cover(along, square_m, 0.001F, footprint_m);
  const float joint = sides + ends - sides * ends;
  const std::uint32_t piece = scramble(hash_cell(column, row, seed_ + 21) +
                                       static_cast<std::uint32_t>(strip) * 0x9e3779b1U);
  const float shown = visible_share(strip_m / 2, footprint_m);
  const Eigen::Vector3f color = wood(along, across, piece, footprint_m);
  return {mix(mean_albedo_, color, shown) * (1 - 0.6F * joint), 0.035F * (1 - joint), 60};
}

SurfaceLook FinishTexture::carpet(const Eigen::Vector2f& p, float footprint_m) const {
  float tone = 1 + 0.05F * layered_noise(p.x() / 0.3F, p.y() / 0.3F, seed_, 2);
  const float tufts = visible_share(0.006F, footprint_m);
  if (tufts > 0) {
    tone += 0.35F * tufts * smooth_noise(p.x() / 0.006F, p.y() / 0.006F, seed_ + 1);
  }
  const float trodden = visible_share(0.04F, footprint_m);
  tone += 0.08F * trodden * smooth_noise(p.x() / 0.04F, p.y() / 0.05F, seed_ + 2);
  return {color_ * tone, 0, 0};
}

SurfaceLook FinishTexture::stone(const Eigen::Vector2f& p, float footprint_m) const {
  const int row = floor_to_int(p.y() / scale_m_), column = floor_to_int(p.x() / scale_m_);
  const float joint_x = line_cover(p.x(), scale_m_, 0.002F, footprint_m);
  const float joint_y = line_cover(p.y(), scale_m_, 0.002F, footprint_m);
  const float joint = joint_x + joint_y - joint_x * joint_y;
  // Every slab is cut from another place of the rock.
  const float dx = 19 * unit_hash(column, row, seed_ + 31);
  const float dy = 23 * unit_hash(column, row, seed_ + 32);
  const float x = p.x() / 0.35F + dx, y = p.y() / 0.35F + dy;
  const float shown = visible_share(0.05F, footprint_m);
  const float cloud = layered_noise(x, y, seed_, 3);
  const float bend = layered_noise(x + 4, y, seed_ + 33, 3);
  const float vein = 1 - smooth_step(0.0F, 0.09F, std::abs(bend));
  const float accent = std::clamp(0.15F + 0.3F * cloud * shown + 0.45F * vein * shown, 0.0F, 1.0F);
  return {mix(color_, accent_, accent) * (1 - 0.4F * joint), 0.05F * (1 - joint), 300};
}

}  // namespace roomwise::simulation
