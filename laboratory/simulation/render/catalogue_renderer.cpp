#include "laboratory/simulation/render/renderer.h"

// The only place where the renderer meets the furniture archives.
namespace roomwise::simulation {

Expected<std::unique_ptr<Renderer>> Renderer::create(const HomeModel& home,
                                                     const FurnitureCatalogue& catalogue,
                                                     const RenderOptions& options, ThreadPool& pool,
                                                     Progress& progress) {
  return create(
      home, [&](const std::string& model) { return catalogue.load(model); }, options, pool,
      progress);
}

}  // namespace roomwise::simulation
