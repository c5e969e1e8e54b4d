#pragma once

#include <tiny_obj_loader.h>

#include <span>
#include <vector>

#include "laboratory/simulation/furniture/mesh_loader.h"

namespace roomwise::simulation {

// The materials of an MTL as the renderer takes light: colours linear, textures decoded.
[[nodiscard]] Expected<std::vector<SurfaceMaterial>> surface_materials(
    std::span<const tinyobj::material_t> materials, const ModelFolder& folder);

}  // namespace roomwise::simulation
