#include "laboratory/simulation/scene/appearance.h"

#include <algorithm>

#include "laboratory/simulation/scene/picture_art.h"

namespace roomwise::simulation {

Appearance Appearance::plain(const Eigen::Vector3f& albedo, float specular, float shininess) {
  Appearance appearance;
  appearance.plain_ = {albedo, specular, shininess};
  return appearance;
}

Appearance Appearance::material(const SurfaceMaterial& material,
                                std::shared_ptr<const MipTexture> texture) {
  // A surface that gives back all light would never let it die; no real one gives back more than
  // nine tenths.
  Appearance appearance =
      plain(material.diffuse.cwiseMin(0.9F), material.specular, material.shininess);
  appearance.opacity_ = std::clamp(material.opacity, 0.0F, 1.0F);
  appearance.texture_ = std::move(texture);
  return appearance;
}

Appearance Appearance::finish(const Finish& finish) {
  Appearance appearance;
  appearance.finish_.emplace(finish);
  return appearance;
}

Appearance Appearance::wall(const Room& room) {
  Appearance appearance = finish(room.walls);
  if (room.tiled_walls) {
    appearance.strip_.emplace(*room.tiled_walls);
    appearance.strip_from_m_ = static_cast<float>(room.tiled_from_m);
    appearance.strip_to_m_ = static_cast<float>(room.tiled_to_m);
  }
  return appearance;
}

Appearance Appearance::picture(std::uint64_t seed) {
  Appearance appearance = plain(Eigen::Vector3f(0.3F, 0.3F, 0.3F));
  appearance.picture_seed_ = seed;
  return appearance;
}

Appearance Appearance::glass() {
  Appearance appearance = plain(Eigen::Vector3f::Zero(), 0.05F, 1000);
  appearance.opacity_ = 0.04F;
  return appearance;
}

Appearance Appearance::emitter(const Eigen::Vector3f& radiance) {
  Appearance appearance = plain(Eigen::Vector3f::Constant(0.8F));
  appearance.emission_ = radiance;
  return appearance;
}

SurfaceLook Appearance::look(const SurfacePlace& place) const {
  if (in_strip(place.plane_m.y())) return strip_->look(place.plane_m, place.footprint_m);
  if (finish_) return finish_->look(place.plane_m, place.footprint_m);
  SurfaceLook look = plain_;
  if (picture_seed_) {
    look.albedo = picture_color(*picture_seed_, place.uv.x(), place.uv.y());
  } else if (texture_) {
    const float texels_per_uv = static_cast<float>(std::max(texture_->width(), texture_->height()));
    look.albedo = look.albedo.cwiseProduct(
        texture_->color(place.uv, place.footprint_m * place.uv_per_m * texels_per_uv));
  }
  return look;
}

Eigen::Vector3f Appearance::mean_albedo(float height_m) const {
  if (in_strip(height_m)) return strip_->mean_albedo();
  if (finish_) return finish_->mean_albedo();
  return texture_ ? plain_.albedo.cwiseProduct(texture_->mean()) : plain_.albedo;
}

}  // namespace roomwise::simulation
