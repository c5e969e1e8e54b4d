#pragma once

#include <filesystem>

#include "roomwise/base/expected.h"
#include "roomwise/fusion/piecewise_mesh.h"

namespace roomwise::fusion {

// Binary little-endian PLY: 27 bytes a vertex (x y z nx ny nz as float, red green blue as uchar),
// 13 a triangle (uchar 3, three int). The file is whole or unchanged, as of the other; both take as
// much memory as the file has bytes.
[[nodiscard]] Expected<void> write_ply(const std::filesystem::path& path,
                                       const PiecewiseMesh& mesh);

// One binary glTF 2.0 file (Khronos Group, "glTF 2.0 Specification", GLB), with normals and vertex
// colours, shown without light of the viewer's own (KHR_materials_unlit, where it knows that): the
// colours are those that the camera saw. `mesh_gravity` has z up; the file has y up, as glTF
// demands, and -z where the mesh has y.
[[nodiscard]] Expected<void> write_glb(const std::filesystem::path& path,
                                       const PiecewiseMesh& mesh_gravity);

}  // namespace roomwise::fusion
