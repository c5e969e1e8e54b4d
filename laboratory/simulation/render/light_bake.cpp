#include "laboratory/simulation/render/light_bake.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <functional>
#include <numbers>
#include <span>

#include "laboratory/simulation/render/corner_light.h"
#include "laboratory/simulation/render/light_filter.h"
#include "laboratory/simulation/render/light_points.h"
#include "laboratory/simulation/scene/color_math.h"
#include "laboratory/simulation/scene/sampling.h"
#include "roomwise/base/stage_clock.h"

namespace roomwise::simulation {
namespace {

constexpr int kFirstBounceRays = 20, kLastBounceRays = 56;
// Indirect light brighter than this many times the home's mean is cut: no bright specks.
constexpr float kBrightest = 12;
constexpr std::size_t kChunk = CornerLight::kChunk;  // points that one thread takes at a time

// The radiance that surfaces send out, as gathering rays find it: a value a texel, and one a side
// of every other triangle.
struct Radiosity {
  std::vector<Eigen::Vector3f> texels;
  std::array<std::vector<Eigen::Vector3f>, 2> triangles;
  float brightest = 0;
};

std::vector<Flux> sum_of(std::vector<Flux> a, const std::vector<Flux>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] += b[i];
  return a;
}

class Baker {
 public:
  Baker(const Scene& scene, const Emitters& emitters, double effort, ThreadPool& pool,
        Progress& progress)
      : scene_(scene),
        emitters_(emitters),
        effort_(effort),
        pool_(pool),
        progress_(progress),
        corners_(scene, pool) {
    rays_ += corners_.rays();
    for (const Patch& patch : scene.patches()) {
      for (int row = 0; row < patch.rows; ++row) {
        for (int column = 0; column < patch.columns; ++column) {
          texels_.push_back(
              {patch.texel_center(column, row) + kGap * patch.normal, patch.normal, 1});
        }
      }
    }
    is_buried_.resize(texels_.size());
    pool.parallel_for((texels_.size() + kChunk - 1) / kChunk, [&](std::size_t chunk) {
      for (std::size_t i = chunk * kChunk; i < std::min((chunk + 1) * kChunk, texels_.size());
           ++i) {
        is_buried_[i] =
            openness_of(scene.rays(), texels_[i], static_cast<std::uint32_t>(i)) < kMinOpenness;
      }
    });
    rays_ += texels_.size() * kOpennessRays;
  }

  Expected<BakedLight> bake(BakeStatistics& statistics);

 private:
  [[nodiscard]] std::size_t point_count() const {
    return texels_.size() + corners_.points().size();
  }
  [[nodiscard]] const LightPoint& point(std::size_t index) const {
    return index < texels_.size() ? texels_[index] : corners_.points()[index - texels_.size()];
  }
  // Calls visit(round, from, to) for ranges that make up 0 to count, in parallel, and so again in
  // every round once the one before is done.
  Expected<void> in_chunks(
      std::string_view work, int rounds, std::size_t count,
      const std::function<void(int round, std::size_t from, std::size_t to)>& visit);
  // Calls gather(index, rays) for every point and keeps what it returns.
  Expected<std::vector<Flux>> at_all_points(
      std::string_view work,
      const std::function<Flux(std::size_t index, std::uint64_t& rays)>& gather);
  [[nodiscard]] Flux gather(std::size_t index, const Radiosity& radiosity, int count,
                            std::uint64_t& rays) const;
  [[nodiscard]] Eigen::Vector3f sent_back(const Radiosity& radiosity, const Eigen::Vector3f& origin,
                                          const Eigen::Vector3f& direction,
                                          std::uint64_t& rays) const;
  [[nodiscard]] std::vector<Eigen::Vector3f> texel_light(const std::vector<Flux>& fluxes) const;
  [[nodiscard]] Radiosity radiosity_of(const std::vector<Flux>& fluxes) const;
  Expected<BakedLight> finish(const std::vector<Flux>& direct, const std::vector<Flux>& indirect);
  void let_shades_glow(BakedLight& light) const;

