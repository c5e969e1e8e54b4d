#include "roomwise/mapping/backend/keyframe_culling.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/base/testing/testing.h"
#include "roomwise/mapping/backend/map_solver.h"
#include "roomwise/mapping/graph/edge_composition.h"

namespace roomwise::mapping {
namespace {

using geometry::Matrix6d;
using geometry::RigidTransform;
using geometry::Vector6d;

RigidTransform step_of(double forward_m, double turn_rad) {
  Vector6d twist;
  twist << 0.01, turn_rad, -0.02, 0.01, 0.03, forward_m;
  return RigidTransform::exp(twist);
}

TEST(EdgeComposition, TwoEdgesGiveTheWayAndItsCovariance) {
  Matrix6d information = Matrix6d::Identity() * 1e4;
  information(3, 3) = 5e5;
  information(0, 4) = information(4, 0) = 2e3;
  const PoseGraphEdge first{0, 1, step_of(0.5, 0.3), information};
  const PoseGraphEdge second{1, 2, step_of(0.2, -0.8), 3 * information};
  const PoseGraphEdge both = composed(first, second);
  EXPECT_EQ(both.from, 0U);
  EXPECT_EQ(both.to, 2U);
  EXPECT_TRUE(both.is_robust);

  // The covariance of the end by small errors in each coordinate, by differences.
  const auto error_of = [](int coordinate, double size) {
    Eigen::Vector3d t = Eigen::Vector3d::Zero(), q = Eigen::Vector3d::Zero();
    (coordinate < 3 ? t : q)[coordinate % 3] = size;
    return RigidTransform{Eigen::Quaterniond(std::sqrt(1 - q.squaredNorm()), q.x(), q.y(), q.z()),
                          t};
  };
  constexpr double kSmall = 1e-5;
  Matrix6d by_first, by_second;
  for (int i = 0; i < 6; ++i) {
    for (const bool is_first : {true, false}) {
      const RigidTransform moved =
          is_first ? first.from_from_to * error_of(i, kSmall) * second.from_from_to
                   : first.from_from_to * second.from_from_to * error_of(i, kSmall);
      const RigidTransform off = both.from_from_to.inverse() * moved;
      Vector6d column;
      column << off.translation, off.rotation.vec();
      (is_first ? by_first : by_second).col(i) = column / kSmall;
    }
  }
  const Matrix6d expected = by_first * first.information.inverse() * by_first.transpose() +
                            by_second * second.information.inverse() * by_second.transpose();
  EXPECT_LT((both.information.inverse() - expected).norm(), 1e-3 * expected.norm());

  const PoseGraphEdge again = reversed(reversed(both));
  EXPECT_LT((again.information - both.information).norm(), 1e-3 * both.information.norm());
  EXPECT_LT((again.from_from_to.inverse() * both.from_from_to).distance_m(), 1e-12);
}

// A walk of six key-frames, and a second one beside it of three.
class KeyframeCulling : public ::testing::Test {
 protected:
  KeyframeCulling() {
    for (std::size_t i = 0; i < 9; ++i) {
      poses_.push_back(i == 0 ? RigidTransform::identity() : poses_.back() * step_of(0.3, 0.1));
      walk_.push_back(i < 6 ? 0U : 1U);
      component_.push_back(0);
    }
    for (const auto& [from, to] : {std::pair(0, 1),
                                   {1, 2},
                                   {2, 3},
                                   {3, 4},
                                   {4, 5},
                                   {6, 7},
                                   {7, 8},
                                   {1, 6},
                                   {2, 7},
                                   {3, 8}}) {
      const auto a = static_cast<KeyframeId>(from), b = static_cast<KeyframeId>(to);
      edges_.push_back({a, b, poses_[a].inverse() * poses_[b], 1e4 * Matrix6d::Identity(),
                        walk_[a] != walk_[b]});
    }
  }

  // The edges of what stays.
  [[nodiscard]] std::vector<PoseGraphEdge> left(const std::vector<KeyframeId>& culled) const {
    std::vector<PoseGraphEdge> all = edges_without({poses_, component_, walk_, edges_}, culled);
    all.insert(all.end(), edges_.begin(), edges_.end());
    std::erase_if(all, [&](const PoseGraphEdge& edge) {
      return std::ranges::count(culled, edge.from) + std::ranges::count(culled, edge.to) > 0;
    });
    return all;
  }
  // How many parts the others fall into.
  [[nodiscard]] std::size_t parts(std::vector<PoseGraphEdge> edges,
                                  const std::vector<KeyframeId>& culled) const {
    std::size_t components = 0;
    static_cast<void>(components_by_size(poses_.size(), edges, components));
    return components - culled.size();
  }

  std::vector<RigidTransform> poses_;
  std::vector<std::size_t> walk_, component_;
  std::vector<PoseGraphEdge> edges_;
};

TEST_F(KeyframeCulling, WhatStaysHangsTogetherOfEachWalkForItself) {
  for (const std::vector<KeyframeId>& culled :
       std::vector<std::vector<KeyframeId>>{{1}, {2, 3}, {7}, {1, 3, 7}, {1, 2, 3, 4}}) {
    std::vector<PoseGraphEdge> edges = left(culled);
    EXPECT_EQ(parts(edges, culled), 1U);
    std::erase_if(edges,
                  [&](const PoseGraphEdge& edge) { return walk_[edge.from] != walk_[edge.to]; });
    EXPECT_EQ(parts(edges, culled), 2U) << "each walk without the other's help";
  }
}

TEST_F(KeyframeCulling, TheSolutionStays) {
  const std::vector<KeyframeId> culled{2, 3, 7};
  for (const PoseGraphEdge& edge : left(culled)) {
    const RigidTransform is = poses_[edge.from].inverse() * poses_[edge.to];
    EXPECT_LT((edge.from_from_to.inverse() * is).distance_m(), 1e-9);
    EXPECT_LT((edge.from_from_to.inverse() * is).angle_rad(), 1e-9);
  }
}

TEST_F(KeyframeCulling, ALongerWayIsLessSure) {
  const auto added = edges_without({poses_, component_, walk_, edges_}, std::vector<KeyframeId>{4});
  ASSERT_EQ(added.size(), 1U);
  EXPECT_EQ(std::minmax(added[0].from, added[0].to), std::minmax<KeyframeId>(3, 5));
  EXPECT_GT(variance_of(added[0]), 1.9 * variance_of(edges_[0]));
}

TEST_F(KeyframeCulling, WhatMayJoinComponentsLaterStays) {
  component_[8] = 1;
  std::erase_if(edges_, [](const PoseGraphEdge& edge) { return edge.from == 7 && edge.to == 8; });
  const auto edges = left({3});
  EXPECT_TRUE(std::ranges::any_of(
      edges, [](const PoseGraphEdge& edge) { return edge.from == 8 || edge.to == 8; }));
}

}  // namespace
}  // namespace roomwise::mapping
