#include "roomwise/mapping/graph/edge_error.h"

#include <gtest/gtest.h>

#include "roomwise/base/random.h"
#include "roomwise/mapping/testing/random_transform.h"

namespace roomwise::mapping {
namespace {

using geometry::Matrix6d;
using geometry::RigidTransform;
using geometry::Vector6d;

// de by a step of either pose, from differences of the error itself.
template <typename Error>
Matrix6d differences(const Error& error_after) {
  constexpr double kStep = 1e-6;
  Matrix6d jacobian;
  for (Eigen::Index i = 0; i < 6; ++i) {
    const Vector6d step = kStep * Vector6d::Unit(i);
    jacobian.col(i) = (error_after(step) - error_after(-step)) / (2 * kStep);
  }
  return jacobian;
}

TEST(EdgeError, ItsJacobiansAreItsDerivatives) {
  RandomStream random(1);
  for (int trial = 0; trial < 200; ++trial) {
    const RigidTransform from = testing::random_transform(random, 1, 1);
    const RigidTransform to = testing::random_transform(random, 1, 1);
    // Small errors and large ones, with either sign of the quaternion.
    const double scale = trial % 2 == 0 ? 0.01 : 0.8;
    RigidTransform measured = from.inverse() * to * testing::random_transform(random, scale, scale);
    if (trial % 3 == 0) measured.rotation.coeffs() *= -1;
    const EdgeJacobians jacobians = edge_jacobians(measured, from, to);
    EXPECT_LT((jacobians.d_from - differences([&](const Vector6d& step) {
                 return edge_error(measured, retract(from, step), to);
               })).norm(),
              1e-7);
    EXPECT_LT((jacobians.d_to - differences([&](const Vector6d& step) {
                 return edge_error(measured, from, retract(to, step));
               })).norm(),
              1e-7);
  }
}

TEST(EdgeError, IsZeroWhereThePosesAgreeWithTheMeasurement) {
  RandomStream random(2);
  const RigidTransform from = testing::random_transform(random, 1, 1);
  const RigidTransform measured = testing::random_transform(random, 1, 1);
  EXPECT_LT(edge_error(measured, from, from * measured).norm(), 1e-14);
}

TEST(Moved, MovesAlongTheWorldAndTurnsAboutTheNode) {
  RandomStream random(3);
  const RigidTransform pose = testing::random_transform(random, 1, 1);
  Vector6d step;
  step << 1, 2, 3, 0.3, -0.2, 0.1;
  const RigidTransform after = retract(pose, step);
  EXPECT_LT((after.translation - pose.translation - step.head<3>()).norm(), 1e-15);
  const RigidTransform turn = {pose.rotation.conjugate() * after.rotation, {0, 0, 0}};
  EXPECT_NEAR(turn.angle_rad(), step.tail<3>().norm(), 1e-14);
  EXPECT_LT((turn * step.tail<3>().eval() - step.tail<3>()).norm(), 1e-14);
  EXPECT_EQ(retract(pose, Vector6d::Zero()).translation, pose.translation);
}

}  // namespace
}  // namespace roomwise::mapping
