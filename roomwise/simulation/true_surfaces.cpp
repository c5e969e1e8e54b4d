#include "roomwise/simulation/true_surfaces.h"

#include <utility>

#include "roomwise/simulation/home_meshes.h"

namespace roomwise::simulation {

Expected<TrueSurfaces> TrueSurfaces::create(const HomeModel& home, const MeshLoader& load) {
  ROOMWISE_TRY(const auto meshes, load_meshes(home, load));
  ROOMWISE_TRY(Scene scene, Scene::build(home, meshes));
  return TrueSurfaces(std::move(scene));
}

}  // namespace roomwise::simulation