  const Scene& scene_;
  const Emitters& emitters_;
  double effort_;
  ThreadPool& pool_;
  Progress& progress_;
  std::vector<LightPoint> texels_;
  std::vector<std::uint8_t> is_buried_;  // a texel a place; bytes, to be written by many threads
  CornerPoints corners_;
  std::atomic<std::uint64_t> rays_ = 0;
};

Expected<void> Baker::in_chunks(std::string_view work, int rounds, std::size_t count,
                                const std::function<void(int, std::size_t, std::size_t)>& visit) {
  constexpr std::size_t kChunksPerReport = 32;
  progress_.begin(work, static_cast<std::size_t>(rounds) * count);
  const std::size_t chunks = (count + kChunk - 1) / kChunk;
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t first = 0; first < chunks; first += kChunksPerReport) {
      if (progress_.interrupted()) {
        progress_.end();
        return fail_with(ErrorCode::kInterrupted,
                         "the light was not baked to its end: interrupted");
      }
      pool_.parallel_for(std::min(kChunksPerReport, chunks - first), [&](std::size_t chunk) {
        const std::size_t from = (first + chunk) * kChunk;
        visit(round, from, std::min(from + kChunk, count));
      });
      progress_.advance(static_cast<std::size_t>(round) * count +
                            std::min((first + kChunksPerReport) * kChunk, count),
                        "");
    }
  }
  progress_.end();
  return {};
}

Expected<std::vector<Flux>> Baker::at_all_points(
    std::string_view work, const std::function<Flux(std::size_t, std::uint64_t&)>& gather) {
  std::vector<Flux> fluxes(point_count());
  ROOMWISE_RETURN_IF_ERROR(
      in_chunks(work, 1, point_count(), [&](int /*round*/, std::size_t from, std::size_t to) {
        std::uint64_t rays = 0;
        for (std::size_t i = from; i < to; ++i) fluxes[i] = gather(i, rays);
        rays_ += rays;
      }));
  return fluxes;
}

// The radiance that comes back along a ray; none where it leaves through a window, since windows
// are emitters.
Eigen::Vector3f Baker::sent_back(const Radiosity& radiosity, const Eigen::Vector3f& origin,
                                 const Eigen::Vector3f& direction, std::uint64_t& rays) const {
  ++rays;
  const auto hit = scene_.rays().first_hit(origin, direction, 0, 100, RayCaster::Meets::kOpaque);
  if (!hit) return Eigen::Vector3f::Zero();
  const SceneTriangle& triangle = scene_.triangles()[hit->triangle];
  const bool is_front = triangle.normal.dot(direction) <= 0;
  if (triangle.patch < 0) return radiosity.triangles[is_front ? 0 : 1][hit->triangle];
  if (!is_front) return Eigen::Vector3f::Zero();
  const Patch& patch = scene_.patches()[static_cast<std::size_t>(triangle.patch)];
  const Eigen::Vector3f offset = origin + hit->distance * direction - patch.origin;
  const int column = std::clamp(static_cast<int>(patch.along.dot(offset) / patch.texel_width_m()),
                                0, patch.columns - 1);
  const int row = std::clamp(static_cast<int>(patch.up.dot(offset) / patch.texel_height_m()), 0,
                             patch.rows - 1);
  return radiosity
      .texels[patch.first_texel + static_cast<std::size_t>(row * patch.columns + column)];
}

Flux Baker::gather(std::size_t index, const Radiosity& radiosity, int count,
                   std::uint64_t& rays) const {
  const LightPoint& at = point(index);
  const TangentAxes axes(at.normal);
  const EvenPoints points(static_cast<std::uint32_t>(index) * 2654435761U + 99);
  Flux flux = Flux::Zero();
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3f direction = cosine_direction(at.normal, axes, points.at(i));
    Eigen::Vector3f light = sent_back(radiosity, at.position, direction, rays);
    const float brightness = light.maxCoeff();
    if (brightness <= 0) continue;
    if (brightness > radiosity.brightest) light *= radiosity.brightest / brightness;
    // Samples lie as densely as the cosine is large; flux counts every direction alike.
    const float cosine = std::max(0.08F, at.normal.dot(direction));
    flux += direction * (light * (kPi / (cosine * static_cast<float>(count)))).transpose();
  }
  return flux;
}

std::vector<Eigen::Vector3f> Baker::texel_light(const std::vector<Flux>& fluxes) const {
  std::vector<Eigen::Vector3f> light(texels_.size());
  for (std::size_t i = 0; i < texels_.size(); ++i) {
    light[i] = (texels_[i].normal.transpose() * fluxes[i]).transpose();
  }
  return light;
}

