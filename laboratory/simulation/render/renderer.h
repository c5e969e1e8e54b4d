#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "laboratory/simulation/furniture/furniture_catalogue.h"
#include "laboratory/simulation/home/home_model.h"
#include "laboratory/simulation/scene/home_meshes.h"
#include "roomwise/base/progress.h"
#include "roomwise/base/thread_pool.h"
#include "roomwise/geometry/pinhole_camera.h"
#include "roomwise/image/image.h"

namespace roomwise::simulation {

constexpr float kFarthestDrawn = 200;  // m along the optical axis

// What the camera would see before its sensor spoils it.
struct RenderedFrame {
  image::Image<Eigen::Vector3f> radiance;  // linear RGB, before exposure
  image::Image<float> depth_m;             // along the optical axis, exact; 0: nothing (sky)
  image::Image<float> specularity;         // of the surface seen at the pixel's centre, 0 to 1
  image::Image<float> albedo;              // mean diffuse reflectance there, 0 to 1
  image::Image<std::uint16_t> object;      // 1 + index into HomeModel::objects; 0: walls, sky
};

struct RenderOptions {
  int samples_per_pixel = 4;
  double bake_effort = 1;  // rays of the bake, relative to demo quality
  // Where the baked light is kept between runs. A file that is damaged or belongs to another home
  // is written anew. Empty: nowhere.
  std::filesystem::path light_cache;

  [[nodiscard]] Expected<void> validate() const;
};

// What the bake cost.
struct BakeStatistics {
  double cpu_s = 0;
  std::uint64_t rays = 0;
  std::size_t points = 0;     // places where light was gathered
  std::size_t triangles = 0;  // of the scene
  bool from_cache = false;    // then nothing was traced
};

// A home as triangles in Embree with its light baked: diffuse light is at rest while the camera
// walks. Same bits at any number of threads.
class Renderer {
 public:
  // Loads the furniture, builds the scene, bakes the light. Fails where a model cannot be read or
  // the user interrupts.
  [[nodiscard]] static Expected<std::unique_ptr<Renderer>> create(
      const HomeModel& home, const FurnitureCatalogue& catalogue, const RenderOptions& options,
      ThreadPool& pool, Progress& progress);
  [[nodiscard]] static Expected<std::unique_ptr<Renderer>> create(const HomeModel& home,
                                                                  const MeshLoader& load,
                                                                  const RenderOptions& options,
                                                                  ThreadPool& pool,
                                                                  Progress& progress);
  virtual ~Renderer() = default;

  // The colour of a pixel is averaged over its area; depth, object and material are those at its
  // centre, through the camera's lens distortion. What is half transparent or more is looked
  // through.
  [[nodiscard]] virtual RenderedFrame render(const geometry::PinholeCamera& camera,
                                             const geometry::RigidTransform& world_from_camera,
                                             ThreadPool& pool) const = 0;

  [[nodiscard]] virtual const BakeStatistics& bake_statistics() const = 0;
  // Tells the home as it is drawn from any other; see scene_digest().
  [[nodiscard]] virtual const std::string& scene_digest() const = 0;
  // Embree's bare rate, to compare with: sends one ray through every pixel's centre and does
  // nothing with what it meets. Returns how many rays met something.
  [[nodiscard]] virtual std::uint64_t trace_bare(
      const geometry::PinholeCamera& camera,
      const geometry::RigidTransform& world_from_camera) const = 0;
};

}  // namespace roomwise::simulation
