#include "roomwise/mapping/frontend/keyframe_graph.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace roomwise::mapping {
namespace {

using geometry::RigidTransform;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

PoseGraphEdge edge(KeyframeId from, KeyframeId to, const RigidTransform& from_from_to) {
  return {from, to, from_from_to, geometry::Matrix6d::Identity(), false};
}
RigidTransform right_m(double x) {
  return {Eigen::Quaterniond::Identity(), {x, 0, 0}};
}

std::vector<KeyframeId> ids_around(const KeyframeGraph& graph, KeyframeId keyframe) {
  std::vector<KeyframeId> ids;
  for (const KeyframeGraph::Nearby& nearby : graph.around(keyframe)) ids.push_back(nearby.id);
  return ids;
}

TEST(KeyframeGraph, KnowsTheWayAlongAnEdgeAndBack) {
  KeyframeGraph graph;
  const RigidTransform turn{Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY())),
                            {0.1, 0.2, 0.3}};
  graph.add(edge(2, 5, turn));
  ASSERT_TRUE(graph.between(2, 5));
  EXPECT_EQ(graph.between(2, 5)->translation, turn.translation);
  ASSERT_TRUE(graph.between(5, 2));
  EXPECT_LT((*graph.between(5, 2) * turn).distance_m(), 1e-12);
  EXPECT_FALSE(graph.between(2, 3));
  EXPECT_FALSE(graph.between(9, 2));
}

TEST(KeyframeGraph, TheFirstEdgeBetweenTwoIsTheWay) {
  KeyframeGraph graph;
  graph.add(edge(0, 1, right_m(1)));
  graph.add(edge(0, 1, right_m(2)));
  EXPECT_EQ(graph.edges().size(), 2U);
  EXPECT_EQ(graph.between(0, 1)->translation.x(), 1);
  EXPECT_THAT(ids_around(graph, 0), ElementsAre(1));
}

TEST(KeyframeGraph, AKeyframeWasTrackedFromWhereItsFirstEdgeLeads) {
  KeyframeGraph graph;
  graph.add({0, 1, {}});
  graph.add({1, 2, {}});
  graph.add({0, 2, {}});
  EXPECT_EQ(graph.tracked_from(2), 1U);
  EXPECT_EQ(graph.tracked_from(1), 0U);
  EXPECT_FALSE(graph.tracked_from(3));
}

TEST(KeyframeGraph, FindsWhatOneOrTwoEdgesAway) {
  KeyframeGraph graph;
  for (KeyframeId id = 0; id < 6; ++id) graph.add(edge(id, id + 1, right_m(1)));
  graph.add(edge(1, 5, right_m(4.5)));  // a loop that disagrees a little
  EXPECT_THAT(ids_around(graph, 2), ElementsAre(1, 3, 0, 5, 4));
  for (const KeyframeGraph::Nearby& nearby : graph.around(2)) {
    const double x = nearby.keyframe_from_nearby.translation.x();
    EXPECT_NEAR(x, nearby.id == 5 ? 3.5 : static_cast<double>(nearby.id) - 2, 1e-12);
  }
  EXPECT_THAT(ids_around(graph, 17), IsEmpty());
}

}  // namespace
}  // namespace roomwise::mapping