Radiosity Baker::radiosity_of(const std::vector<Flux>& fluxes) const {
  Radiosity radiosity;
  radiosity.texels = texel_light(fluxes);
  filter_texels(scene_, Smoothness::kDirect, pool_, radiosity.texels);
  double sum = 0;
  for (const Patch& patch : scene_.patches()) {
    const Appearance& appearance = scene_.appearances()[patch.appearance];
    for (int row = 0; row < patch.rows; ++row) {
      for (int column = 0; column < patch.columns; ++column) {
        const std::size_t i = patch.texel_index(column, row);
        const Eigen::Vector3f albedo =
            appearance.mean_albedo(patch.up.dot(patch.texel_center(column, row)));
        radiosity.texels[i] = radiosity.texels[i].cwiseProduct(albedo) / kPi;
        sum += static_cast<double>(radiosity.texels[i].maxCoeff());
      }
    }
  }
  radiosity.brightest = kBrightest * static_cast<float>(sum / static_cast<double>(texels_.size()));

  const std::vector<Flux> corner_fluxes(
      fluxes.begin() + static_cast<std::ptrdiff_t>(texels_.size()), fluxes.end());
  const auto& triangles = scene_.triangles();
  for (const int side : {0, 1}) {
    auto& values = radiosity.triangles[static_cast<std::size_t>(side)];
    values.assign(scene_.opaque_count(), Eigen::Vector3f::Zero());
    for (std::size_t i = 0; i < scene_.opaque_count(); ++i) {
      if (triangles[i].patch >= 0) continue;
      const Eigen::Vector3f light =
          corners_.at_middle(corner_fluxes, static_cast<std::uint32_t>(i), side);
      values[i] =
          light.cwiseProduct(scene_.appearances()[triangles[i].appearance].mean_albedo(0)) / kPi;
    }
  }
  return radiosity;
}

// A lamp's shade is thin: light that falls on its inner side shows on the outer one.
void Baker::let_shades_glow(BakedLight& light) const {
  constexpr float kReach = 0.45F, kGlow = 0.22F;
  for (const Emitter& lamp : emitters_.all()) {
    if (lamp.object == 0) continue;
    std::vector<bool> is_done(scene_.positions().size());
    for (const SceneTriangle& triangle : scene_.triangles()) {
      if (triangle.object != lamp.object) continue;
      for (const std::uint32_t corner : triangle.corners) {
        if (is_done[corner]) continue;
        is_done[corner] = true;
        const Eigen::Vector3f offset = scene_.positions()[corner] - lamp.center;
        if (offset.norm() > kReach || offset.z() < -0.14F) continue;
        const Eigen::Vector3f front = light.corners[0][corner], back = light.corners[1][corner];
        light.corners[0][corner] += kGlow * back;
        light.corners[1][corner] += kGlow * front;
      }
    }
  }
}

Expected<BakedLight> Baker::finish(const std::vector<Flux>& direct,
                                   const std::vector<Flux>& indirect) {
  BakedLight light;
  const std::size_t corners = scene_.positions().size();
  for (auto& values : light.corners) values.resize(corners);
  CornerLight corner_light(corners_, std::span(direct).subspan(texels_.size()),
                           std::span(indirect).subspan(texels_.size()));
  ROOMWISE_RETURN_IF_ERROR(in_chunks(
      "smoothing the light", CornerLight::kRounds, corners_.points().size(),
      [&](int round, std::size_t from, std::size_t to) { corner_light.smooth(round, from, to); }));
  ROOMWISE_RETURN_IF_ERROR(in_chunks("blending the light", 1, corners,
                                     [&](int /*round*/, std::size_t from, std::size_t to) {
                                       corner_light.blend(from, to, light.corners);
                                     }));
  let_shades_glow(light);

  light.texels = texel_light(direct);
  fill_buried_texels(scene_, is_buried_, light.texels);
  filter_texels(scene_, Smoothness::kDirect, pool_, light.texels);
  std::vector<Eigen::Vector3f> bounced = texel_light(indirect);
  fill_buried_texels(scene_, is_buried_, bounced);
  filter_texels(scene_, Smoothness::kBounced, pool_, bounced);
  for (std::size_t i = 0; i < bounced.size(); ++i) light.texels[i] += bounced[i];
  return light;
}

