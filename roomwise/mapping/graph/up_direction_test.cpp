#include "roomwise/mapping/graph/up_direction.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::mapping {
namespace {

using Eigen::Vector3d;
using geometry::PinholeCamera;
using geometry::RigidTransform;
using geometry::Vector6d;

constexpr double kDegree = 0.0174532925199433;

PinholeCamera small_camera() {
  PinholeCamera camera;
  camera.fx = camera.fy = 260;
  camera.cx = 159.5;
  camera.cy = 119.5;
  camera.width = 320;
  camera.height = 240;
  return camera;
}

// Points p of the room with normal . p = offset_m; the room has z up.
struct Plane {
  Vector3d normal;
  double offset_m;
};

// What a camera sees of planes: the nearest hit of each pixel's ray, with noise of a share of it.
image::DepthImage render(const std::vector<Plane>& planes, const RigidTransform& room_from_camera,
                         const PinholeCamera& camera, double noise) {
  RandomStream random(5);
  image::DepthImage depth(camera.width, camera.height);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Vector3d ray = room_from_camera.rotation * camera.unproject({double(x), double(y)}, 1);
      double nearest_m = std::numeric_limits<double>::infinity();
      for (const Plane& plane : planes) {
        const double z_m = (plane.offset_m - plane.normal.dot(room_from_camera.translation)) /
                           plane.normal.dot(ray);
        if (z_m > 0.3 && z_m < nearest_m) nearest_m = z_m;
      }
      if (nearest_m > 8) continue;
      nearest_m *= 1 + noise * random.normal();
      depth.at(x, y) = static_cast<std::uint16_t>(std::lround(nearest_m * 1000));
    }
  }
  return depth;
}

// A camera 1.4 m over the room's floor that looks along the room's x, turned to the left by `yaw`,
// bent down by `pitch` and then rolled.
RigidTransform walker(double yaw, double pitch, double roll) {
  Eigen::Matrix3d level;  // camera x (right) is -y of the room, y (down) is -z, z (forward) is x
  level.col(0) = -Vector3d::UnitY();
  level.col(1) = -Vector3d::UnitZ();
  level.col(2) = Vector3d::UnitX();
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(yaw, Vector3d::UnitZ()).toRotationMatrix() *
                               level *
                               Eigen::AngleAxisd(-pitch, Vector3d::UnitX()).toRotationMatrix() *
                               Eigen::AngleAxisd(roll, Vector3d::UnitZ()).toRotationMatrix();
  return RigidTransform::from_matrix(turn, {0, 0, 1.4});
}

const Plane kFloor{Vector3d::UnitZ(), 0};
const Plane kCeiling{Vector3d::UnitZ(), 2.4};
const Plane kWallAhead{Vector3d::UnitX(), 3};
const Plane kWallLeft{Vector3d::UnitY(), 2};

UpDirection estimate(const std::vector<Plane>& planes,
                     const std::vector<RigidTransform>& room_from_cameras,
                     const RigidTransform& world_from_room, double noise = 0.002) {
  UpDirectionEstimator estimator;
  for (const RigidTransform& room_from_camera : room_from_cameras) {
    estimator.add(world_from_room * room_from_camera,
                  render(planes, room_from_camera, small_camera(), noise), small_camera());
  }
  return estimator.estimate();
}

