#include "laboratory/simulation/scene/home_meshes.h"

#include <map>
#include <utility>

namespace roomwise::simulation {

Expected<std::vector<std::shared_ptr<const TriangleMesh>>> load_meshes(const HomeModel& home,
                                                                       const MeshLoader& load) {
  std::map<std::string, std::shared_ptr<const TriangleMesh>> by_model;
  std::vector<std::shared_ptr<const TriangleMesh>> meshes;
  for (const PlacedObject& object : home.objects) {
    auto& mesh = by_model[object.model];
    if (!mesh) {
      ROOMWISE_TRY(TriangleMesh loaded, load(object.model));
      mesh = std::make_shared<const TriangleMesh>(std::move(loaded));
    }
    meshes.push_back(mesh);
  }
  return meshes;
}

}  // namespace roomwise::simulation
