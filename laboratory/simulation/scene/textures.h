#pragma once

#include <Eigen/Core>

#include "laboratory/simulation/home/home_model.h"

namespace roomwise::simulation {

// How a point of a surface takes light; colours linear.
struct SurfaceLook {
  Eigen::Vector3f albedo = Eigen::Vector3f::Constant(0.6F);
  float specular = 0;  // share of light that is mirrored at normal incidence
  float shininess = 0;
};

// The pattern of a floor, wall or ceiling as a function of the place on it. Nothing finer than the
// footprint is drawn, so that a distant pattern fades to its mean instead of flickering.
class FinishTexture {
 public:
  explicit FinishTexture(const Finish& finish);

  // place_m: along the surface (for walls the second coordinate is the height); footprint_m: the
  // width that one sample stands for.
  [[nodiscard]] SurfaceLook look(const Eigen::Vector2f& place_m, float footprint_m) const;
  // About the mean of the pattern.
  [[nodiscard]] const Eigen::Vector3f& mean_albedo() const { return mean_albedo_; }

 private:
  [[nodiscard]] SurfaceLook pattern(const Eigen::Vector2f& p, float footprint_m) const;
  [[nodiscard]] SurfaceLook paint(const Eigen::Vector2f& p, float footprint_m) const;
  [[nodiscard]] SurfaceLook wallpaper(const Eigen::Vector2f& p, float footprint_m) const;
  [[nodiscard]] SurfaceLook plaster(const Eigen::Vector2f& p, float footprint_m) const;
  [[nodiscard]] SurfaceLook tiles(const Eigen::Vector2f& p, float footprint_m) const;
  [[nodiscard]] SurfaceLook boards(const Eigen::Vector2f& p, float footprint_m) const;
  [[nodiscard]] SurfaceLook parquet(const Eigen::Vector2f& p, float footprint_m) const;
  [[nodiscard]] SurfaceLook carpet(const Eigen::Vector2f& p, float footprint_m) const;
  [[nodiscard]] SurfaceLook stone(const Eigen::Vector2f& p, float footprint_m) const;
  [[nodiscard]] Eigen::Vector3f wood(float along_m, float across_m, std::uint32_t piece,
                                     float footprint_m) const;

  Material material_;
  Eigen::Vector3f color_, accent_, mean_albedo_;
  float scale_m_;
  std::uint32_t seed_;
};

}  // namespace roomwise::simulation
