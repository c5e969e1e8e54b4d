#pragma once

#include "roomwise/base/expected.h"
#include "roomwise/base/thread_pool.h"
#include "roomwise/fusion/piecewise_mesh.h"
#include "roomwise/fusion/tsdf_volume.h"

namespace roomwise::fusion {

struct MeshOptions {
  // Voxels of less weight do not count. A frame gives up to 128: 29 from 2 m, 7 from 3 m, 2 from 4
  // m, and less where it looks slantwise.
  std::uint32_t min_weight = 4;
  // Pieces of the surface with less area that hang on nothing are left out; 0: none.
  double min_component_m2 = 0.01;

  [[nodiscard]] Expected<void> validate() const;
};

// The surface of a field by marching cubes: a vertex on each edge between neighbouring voxels where
// the distance changes its sign, in cubes whose eight voxels all have enough weight. Normals are
// the gradient of the distance. In the field's frame; the same bits at any number of threads and
// with any working set, which is the field's. Errors are those of scratch files.
[[nodiscard]] Expected<PiecewiseMesh> extract_mesh(TsdfVolume& field, const MeshOptions& options,
                                                   ThreadPool& pool);

}  // namespace roomwise::fusion
