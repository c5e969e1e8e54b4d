#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>

#include "laboratory/simulation/furniture/furniture_catalogue.h"
#include "laboratory/simulation/scene/mip_texture.h"
#include "laboratory/simulation/scene/textures.h"

namespace roomwise::simulation {

// A place on a surface as its appearance needs it.
struct SurfacePlace {
  Eigen::Vector2f plane_m = Eigen::Vector2f::Zero();  // along a wall and its height, or x and y
  Eigen::Vector2f uv = Eigen::Vector2f::Zero();       // texture coordinates
  float footprint_m = 0;                              // the width that one sample stands for
  float uv_per_m = 0;                                 // how fast uv changes along the surface
};

// What a surface looks like all over: plain, covered by a stored texture, a finish, a wall with a
// tiled strip, or a picture.
class Appearance {
 public:
  [[nodiscard]] static Appearance plain(const Eigen::Vector3f& albedo, float specular = 0,
                                        float shininess = 0);
  // `texture` is the material's, if it has one.
  [[nodiscard]] static Appearance material(const SurfaceMaterial& material,
                                           std::shared_ptr<const MipTexture> texture);
  [[nodiscard]] static Appearance finish(const Finish& finish);
  [[nodiscard]] static Appearance wall(const Room& room);
  [[nodiscard]] static Appearance picture(std::uint64_t seed);
  [[nodiscard]] static Appearance glass();
  // A lit panel: `radiance` is added to what it reflects.
  [[nodiscard]] static Appearance emitter(const Eigen::Vector3f& radiance);

  [[nodiscard]] SurfaceLook look(const SurfacePlace& place) const;
  // Its mean; for a wall at this height.
  [[nodiscard]] Eigen::Vector3f mean_albedo(float height_m) const;
  [[nodiscard]] const Eigen::Vector3f& emission() const { return emission_; }
  // Drawn without regard to the footprint, so that one sample a pixel would flicker.
  [[nodiscard]] bool is_detailed() const { return picture_seed_.has_value(); }
  [[nodiscard]] float opacity() const { return opacity_; }

 private:
  [[nodiscard]] bool in_strip(float height_m) const {
    return strip_ && height_m >= strip_from_m_ && height_m < strip_to_m_;
  }

  SurfaceLook plain_;
  Eigen::Vector3f emission_ = Eigen::Vector3f::Zero();
  float opacity_ = 1;
  std::shared_ptr<const MipTexture> texture_;
  std::optional<FinishTexture> finish_, strip_;
  float strip_from_m_ = 0, strip_to_m_ = 0;
  std::optional<std::uint64_t> picture_seed_;
};

}  // namespace roomwise::simulation