double angle_between(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

TEST(UpDirection, IsTheFloorsNormalAtAnyTiltOfTheCamera) {
  for (const double pitch : {0.2, 0.35, 0.5, 0.7}) {
    for (const double roll : {0.0, 0.25}) {
      // The usual world: the first camera's frame.
      const RigidTransform camera = walker(0.4, pitch, roll);
      const UpDirection up = estimate({kFloor, kWallAhead, kWallLeft}, {camera}, camera.inverse());
      EXPECT_LT(angle_between(up.up_world, camera.rotation.conjugate() * Vector3d::UnitZ()),
                1 * kDegree)
          << "pitch " << pitch << " roll " << roll;
      EXPECT_NEAR(up.up_world.norm(), 1, 1e-12);
      EXPECT_GT(up.support, 0.1);
    }
  }
}

TEST(UpDirection, ACeilingCountsReversed) {
  const RigidTransform camera = walker(0, -0.6, 0);
  const UpDirection up = estimate({kCeiling, kWallAhead}, {camera}, RigidTransform());
  EXPECT_LT(angle_between(up.up_world, Vector3d::UnitZ()), 1 * kDegree);
}

TEST(UpDirection, JoinsManyViewsInAnyWorldFrame) {
  Vector6d twist;
  twist << 0.9, -2, 0.4, 1, 2, 3;
  const RigidTransform world_from_room = RigidTransform::exp(twist);
  std::vector<RigidTransform> cameras;
  for (int i = 0; i < 6; ++i)
    cameras.push_back(walker(0.3 * i - 0.6, 0.1 * i, 0.1 * (i % 3) - 0.1));
  const std::vector<Plane> room = {kFloor, kCeiling, kWallAhead, kWallLeft};
  const UpDirection up = estimate(room, cameras, world_from_room, 0.004);
  EXPECT_LT(angle_between(up.up_world, world_from_room.rotation * Vector3d::UnitZ()),
            0.5 * kDegree);
  EXPECT_GT(up.support, 0.2);
  EXPECT_LT(up.support, 1);
}

TEST(UpDirection, FallsBackToTheCamerasWhereNoLevelSurfaceIsSeen) {
  const RigidTransform camera = walker(0.2, 0.1, 0.05);
  const UpDirection up = estimate({kWallAhead}, {camera}, RigidTransform());
  EXPECT_EQ(up.support, 0);
  EXPECT_LT(angle_between(up.up_world, camera.rotation * -Vector3d::UnitY()), 1e-9);
}

// A phone held upright: its pictures lie on their side.
RigidTransform sideways(const RigidTransform& camera) {
  return camera *
         RigidTransform{Eigen::Quaterniond(Eigen::AngleAxisd(90 * kDegree, Vector3d::UnitZ())),
                        Vector3d::Zero()};
}

UpDirection estimate_with_gravity(const std::vector<Plane>& planes, const RigidTransform& camera,
                                  const std::vector<Vector3d>& felt) {
  UpDirectionEstimator estimator;
  estimator.add(camera, render(planes, camera, small_camera(), 0.002), small_camera());
  for (const Vector3d& up : felt) estimator.add_gravity(up);
  return estimator.estimate();
}

TEST(UpDirection, IsTheFloorsInPicturesThatLieOnTheirSideWhereGravityIsFelt) {
  const RigidTransform camera = sideways(walker(0.4, 0.5, 0));
  const Vector3d felt = Vector3d(0.03, 0.02, 1).normalized();
  const UpDirection up = estimate_with_gravity({kFloor, kWallAhead, kWallLeft}, camera, {felt});
  EXPECT_TRUE(up.is_by_gravity);
  EXPECT_LT(angle_between(up.up_world, Vector3d::UnitZ()), 1 * kDegree) << "surer than gravity";
  const UpDirection without = estimate_with_gravity({kFloor, kWallAhead, kWallLeft}, camera, {});
  EXPECT_GT(angle_between(without.up_world, Vector3d::UnitZ()), 45 * kDegree);
}

TEST(UpDirection, LevelSurfacesCorrectGravityThatIsWrong) {
  const RigidTransform camera = walker(0.4, 0.5, 0);
  const Vector3d felt = Vector3d(0.4, 0, 1).normalized();
  const UpDirection up = estimate_with_gravity({kFloor, kWallAhead}, camera, {felt});
  EXPECT_LT(angle_between(up.up_world, Vector3d::UnitZ()), 1 * kDegree);
}

TEST(UpDirection, GravityThatContradictsItselfIsNotTaken) {
  const UpDirection up = estimate_with_gravity(
      {kFloor, kWallAhead}, walker(0.4, 0.5, 0),
      {Vector3d::UnitX(), Vector3d::UnitY(), Vector3d(0, -1, 0.2).normalized()});
  EXPECT_FALSE(up.is_by_gravity);
  EXPECT_LT(angle_between(up.up_world, Vector3d::UnitZ()), 1 * kDegree);
}

TEST(UpDirection, IsGravityWhereNoLevelSurfaceIsSeen) {
  const Vector3d felt = Vector3d(0.1, 0.2, 1).normalized();
  const UpDirection up = estimate_with_gravity({kWallAhead}, walker(0, 0, 0), {felt});
  EXPECT_EQ(up.support, 0);
  EXPECT_LT(angle_between(up.up_world, felt), 0.01 * kDegree);
}

TEST(UpDirection, ADepthImageWithHolesOrJumpsGivesNoWrongNormals) {
  // Depth that jumps from pixel to pixel holds no surface at all.
  const PinholeCamera camera = small_camera();
  image::DepthImage noise(camera.width, camera.height);
  RandomStream random(9);
  for (auto& value : noise.pixels()) {
    value = static_cast<std::uint16_t>(random.index(2) == 0 ? 0 : 500 + random.index(3000));
  }
  UpDirectionEstimator estimator;
  estimator.add(RigidTransform(), noise, camera);
  EXPECT_EQ(estimator.estimate().support, 0);
}

TEST(UpDirection, WithoutAnyKeyFrameIsTheWorldsMinusY) {
  const UpDirection up = UpDirectionEstimator().estimate();
  EXPECT_EQ(up.up_world, -Vector3d::UnitY());
  EXPECT_EQ(up.support, 0);
}

TEST(UpDirectionOptions, NamesTheFieldThatIsWrong) {
  EXPECT_OK(UpDirectionOptions().validate());
  EXPECT_ERROR(UpDirectionOptions{.grid_columns = 0}.validate(), "grid_columns");
  EXPECT_ERROR(UpDirectionOptions{.max_tilt_rad = 2}.validate(), "max_tilt_rad");
  EXPECT_ERROR(UpDirectionOptions{.inlier_angle_rad = 1}.validate(), "inlier_angle_rad");
}

}  // namespace
}  // namespace roomwise::mapping
