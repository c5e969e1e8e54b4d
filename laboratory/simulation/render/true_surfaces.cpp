#include "laboratory/simulation/render/true_surfaces.h"

#include <utility>

#include "laboratory/simulation/render/emitters.h"
#include "laboratory/simulation/render/light_cache.h"
#include "laboratory/simulation/scene/home_meshes.h"

namespace roomwise::simulation {

Expected<TrueSurfaces> TrueSurfaces::create(const HomeModel& home, const MeshLoader& load) {
  ROOMWISE_TRY(const auto meshes, load_meshes(home, load));
  ROOMWISE_TRY(Scene scene, Scene::build(home, meshes));
  std::string digest = scene_digest(scene, Emitters(home, scene, 1));
  return TrueSurfaces(std::move(scene), std::move(digest));
}

}  // namespace roomwise::simulation
