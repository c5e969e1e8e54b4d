#include "roomwise/evaluation/errors/trajectory_error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "roomwise/base/testing/testing.h"

namespace roomwise::evaluation {
namespace {

using geometry::RigidTransform;
using recording::Trajectory;
using Unit = RelativePoseErrorOptions::Unit;

constexpr TimestampNs kStepNs = 100'000'000;

RigidTransform turned(const Eigen::Vector3d& axis, double angle_rad,
                      const Eigen::Vector3d& translation) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(angle_rad, axis)), translation};
}

// A hundred poses, ten a second, on a curve through space.
Trajectory curve() {
  Trajectory trajectory;
  for (int i = 0; i < 100; ++i) {
    trajectory.push_back({i * kStepNs, turned(Eigen::Vector3d::UnitZ(), 0.1 * i,
                                              {2 * std::cos(0.1 * i), 1.5 * std::sin(0.1 * i),
                                               0.3 * std::sin(0.05 * i)})});
  }
  return trajectory;
}

// The same seen from another frame, a little late, with an error that formulas give.
Trajectory disturbed(const Trajectory& truth) {
  const RigidTransform other_from_world =
      turned(Eigen::Vector3d(0.6, 0, 0.8), 2, Eigen::Vector3d(3, -2, 1));
  Trajectory estimate;
  for (std::size_t k = 0; k < truth.size(); ++k) {
    const double i = static_cast<double>(k);
    RigidTransform pose = truth[k].world_from_camera;
    pose.translation +=
        0.02 * Eigen::Vector3d(std::sin(1.7 * i), std::cos(2.3 * i), std::sin(3.1 * i));
    pose.rotation =
        pose.rotation * Eigen::AngleAxisd(0.002 * i * std::sin(i), Eigen::Vector3d::UnitX());
    estimate.push_back({truth[k].timestamp_ns + 5'000'000, other_from_world * pose});
  }
  return estimate;
}

TEST(ErrorStatistics, AreTheKnownOnes) {
  const ErrorStatistics s = ErrorStatistics::of({4, 1, 2, 5});
  EXPECT_NEAR(s.rmse, std::sqrt(46.0 / 4), 1e-12);
  EXPECT_NEAR(s.mean, 3, 1e-12);
  EXPECT_NEAR(s.median, 3, 1e-12);
  EXPECT_NEAR(s.std, std::sqrt(10.0 / 4), 1e-12);
  EXPECT_EQ(s.min, 1);
  EXPECT_EQ(s.max, 5);
  EXPECT_EQ(ErrorStatistics::of({7, 1, 2}).median, 2);
}

TEST(AbsoluteTrajectoryError, AgreesWithValuesComputedElsewhere) {
  // The figures come from another implementation: Horn's own quaternion method, the greatest
  // eigenvector by power iteration.
  const Trajectory truth = curve();
  const auto ate = absolute_trajectory_error(truth, disturbed(truth));
  ASSERT_OK(ate);
  EXPECT_EQ(ate->pairs.size(), 100);
  EXPECT_NEAR(ate->error_m.rmse, 0.02401580587185803, 1e-12);
  EXPECT_NEAR(ate->error_m.mean, 0.023392249980428978, 1e-12);
  EXPECT_NEAR(ate->error_m.median, 0.02379238752740278, 1e-12);
  EXPECT_NEAR(ate->error_m.std, 0.005437055501637915, 1e-12);
  EXPECT_NEAR(ate->error_m.min, 0.005870902831424302, 1e-12);
  EXPECT_NEAR(ate->error_m.max, 0.03320547552999268, 1e-12);
  EXPECT_NEAR(ate->best_scale, 0.9997147847711335, 1e-12);
  EXPECT_NEAR(ate->scaled_rmse_m, 0.024010508855308955, 1e-12);
}

TEST(AbsoluteTrajectoryError, ARigidMovementIsNoError) {
  const Trajectory truth = curve();
  Trajectory estimate = truth;
  const RigidTransform other_from_world = turned(Eigen::Vector3d::UnitY(), 1, {5, 6, 7});
  for (auto& pose : estimate) pose.world_from_camera = other_from_world * pose.world_from_camera;
  const auto ate = absolute_trajectory_error(truth, estimate);
  ASSERT_OK(ate);
  EXPECT_LT(ate->error_m.max, 1e-12);
  EXPECT_LT((ate->truth_from_estimate * other_from_world).distance_m(), 1e-12);
}

TEST(AbsoluteTrajectoryError, AScaleIsAnErrorAndReportedApart) {
  const Trajectory truth = curve();
  Trajectory estimate = truth;
  for (auto& pose : estimate) pose.world_from_camera.translation *= 0.8;
  const auto ate = absolute_trajectory_error(truth, estimate);
  ASSERT_OK(ate);
  EXPECT_GT(ate->error_m.rmse, 0.1);
  EXPECT_NEAR(ate->best_scale, 1.25, 1e-9);
  EXPECT_LT(ate->scaled_rmse_m, 1e-9);
}

