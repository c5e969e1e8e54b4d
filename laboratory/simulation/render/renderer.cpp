#include "laboratory/simulation/render/renderer.h"

#include <mutex>
#include <string>

#include "laboratory/simulation/render/frame_renderer.h"
#include "laboratory/simulation/render/light_bake.h"
#include "laboratory/simulation/render/light_cache.h"
#include "laboratory/simulation/render/shading.h"
#include "laboratory/simulation/scene/scene.h"
#include "roomwise/base/file.h"

namespace roomwise::simulation {
namespace {

class BakedRenderer final : public Renderer {
 public:
  BakedRenderer(const HomeModel& home, Scene scene, const RenderOptions& options)
      : scene_(std::move(scene)), emitters_(home, scene_, options.bake_effort), options_(options) {
    statistics_.triangles = scene_.triangles().size();
  }

  Expected<void> prepare_light(ThreadPool& pool, Progress& progress);
  [[nodiscard]] RenderedFrame render(const geometry::PinholeCamera& camera,
                                     const geometry::RigidTransform& world_from_camera,
                                     ThreadPool& pool) const override;
  [[nodiscard]] const BakeStatistics& bake_statistics() const override { return statistics_; }
  [[nodiscard]] const std::string& scene_digest() const override { return digest_; }
  [[nodiscard]] std::uint64_t trace_bare(
      const geometry::PinholeCamera& camera,
      const geometry::RigidTransform& world_from_camera) const override;

 private:
  [[nodiscard]] std::shared_ptr<const ViewDirections> directions_of(
      const geometry::PinholeCamera& camera) const;

  Scene scene_;
  Emitters emitters_;
  RenderOptions options_;
  BakedLight light_;
  BakeStatistics statistics_;
  std::string digest_;
  mutable std::mutex directions_mutex_;
  mutable std::shared_ptr<const ViewDirections> directions_;  // of the last camera
};

Expected<void> BakedRenderer::prepare_light(ThreadPool& pool, Progress& progress) {
  digest_ = simulation::scene_digest(scene_, emitters_);
  const std::string key = light_key(digest_, options_.bake_effort);
  const bool is_kept = !options_.light_cache.empty();
  if (is_kept) {
    if (auto light = read_light(options_.light_cache, key, scene_)) {
      light_ = std::move(*light);
      statistics_.from_cache = true;
      return {};
    }
    ROOMWISE_RETURN_IF_ERROR(check_can_write(options_.light_cache));
  }
  ROOMWISE_TRY(light_,
               bake_light(scene_, emitters_, options_.bake_effort, pool, progress, statistics_));
  return is_kept ? write_light(options_.light_cache, key, light_) : Expected<void>{};
}

std::shared_ptr<const ViewDirections> BakedRenderer::directions_of(
    const geometry::PinholeCamera& camera) const {
  const std::lock_guard lock(directions_mutex_);
  if (!directions_ || !(directions_->camera() == camera)) {
    directions_ = std::make_shared<const ViewDirections>(camera);
  }
  return directions_;
}

RenderedFrame BakedRenderer::render(const geometry::PinholeCamera& camera,
                                    const geometry::RigidTransform& world_from_camera,
                                    ThreadPool& pool) const {
  const auto directions = directions_of(camera);
  const Shading shading(scene_, emitters_, light_);
  return FrameRenderer(scene_, shading, *directions, world_from_camera, options_.samples_per_pixel)
      .render(pool);
}

std::uint64_t BakedRenderer::trace_bare(const geometry::PinholeCamera& camera,
                                        const geometry::RigidTransform& world_from_camera) const {
  const auto directions = directions_of(camera);
  const Eigen::Matrix3f rotation = world_from_camera.rotation_matrix().cast<float>();
  const Eigen::Vector3f origin = world_from_camera.translation.cast<float>();
  std::uint64_t hits = 0;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Eigen::Vector3f direction = rotation * directions->at(x, y, Eigen::Vector2f::Zero());
      const auto hit = scene_.rays().first_hit(origin, direction, 0, kFarthestDrawn,
                                               RayCaster::Meets::kEverything);
      hits += hit ? 1 : 0;
    }
  }
  return hits;
}

}  // namespace

Expected<void> RenderOptions::validate() const {
  constexpr int kMaxSamples = 256;
  if (samples_per_pixel < 1 || samples_per_pixel > kMaxSamples) {
    return fail("samples_per_pixel = {} must be from 1 to {}", samples_per_pixel, kMaxSamples);
  }
  if (!(bake_effort > 0 && bake_effort <= 100)) {
    return fail("bake_effort = {} must be above 0 and at most 100", bake_effort);
  }
  return {};
}

Expected<std::unique_ptr<Renderer>> Renderer::create(const HomeModel& home, const MeshLoader& load,
                                                     const RenderOptions& options, ThreadPool& pool,
                                                     Progress& progress) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  ROOMWISE_TRY(const auto meshes, load_meshes(home, load));
  ROOMWISE_TRY(Scene scene, Scene::build(home, meshes));
  auto renderer = std::make_unique<BakedRenderer>(home, std::move(scene), options);
  ROOMWISE_RETURN_IF_ERROR(renderer->prepare_light(pool, progress));
  return renderer;
}

}  // namespace roomwise::simulation
