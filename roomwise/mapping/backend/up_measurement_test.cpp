#include "roomwise/mapping/backend/up_measurement.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/mapping/graph/edge_error.h"

namespace roomwise::mapping {
namespace {

using Eigen::Vector3d;
using geometry::RigidTransform;
using Normals = std::vector<Eigen::Vector3f>;

const Vector3d kUp = Vector3d(0.1, -1, -0.3).normalized();  // of a camera bent down and rolled
const Vector3d kAhead = kUp.cross(Vector3d::UnitX()).normalized();
const Vector3d kAside = kUp.cross(kAhead);
const Vector3d kStill = Vector3d::Zero();

// So many normals of a surface, as a depth camera errs.
void add_surface(Normals& normals, const Vector3d& normal, int count, double noise_rad = 0.02) {
  RandomStream random(static_cast<std::uint64_t>(count));
  for (int i = 0; i < count; ++i) {
    const Vector3d off(random.normal(), random.normal(), random.normal());
    normals.push_back((normal + noise_rad * off).normalized().cast<float>());
  }
}

double angle_between(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

// The expected direction, some degrees off.
const Vector3d kExpected = (kUp + 0.05 * kAhead - 0.03 * kAside).normalized();

TEST(MeasureUp, IsWhatFloorCeilingAndWallsSayTogether) {
  for (const auto& surfaces : std::vector<std::vector<Vector3d>>{
           {kUp}, {-kUp}, {kAhead, kAside}, {kUp, kAhead}, {kUp, -kUp, kAside}}) {
    Normals normals;
    for (const Vector3d& surface : surfaces) add_surface(normals, surface, 200);
    const auto measured = measure_up(normals, kExpected, kStill);
    ASSERT_TRUE(measured);
    EXPECT_LT(angle_between(measured->up_camera, kUp), 0.005);
    EXPECT_NEAR(measured->up_camera.dot(measured->information * measured->up_camera), 0, 1e-6);
    // Within a few of its own standard deviations.
    const Vector3d turn = measured->up_camera.cross(kUp);
    EXPECT_LT(turn.dot(measured->information * turn), 12);
  }
}

TEST(MeasureUp, OneWallTellsOfTheTurnAlongItAlone) {
  Normals normals;
  add_surface(normals, kAhead, 300);
  const auto measured = measure_up(normals, kExpected, kStill);
  ASSERT_TRUE(measured);
  // It stands along the wall, and as it was expected in the wall's plane.
  EXPECT_NEAR(measured->up_camera.dot(kAhead), 0, 0.005);
  EXPECT_LT(angle_between(measured->up_camera, kExpected), 0.06);
  const auto known = [&](const Vector3d& axis) { return axis.dot(measured->information * axis); };
  EXPECT_GT(known(kAside), 500 * known(kAhead));
}

TEST(MeasureUp, WhatSlopesTellsNothing) {
  Normals normals;
  add_surface(normals, (kUp + kAhead).normalized(), 300);
  EXPECT_FALSE(measure_up(normals, kExpected, kStill));
  EXPECT_FALSE(measure_up({}, kExpected, kStill));

  add_surface(normals, kUp, 100);
  const auto measured = measure_up(normals, kExpected, kStill);
  ASSERT_TRUE(measured);
  EXPECT_LT(angle_between(measured->up_camera, kUp), 0.01);
}

TEST(MeasureUp, IsSurerWithMoreSurfaceAndLessSureInAQuickTurn) {
  Normals few, many;
  add_surface(few, kUp, 20);
  add_surface(many, kUp, 500);
  const auto known = [](const Normals& normals, const Vector3d& turning_rad_s) {
    return measure_up(normals, kUp, turning_rad_s)->information;
  };
  EXPECT_GT(known(many, kStill).trace(), 2 * known(few, kStill).trace());
  // Only about the axis of the turn, and not at all where that is up.
  const Eigen::Matrix3d still = known(many, kStill), tilting = known(many, kAside);
  EXPECT_LT(kAside.dot(tilting * kAside), 0.01 * kAside.dot(still * kAside));
  const Vector3d other = kUp.cross(kAside).normalized();
  EXPECT_NEAR(other.dot(tilting * other), other.dot(still * other), 1e-6 * still.trace());
  EXPECT_LT((known(many, kUp) - still).norm(), 0.01 * still.norm()) << "as up is found";
}

TEST(UpEdge, HoldsTheTiltAndNothingElse) {
  UpMeasurement measurement{kUp, 1e4 * (Eigen::Matrix3d::Identity() - kUp * kUp.transpose())};
  const RigidTransform world_from_ground{Eigen::Quaterniond(0.9, 0.1, -0.3, 0.2).normalized(), {}};
  RigidTransform ground_from_camera;
  ground_from_camera.rotation = Eigen::Quaterniond::FromTwoVectors(kUp, Vector3d::UnitZ());
  const auto edge_at = [&](const RigidTransform& pose) {
    return up_edge(7, world_from_ground, 3, pose, measurement, 2);
  };
  for (const double yaw : {0.0, 1.0, 3.0}) {
    RigidTransform moved = ground_from_camera;
    moved.rotation = Eigen::AngleAxisd(yaw, Vector3d::UnitZ()) * moved.rotation;
    moved.translation = {3 * yaw, -2, 5};
    const RigidTransform upright = world_from_ground * moved;
    const PoseGraphEdge edge = edge_at(upright);
    EXPECT_EQ(edge.from, 7U);
    EXPECT_EQ(edge.to, 3U);
    EXPECT_NEAR(edge_cost(edge, world_from_ground, upright), 0, 1e-9);
    // Made there, it says the same of other ways to turn about up.
    EXPECT_NEAR(
        edge_cost(edge_at(world_from_ground * ground_from_camera), world_from_ground, upright), 0,
        1e-9);
    // A tilt of half a sigma costs a quarter of what one sigma does, whichever way it goes.
    for (const Vector3d& axis : {kAhead, kAside}) {
      RigidTransform tilted = upright;
      tilted.rotation = tilted.rotation * Eigen::AngleAxisd(0.005, axis);
      EXPECT_NEAR(edge_cost(edge, world_from_ground, tilted), 0.25, 1e-3);
    }
  }
}

TEST(UpEdge, CountsLessTheFurtherOffItIs) {
  const UpMeasurement measurement{kUp, 1e4 * (Eigen::Matrix3d::Identity() - kUp * kUp.transpose())};
  const auto weight_at = [&](double tilt_rad) {
    RigidTransform pose;
    pose.rotation = Eigen::AngleAxisd(tilt_rad, Vector3d::UnitX()) *
                    Eigen::Quaterniond::FromTwoVectors(kUp, Vector3d::UnitZ());
    return up_edge(1, {}, 0, pose, measurement, 2).information.trace();
  };
  EXPECT_NEAR(weight_at(0.02), weight_at(0) / 2,
              1e-3 * weight_at(0));  // at the kernel's two sigmas
  EXPECT_LT(weight_at(0.2), 0.02 * weight_at(0));
}

TEST(UpMeasurementOptions, NamesWhatIsWrong) {
  const auto wrong = [](auto set) {
    UpMeasurementOptions options;
    set(options);
    return options.validate();
  };
  EXPECT_ERROR(wrong([](auto& o) { o.inlier_angle_rad = 0; }), "inlier_angle_rad");
  EXPECT_ERROR(wrong([](auto& o) { o.normal_sigma_rad = 0; }), "normal_sigma_rad");
  EXPECT_ERROR(wrong([](auto& o) { o.systematic_sigma_rad = -1; }), "systematic_sigma_rad");
  EXPECT_ERROR(wrong([](auto& o) { o.delay_s = std::nan(""); }), "delay_s");
}

}  // namespace
}  // namespace roomwise::mapping