TEST(AbsoluteTrajectoryError, PairsByTimeAndLeavesTheRest) {
  const Trajectory truth = curve();
  Trajectory estimate = truth;
  estimate[3].timestamp_ns += 19'000'000;
  estimate[4].timestamp_ns += 21'000'000;  // too far from any
  estimate.erase(estimate.begin() + 10, estimate.begin() + 20);
  const auto ate = absolute_trajectory_error(truth, estimate);
  ASSERT_OK(ate);
  EXPECT_EQ(ate->pairs.size(), 89);
  EXPECT_EQ(ate->pairs[3].timestamp_ns, truth[3].timestamp_ns);
  EXPECT_EQ(ate->pairs[4].timestamp_ns, truth[5].timestamp_ns);
  EXPECT_LT(ate->error_m.max, 1e-12);
  const auto wider = absolute_trajectory_error(truth, estimate, 0.03);
  ASSERT_OK(wider);
  EXPECT_EQ(wider->pairs.size(), 90);
}

TEST(AbsoluteTrajectoryError, SaysWhyThereIsNone) {
  const Trajectory truth = curve();
  Trajectory later = truth;
  for (auto& pose : later) pose.timestamp_ns += 1'000'000'000'000;
  EXPECT_ERROR(absolute_trajectory_error(truth, later),
               "no pose of the estimate (times 1000.000000 to 1009.900000) lies within 0.02 s of "
               "one of the truth (0.000000 to 9.900000)");
  EXPECT_ERROR(absolute_trajectory_error(truth, std::span(truth).first(2)), "at least 3");
  EXPECT_ERROR(absolute_trajectory_error(truth, {}), "estimated trajectory holds no pose");
  EXPECT_ERROR(absolute_trajectory_error({}, truth), "true trajectory holds no pose");
  EXPECT_ERROR(absolute_trajectory_error(truth, truth, 1e300), "max_time_difference_s");
  EXPECT_ERROR(absolute_trajectory_error(truth, truth, 0), "max_time_difference_s");
  EXPECT_ERROR(absolute_trajectory_error(truth, truth, std::numeric_limits<double>::quiet_NaN()),
               "max_time_difference_s");
  Trajectory still = truth;
  for (auto& pose : still) pose.world_from_camera.translation.setZero();
  EXPECT_ERROR(absolute_trajectory_error(truth, still), "one line");
}

TEST(RelativePoseError, AgreesWithValuesComputedElsewhere) {
  const Trajectory truth = curve();
  const auto rpe = relative_pose_error(truth, disturbed(truth));
  ASSERT_OK(rpe);
  EXPECT_EQ(rpe->count, 90);
  EXPECT_NEAR(rpe->translation_m.rmse, 0.11420650347645472, 1e-12);
  EXPECT_NEAR(rpe->translation_m.max, 0.2709171170107267, 1e-12);
  EXPECT_NEAR(rpe->rotation_deg.rmse, 7.769675906012946, 1e-9);
  EXPECT_NEAR(rpe->rotation_deg.mean, 6.344835294690169, 1e-9);
}

TEST(RelativePoseError, MeasuresDriftPerDelta) {
  // Along x at 1 m/s; the estimate drifts by 2 cm and 0.5 degrees about x each second.
  Trajectory truth;
  Trajectory estimate;
  for (int i = 0; i < 50; ++i) {
    const double t_s = 0.1 * i;
    truth.push_back({i * kStepNs, turned(Eigen::Vector3d::UnitX(), 0, {t_s, 0, 0})});
    estimate.push_back(
        {i * kStepNs,
         turned(Eigen::Vector3d::UnitX(), 0.5 * t_s * std::numbers::pi / 180, {1.02 * t_s, 0, 0})});
  }
  const auto per_second = relative_pose_error(truth, estimate);
  ASSERT_OK(per_second);
  EXPECT_EQ(per_second->count, 40);
  EXPECT_NEAR(per_second->translation_m.min, 0.02, 1e-12);
  EXPECT_NEAR(per_second->translation_m.max, 0.02, 1e-12);
  EXPECT_NEAR(per_second->rotation_deg.rmse, 0.5, 1e-9);

  const auto per_frame = relative_pose_error(truth, estimate, {.delta = 1, .unit = Unit::kFrames});
  ASSERT_OK(per_frame);
  EXPECT_EQ(per_frame->count, 49);
  EXPECT_NEAR(per_frame->translation_m.rmse, 0.002, 1e-12);
}

TEST(RelativePoseError, ComparesNothingAcrossAGap) {
  const Trajectory truth = curve();
  Trajectory estimate = truth;
  estimate.erase(estimate.begin() + 5, estimate.begin() + 50);
  const auto rpe = relative_pose_error(truth, estimate);
  ASSERT_OK(rpe);
  EXPECT_EQ(rpe->count, 40);  // those that begin after the gap
}

TEST(RelativePoseError, SaysWhyThereIsNone) {
  const Trajectory truth = curve();
  EXPECT_ERROR(relative_pose_error(truth, truth, {.delta = 20}), "no two poses");
  EXPECT_ERROR(relative_pose_error(truth, truth, {.delta = 0}), "delta is 0");
  EXPECT_ERROR(relative_pose_error(truth, truth, {.delta = 1.5, .unit = Unit::kFrames}),
               "whole number");
  EXPECT_ERROR(relative_pose_error(truth, truth, {.delta = 1e-12}), "delta is 1e-12");
  EXPECT_ERROR(relative_pose_error(truth, {}), "estimated trajectory holds no pose");
}

}  // namespace
}  // namespace roomwise::evaluation
