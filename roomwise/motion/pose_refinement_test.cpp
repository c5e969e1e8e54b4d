#include "roomwise/motion/pose_refinement.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <vector>

#include "roomwise/base/random.h"
#include "roomwise/motion/testing/test_scenes.h"

namespace roomwise::motion {
namespace {

using geometry::Matrix6d;
using geometry::PinholeCamera;
using geometry::RigidTransform;
using geometry::Vector6d;
using testing::kCamera;

RigidTransform small_motion(RandomStream& random, double scale) {
  Vector6d twist;
  for (int i = 0; i < 6; ++i) twist(i) = scale * random.normal();
  return RigidTransform::exp(twist);
}

// What a current frame sees of random points, with Gaussian noise of `noise` sigmas.
std::vector<PointObservation> observe(const RigidTransform& reference_from_current,
                                      const PinholeCamera& camera, const ResidualModel& model,
                                      double noise, std::size_t count, RandomStream& random) {
  std::vector<PointObservation> observations;
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector2d pixel(640 * random.uniform(), 480 * random.uniform());
    const double depth_m = 0.8 + 3 * random.uniform();
    PointObservation observation;
    observation.point_reference =
        reference_from_current * camera.unproject_undistorted(pixel, depth_m);
    observation.pixel_current =
        pixel + noise * model.pixel_sigma_px * Eigen::Vector2d(random.normal(), random.normal());
    const double disparity =
        model.focal_baseline_px_m / depth_m + noise * model.disparity_sigma_px * random.normal();
    observation.depth_current_m = i % 4 == 0 ? 0 : model.focal_baseline_px_m / disparity;
    observations.push_back(observation);
  }
  return observations;
}

TEST(RefinePose, ReachesTheExactPose) {
  RandomStream random(1);
  const ResidualModel model;
  for (int i = 0; i < 20; ++i) {
    const RigidTransform truth = small_motion(random, 0.3);
    const auto observations = observe(truth, kCamera, model, 0, 40, random);
    const RefinedPose refined =
        refine_pose(observations, truth * small_motion(random, 0.03), kCamera, model);
    const RigidTransform error = truth.inverse() * refined.reference_from_current;
    EXPECT_LT(error.angle_rad() + error.distance_m(), 1e-7);
    EXPECT_LT(refined.rms, 1e-5);
  }
}

TEST(RefinePose, ToleratesAFewOutliers) {
  RandomStream random(2);
  const ResidualModel model;
  const RigidTransform truth = small_motion(random, 0.3);
  auto observations = observe(truth, kCamera, model, 0, 60, random);
  for (std::size_t i = 0; i < 6; ++i) observations[i].pixel_current += Eigen::Vector2d(20, -15);
  const RefinedPose refined =
      refine_pose(observations, truth * small_motion(random, 0.01), kCamera, model);
  const RigidTransform error = truth.inverse() * refined.reference_from_current;
  EXPECT_LT(error.distance_m(), 0.004);
}

// The information is what the pose graph believes: over many noisy trials, e^T Omega e of the true
// error must average to its six degrees of freedom.
TEST(RefinePose, InformationMatchesTheSpreadOfTheErrors) {
  RandomStream random(3);
  const ResidualModel model;
  const RigidTransform truth = small_motion(random, 0.3);
  constexpr int kTrials = 400;
  double sum = 0;
  for (int i = 0; i < kTrials; ++i) {
    const auto observations = observe(truth, kCamera, model, 0.5, 80, random);
    const RefinedPose refined = refine_pose(observations, truth, kCamera, model);
    const RigidTransform error = refined.reference_from_current.inverse() * truth;
    Vector6d e;
    e << error.translation, error.rotation.vec() * (error.rotation.w() < 0 ? -1 : 1);
    sum += e.dot(refined.information * e);
  }
  // Noise of half a sigma: a quarter of the squared error that the model expects.
  EXPECT_NEAR(sum / kTrials, 6 * 0.25, 0.2);
}

TEST(WithSystematicError, AddsItToTheCovariance) {
  RandomStream random(5);
  Matrix6d root;
  for (double& value : root.reshaped()) value = random.normal();
  const Matrix6d information = root * root.transpose() + Matrix6d::Identity();
  const Matrix6d weakened = with_systematic_error(information, 0.3, 0.2);
  Matrix6d covariance = information.inverse();
  covariance.diagonal().head<3>().array() += 0.09;
  covariance.diagonal().tail<3>().array() += 0.04;
  EXPECT_LT((weakened.inverse() - covariance).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((with_systematic_error(information, 0, 0) - information).cwiseAbs().maxCoeff(), 1e-9);
}

// A bare wall says nothing along itself, and much across.
TEST(WithSystematicError, KeepsWhatIsNotDeterminedSemidefinite) {
  RandomStream random(6);
  for (int trial = 0; trial < 200; ++trial) {
    Matrix6d information = Matrix6d::Zero();
    for (int seen = 0; seen < 2; ++seen) {
      Vector6d direction;
      for (double& value : direction) value = random.normal();
      information += 1e9 * direction * direction.transpose();
    }
    const Matrix6d weakened = with_systematic_error(information, 0.004, 0.0015);
    const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(weakened, Eigen::EigenvaluesOnly);
    EXPECT_GE(eigen.eigenvalues()[0], -1e-12 * eigen.eigenvalues()[5]) << trial;
  }
}

TEST(Residual, ItsJacobianIsItsDerivative) {
  constexpr double kStep = 1e-6;
  RandomStream random(4);
  const ResidualModel model{1.5, 40, 0.7};
  const RigidTransform pose = small_motion(random, 0.3);
  for (const PointObservation& observation : observe(pose, kCamera, model, 3, 40, random)) {
    const auto jacobian = residual_jacobian(observation, pose.inverse(), kCamera, model);
    for (Eigen::Index k = 0; k < 6; ++k) {
      const auto stepped = [&](double step) {
        const RigidTransform moved = pose * RigidTransform::exp(step * Vector6d::Unit(k));
        return residual(observation, moved.inverse(), kCamera, model);
      };
      const Eigen::Vector3d difference = (stepped(kStep) - stepped(-kStep)) / (2 * kStep);
      EXPECT_LT((jacobian.col(k) - difference).norm(), 1e-4 * (1 + difference.norm()));
    }
  }
}

TEST(Residual, IsInfiniteBehindTheCamera) {
  const PointObservation behind{{0, 0, -1}, {300, 200}, 0};
  EXPECT_FALSE(residual(behind, RigidTransform::identity(), kCamera, {}).allFinite());
}

}  // namespace
}  // namespace roomwise::motion
