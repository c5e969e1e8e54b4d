#include "laboratory/simulation/render/shading.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "laboratory/simulation/scene/sampling.h"

namespace roomwise::simulation {
namespace {

constexpr float kShadingGap = 5e-4F;
constexpr int kMaxLayers = 4;  // of glass, one behind the other

// Schlick's approximation: a surface seen from the side mirrors more.
float mirror_share(float specular, float cosine) {
  const float m = 1 - std::clamp(cosine, 0.0F, 1.0F);
  const float m2 = m * m;
  return specular + (std::max(specular, 1.0F) - specular) * m2 * m2 * m;
}

}  // namespace

Eigen::Vector3f Shading::outside(const ViewRay& ray) const {
  if (!scene_.outside().seen_through_a_window(ray.origin, ray.direction)) {
    return Eigen::Vector3f::Zero();
  }
  return scene_.outside().radiance(ray.direction);
}

Eigen::Vector3f Shading::mirrored(const ViewRay& ray, const Eigen::Vector3f& point,
                                  const Eigen::Vector3f& normal, const SurfaceLook& look) const {
  const Eigen::Vector3f along = ray.direction.normalized();
  ViewRay mirror;
  mirror.origin = point;
  mirror.direction = along - 2 * normal.dot(along) * normal;
  if (mirror.direction.dot(normal) < 1e-3F) return Eigen::Vector3f::Zero();
  // What a rough surface mirrors is as blurred as its lobe is wide.
  mirror.spread = std::sqrt(2 / (look.shininess + 2));
  mirror.seed = ray.seed + 0x51ed27U;
  const auto hit = scene_.rays().first_hit(mirror.origin, mirror.direction, kShadingGap, 100,
                                           RayCaster::Meets::kOpaque);
  return hit ? surface(mirror, *hit, false) : outside(mirror);
}

Eigen::Vector3f Shading::surface(const ViewRay& ray, const RayHit& hit, bool with_mirror) const {
  const SceneTriangle& triangle = scene_.triangles()[hit.triangle];
  const bool is_front = scene_.is_front(hit, ray.direction);
  const Eigen::Vector3f plane = is_front ? triangle.normal : Eigen::Vector3f(-triangle.normal);
  const Eigen::Vector3f hit_point = ray.origin + hit.distance * ray.direction;
  const Eigen::Vector3f point = hit_point + kShadingGap * plane;
  const Eigen::Vector3f normal = triangle.patch >= 0 ? plane : scene_.normal_at(hit, ray.direction);
  const float length = ray.direction.norm();
  const float cosine = std::max(0.02F, -plane.dot(ray.direction) / length);
  // Seen from the side a footprint is long; a compromise between blur along and flicker across.
  const float footprint = ray.spread * hit.distance / std::sqrt(cosine);

  const SurfaceLook look = scene_.look_at(hit, hit_point, footprint);
  const Eigen::Vector3f illuminance =
      light_.at(scene_, hit, hit_point, ray.direction) + sunlight(ray, point, normal);
  const Eigen::Vector3f diffuse = look.albedo.cwiseProduct(illuminance) / kPi;
  Eigen::Vector3f radiance = scene_.appearances()[triangle.appearance].emission() + diffuse;
  if (look.specular <= 0) return radiance;

  const float share = mirror_share(look.specular, -normal.dot(ray.direction) / length);
  // A dull surface mirrors the room as a whole, a shiny one a picture of it.
  const float sharpness = smooth_step(8, 60, look.shininess);
  const Eigen::Vector3f room = 0.5F * illuminance / kPi;
  if (!with_mirror || share * sharpness < ray.faintest_mirror)
    return radiance + share * (room - diffuse);
  const Eigen::Vector3f image = mirrored(ray, point, normal, look);
  radiance += share * (room + sharpness * (image - room) - diffuse);
  return radiance;
}

Eigen::Vector3f Shading::sunlight(const ViewRay& ray, const Eigen::Vector3f& point,
                                  const Eigen::Vector3f& normal) const {
  if (!ray.in_sun) {
    std::uint64_t rays = 0;
    return emitters_.sun(point, normal, ray.seed, rays);
  }
  if (!*ray.in_sun) return Eigen::Vector3f::Zero();
  const Outside& outside = scene_.outside();
  return std::max(0.0F, normal.dot(outside.sun_direction())) * outside.sun_illuminance();
}

bool Shading::is_in_sun(const ViewRay& ray, const RayHit& hit) const {
  const Outside& outside = scene_.outside();
  if (!outside.has_sun()) return false;
  const SceneTriangle& triangle = scene_.triangles()[hit.triangle];
  const Eigen::Vector3f plane =
      scene_.is_front(hit, ray.direction) ? triangle.normal : Eigen::Vector3f(-triangle.normal);
  if (plane.dot(outside.sun_direction()) <= 0) return false;
  const Eigen::Vector3f point = ray.origin + hit.distance * ray.direction + kShadingGap * plane;
  return outside.seen_through_a_window(point, outside.sun_direction()) &&
         !scene_.rays().is_blocked(point, outside.sun_direction(), 0, 100);
}

Eigen::Vector3f Shading::radiance(const ViewRay& ray, const std::optional<RayHit>& first) const {
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  float left = 1;
  std::optional<RayHit> hit = first;
  for (int layer = 0; hit; ++layer) {
    const float opacity =
        scene_.appearances()[scene_.triangles()[hit->triangle].appearance].opacity();
    if (hit->triangle < scene_.opaque_count() || layer == kMaxLayers) {
      return sum + left * surface(ray, *hit, layer == 0);
    }
    sum += left * surface(ray, *hit, true) * std::max(opacity, 0.0F);
    left *= 1 - opacity;
    hit = scene_.rays().first_hit(ray.origin, ray.direction, hit->distance * (1 + 1e-5F) + 1e-5F,
                                  100, RayCaster::Meets::kEverything);
  }
  return sum + left * outside(ray);
}

}  // namespace roomwise::simulation
