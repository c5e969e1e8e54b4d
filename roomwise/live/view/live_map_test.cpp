#include "roomwise/live/view/live_map.h"

#include <gmock/gmock.h>

#include <map>

namespace roomwise::live {
namespace {

// A floor of 20 m x 10 m with a vertex every 2 cm: half a million.
fusion::TriangleMesh large_floor() {
  fusion::TriangleMesh mesh;
  for (int x = 0; x < 1000; ++x) {
    for (int y = 0; y < 500; ++y) {
      mesh.vertices.emplace_back(0.02F * static_cast<float>(x), 0.02F * static_cast<float>(y), 0.F);
      mesh.colors.push_back({200, 180, 160});
    }
  }
  return mesh;
}

TEST(LiveMapTest, ALargeSurfaceIsThinnedEvenly) {
  const geometry::PointCloud coarse = thinned(large_floor(), MapClouds::kMaxCoarse).value();
  EXPECT_LE(coarse.size(), MapClouds::kMaxCoarse);
  EXPECT_GT(coarse.size(), MapClouds::kMaxCoarse / 2);
  std::map<std::pair<int, int>, int> of_square_metre;
  for (const Eigen::Vector3f& point : coarse.points) {
    ++of_square_metre[{static_cast<int>(point.x()), static_cast<int>(point.y())}];
  }
  EXPECT_EQ(of_square_metre.size(), 200U);
  const double mean = static_cast<double>(coarse.size()) / 200;
  for (const auto& [square, count] : of_square_metre) {
    EXPECT_NEAR(count, mean, 0.2 * mean) << square.first << ' ' << square.second;
  }
}

TEST(LiveMapTest, ASmallSurfaceStaysWhatItIs) {
  fusion::TriangleMesh mesh;
  for (int i = 0; i < 10; ++i) {
    mesh.vertices.emplace_back(0.1F * static_cast<float>(i) + 0.01F, 0.01F, 0.01F);
    mesh.colors.push_back({1, 2, 3});
  }
  EXPECT_EQ(thinned(mesh, MapClouds::kMaxCoarse)->size(), 10U);
}

}  // namespace
}  // namespace roomwise::live
