#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "laboratory/simulation/furniture/furniture_catalogue.h"
#include "laboratory/simulation/home/home_model.h"
#include "roomwise/base/expected.h"

namespace roomwise::simulation {

// Gives the triangles of a model.
using MeshLoader = std::function<Expected<TriangleMesh>(const std::string& model)>;

// The meshes of home.objects in their order. Every model is read once, however many pieces are of
// it.
[[nodiscard]] Expected<std::vector<std::shared_ptr<const TriangleMesh>>> load_meshes(
    const HomeModel& home, const MeshLoader& load);

}  // namespace roomwise::simulation
