#include "roomwise/mapping/bundle/reprojection_residual.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/mapping/graph/edge_error.h"
#include "roomwise/mapping/testing/synthetic_bundle.h"
#include "roomwise/motion/pose_refinement.h"

namespace roomwise::mapping {
namespace {

using testing::random_transform;

struct Trial {
  LandmarkView view;
  Eigen::Vector3d point_world;
  RollingShutterCamera camera;
  ViewModel model;
};

Trial random_trial(RandomStream& random, bool has_depth, double readout_s) {
  Trial trial;
  trial.model = {{510, 520, 318, 255, 640, 480, {}, 1000}, {1.5, 40, 0.7}, readout_s};
  trial.camera.world_from_camera = random_transform(random, 1, 1);
  for (double& value : trial.camera.velocity) value = random.normal();
  const Eigen::Vector3d seen(0.5 * random.normal(), 0.5 * random.normal(),
                             1 + 3 * random.uniform());
  trial.point_world = trial.camera.world_from_camera * seen;
  trial.view = {0, {640 * random.uniform(), 480 * random.uniform()}, 0, random.uniform() - 0.5};
  if (has_depth) trial.view.depth_m = 1 + 3 * random.uniform();
  return trial;
}

TEST(ReprojectionResidual, ItsJacobiansAreItsDerivatives) {
  constexpr double kStep = 1e-6;
  RandomStream random(1);
  for (int i = 0; i < 200; ++i) {
    const Trial trial = random_trial(random, i % 3 != 0, i % 2 == 0 ? 0.02 : 0);
    const ReprojectionJacobians jacobians =
        reprojection_jacobians(trial.view, trial.point_world, trial.camera, trial.model);
    const auto column = [&](const auto& error_after) {
      return ((error_after(kStep) - error_after(-kStep)) / (2 * kStep)).eval();
    };
    for (Eigen::Index k = 0; k < 6; ++k) {
      const Eigen::Vector3d d_pose = column([&](double step) {
        RollingShutterCamera camera = trial.camera;
        camera.world_from_camera =
            retract(camera.world_from_camera, step * geometry::Vector6d::Unit(k));
        return reprojection_residual(trial.view, trial.point_world, camera, trial.model);
      });
      EXPECT_LT((jacobians.d_pose.col(k) - d_pose).norm(), 1e-4 * (1 + d_pose.norm()));
    }
    for (Eigen::Index k = 0; k < 3; ++k) {
      const Eigen::Vector3d d_point = column([&](double step) {
        return reprojection_residual(trial.view,
                                     trial.point_world + step * Eigen::Vector3d::Unit(k),
                                     trial.camera, trial.model);
      });
      EXPECT_LT((jacobians.d_point.col(k) - d_point).norm(), 1e-4 * (1 + d_point.norm()));
    }
    const Eigen::Vector3d d_readout = column([&](double step) {
      ViewModel model = trial.model;
      model.readout_s += step;
      return reprojection_residual(trial.view, trial.point_world, trial.camera, model);
    });
    EXPECT_LT((jacobians.d_readout - d_readout).norm(), 1e-4 * (1 + d_readout.norm()));
  }
}

TEST(ReprojectionResidual, IsThatOfPoseRefinementWhereAllRowsAreExposedAtOnce) {
  RandomStream random(2);
  for (int i = 0; i < 50; ++i) {
    const Trial trial = random_trial(random, i % 2 == 0, 0);
    const Eigen::Vector3d expected = motion::residual(
        {trial.point_world, trial.view.pixel, trial.view.depth_m},
        trial.camera.world_from_camera.inverse(), trial.model.camera, trial.model.residuals);
    EXPECT_LT(
        (reprojection_residual(trial.view, trial.point_world, trial.camera, trial.model) - expected)
            .norm(),
        1e-9 * (1 + expected.norm()));
  }
}

TEST(ReprojectionResidual, IsInfiniteBehindTheCamera) {
  const ViewModel model{{500, 500, 320, 240, 640, 480, {}, 1000}, {}, 0};
  EXPECT_FALSE(reprojection_residual({}, {0, 0, -1}, {}, model).allFinite());
}

}  // namespace
}  // namespace roomwise::mapping