Expected<BakedLight> Baker::bake(BakeStatistics& statistics) {
  const auto rays_of = [this](int count) {
    return std::max(8, static_cast<int>(std::lround(count * effort_)));
  };
  ROOMWISE_TRY(const std::vector<Flux> direct,
               at_all_points("baking direct light", [&](std::size_t i, std::uint64_t& rays) {
                 return emitters_.flux(point(i).position, point(i).normal,
                                       static_cast<std::uint32_t>(i) * 747796405U + 1, rays);
               }));
  ROOMWISE_TRY(const std::vector<Flux> sun,
               at_all_points("baking the sun's light", [&](std::size_t i, std::uint64_t& rays) {
                 return emitters_.sun_bounce(point(i).position, point(i).normal,
                                             static_cast<std::uint32_t>(i) * 747796405U + 2, rays);
               }));
  const Radiosity lit = radiosity_of(sum_of(direct, sun));
  ROOMWISE_TRY(const std::vector<Flux> bounced,
               at_all_points("baking the first bounce", [&](std::size_t i, std::uint64_t& rays) {
                 return gather(i, lit, rays_of(kFirstBounceRays), rays);
               }));
  const std::vector<Flux> all = sum_of(sum_of(direct, sun), bounced);
  const Radiosity twice_lit = radiosity_of(all);
  ROOMWISE_TRY(const std::vector<Flux> indirect,
               at_all_points("baking the second bounce", [&](std::size_t i, std::uint64_t& rays) {
                 // Nothing reaches the inside of shut furniture.
                 return all[i].isZero(0) ? Flux(Flux::Zero())
                                         : gather(i, twice_lit, rays_of(kLastBounceRays), rays);
               }));
  ROOMWISE_TRY(BakedLight light, finish(direct, sum_of(sun, indirect)));
  statistics.rays += rays_;
  statistics.points += point_count();
  return light;
}

}  // namespace

Eigen::Vector3f BakedLight::at(const Scene& scene, const RayHit& hit, const Eigen::Vector3f& point,
                               const Eigen::Vector3f& direction) const {
  const SceneTriangle& triangle = scene.triangles()[hit.triangle];
  if (triangle.patch < 0) {
    const auto& values = corners[scene.is_front(hit, direction) ? 0 : 1];
    const auto [a, b, c] = triangle.corners;
    return (1 - hit.u - hit.v) * values[a] + hit.u * values[b] + hit.v * values[c];
  }
  const Patch& patch = scene.patches()[static_cast<std::size_t>(triangle.patch)];
  const Eigen::Vector3f offset = point - patch.origin;
  const float x = patch.along.dot(offset) / patch.texel_width_m() - 0.5F;
  const float y = patch.up.dot(offset) / patch.texel_height_m() - 0.5F;
  const int left = floor_to_int(x), low = floor_to_int(y);
  const float fx = x - static_cast<float>(left), fy = y - static_cast<float>(low);
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  float weights = 0;
  for (int j = 0; j < 2; ++j) {
    for (int i = 0; i < 2; ++i) {
      const int column = std::clamp(left + i, 0, patch.columns - 1);
      const int row = std::clamp(low + j, 0, patch.rows - 1);
      const auto index = static_cast<std::size_t>(row * patch.columns + column);
      if (patch.is_hole[index]) continue;
      const float weight = (i == 0 ? 1 - fx : fx) * (j == 0 ? 1 - fy : fy) + 1e-6F;
      sum += weight * texels[patch.first_texel + index];
      weights += weight;
    }
  }
  return weights > 0 ? Eigen::Vector3f(sum / weights) : Eigen::Vector3f(Eigen::Vector3f::Zero());
}

Expected<BakedLight> bake_light(const Scene& scene, const Emitters& emitters, double effort,
                                ThreadPool& pool, Progress& progress, BakeStatistics& statistics) {
  const double start_s = process_cpu_time_s();
  Baker baker(scene, emitters, effort, pool, progress);
  ROOMWISE_TRY(BakedLight light, baker.bake(statistics));
  statistics.cpu_s += process_cpu_time_s() - start_s;
  return light;
}

}  // namespace roomwise::simulation
