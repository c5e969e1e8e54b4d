#include "laboratory/simulation/render/light_point_index.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "roomwise/base/random.h"

namespace roomwise::simulation {
namespace {

Eigen::Vector3f random_unit(RandomStream& random) {
  return Eigen::Vector3d(random.normal(), random.normal(), random.normal())
      .normalized()
      .cast<float>();
}

// What a point tells of a place by the index's own words: its distance, faster across the plane,
// its angle, and how open it is. Zero from 78 mm on, and from 60 degrees on.
float told_by(const LightPoint& point, const Eigen::Vector3f& position,
              const Eigen::Vector3f& normal) {
  const Eigen::Vector3f offset = point.position - position;
  const float beside = normal.dot(offset), facing = normal.dot(point.normal);
  const float squared = (offset.squaredNorm() + 50 * beside * beside) / (0.078F * 0.078F);
  if (squared >= 1 || std::abs(facing) <= 0.5F) return 0;
  const float weight = (1 - squared) * (1 - squared) * (std::abs(facing) - 0.5F) *
                       (std::abs(facing) - 0.5F) * point.openness * point.openness;
  return facing > 0 ? weight : -weight;
}

TEST(LightPointIndex, FindsWhatLookingAtAllPointsFinds) {
  RandomStream random(7);
  std::vector<LightPoint> points;
  std::vector<std::uint16_t> objects;
  for (int i = 0; i < 6000; ++i) {
    const Eigen::Vector3f place(static_cast<float>(0.5 * random.uniform() - 0.2),
                                static_cast<float>(0.5 * random.uniform() - 0.3),
                                static_cast<float>(0.4 * random.uniform()));
    // Half of them as furniture is: along the axes.
    const Eigen::Vector3f normal =
        i % 2 == 0 ? random_unit(random) : Eigen::Vector3f::Unit(static_cast<int>(random.index(3)));
    points.push_back({place, normal, static_cast<float>(0.3 + 0.7 * random.uniform())});
    objects.push_back(static_cast<std::uint16_t>(3 * random.index(2)));
  }
  const auto order = LightPointIndex::order_of(points, objects);
  std::vector<LightPoint> sorted;
  std::vector<std::uint16_t> sorted_objects;
  for (const std::uint32_t i : order) {
    sorted.push_back(points[i]);
    sorted_objects.push_back(objects[i]);
  }
  const LightPointIndex index(sorted, sorted_objects);

  std::size_t all = 0;
  for (std::size_t i = 0; i < sorted.size(); i += 11) {
    const Eigen::Vector3f& position = sorted[i].position;
    const Eigen::Vector3f& normal = sorted[i].normal;
    std::vector<LightPointIndex::Neighbor> found;
    index.find(sorted_objects[i], position, normal, found);
    std::map<std::uint32_t, float> weights;
    for (const auto& neighbor : found) {
      EXPECT_TRUE(weights.emplace(neighbor.point, neighbor.weight).second) << "found twice";
    }
    for (std::uint32_t k = 0; k < sorted.size(); ++k) {
      const float expected =
          sorted_objects[k] == sorted_objects[i] ? told_by(sorted[k], position, normal) : 0;
      const auto entry = weights.find(k);
      EXPECT_NEAR(entry == weights.end() ? 0 : entry->second, expected, 1e-5F) << i << ' ' << k;
      all += std::abs(expected) > 1e-3F ? 1 : 0;
    }
  }
  EXPECT_GT(all, 1000U) << "the test looks at something";
  std::vector<LightPointIndex::Neighbor> none;
  index.find(1, sorted.front().position, sorted.front().normal, none);
  index.find(900, sorted.front().position, sorted.front().normal, none);
  EXPECT_TRUE(none.empty()) << "no such object";
}

}  // namespace
}  // namespace roomwise::simulation
