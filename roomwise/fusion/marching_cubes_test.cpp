#include "roomwise/fusion/marching_cubes.h"

#include <gtest/gtest.h>

#include <set>

#include "roomwise/base/testing/testing.h"
#include "roomwise/fusion/surface_mesh.h"
#include "roomwise/fusion/testing/test_scenes.h"

namespace roomwise::fusion {
namespace {

TEST(MarchingCubes, JoinsExactlyTheEdgesThatTheSurfaceCrosses) {
  for (unsigned inside = 0; inside < 256; ++inside) {
    std::set<int> crossed, joined;
    for (int i = 0; i < kCubeEdges; ++i) {
      const CubeEdge& edge = cube_edges()[static_cast<std::size_t>(i)];
      if (((inside >> edge.from ^ inside >> edge.to) & 1) != 0) crossed.insert(i);
    }
    for (const auto& triangle : cube_triangles()[inside]) {
      joined.insert(triangle.begin(), triangle.end());
    }
    EXPECT_EQ(joined, crossed) << "corners " << inside;
  }
}

// Noise has every way in which neighbouring cubes can meet.
TEST(MarchingCubes, LeavesNoHoleBetweenCubes) {
  RandomStream random(3);
  TsdfVolume field({});
  auto block = std::make_unique<VoxelBlock>();
  for (int i = 0; i < kBlockVoxels; ++i) {
    const auto is_rim = [](int c) { return c == 0 || c == kBlockSide - 1; };
    const bool open = is_rim(i % 8) || is_rim(i / 8 % 8) || is_rim(i / 64);
    const int distance = 1 + static_cast<int>(random.index(1000));
    block->voxels[static_cast<std::size_t>(i)] = {
        50 * (open || random.index(2) == 0 ? distance : -distance), 50};
  }
  field.insert({0, 0, 0}, std::move(block));
  ThreadPool pool(2);
  const TriangleMesh mesh =
      extract_mesh(field, {.min_weight = 1, .min_component_m2 = 0}, pool)->whole().value();
  EXPECT_GT(mesh.triangles.size(), 500U);
  EXPECT_TRUE(testing::is_closed(mesh));
}

}  // namespace
}  // namespace roomwise::fusion
