#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "roomwise/base/random.h"
#include "roomwise/base/testing/testing.h"
#include "roomwise/geometry/alignment.h"
#include "roomwise/geometry/pinhole_camera.h"
#include "roomwise/geometry/point_cloud.h"

namespace roomwise::geometry {
namespace {

Eigen::Vector3d random_vector(RandomStream& random) {
  return {random.normal(), random.normal(), random.normal()};
}

RigidTransform random_transform(RandomStream& random) {
  Vector6d twist;
  twist << random_vector(random), random_vector(random);
  return RigidTransform::exp(twist);
}

TEST(RigidTransform, ComposesAndInverts) {
  RandomStream random(1);
  for (int i = 0; i < 50; ++i) {
    const RigidTransform a_from_b = random_transform(random);
    const RigidTransform b_from_c = random_transform(random);
    const Eigen::Vector3d point_c = random_vector(random);
    EXPECT_LT(((a_from_b * b_from_c) * point_c - a_from_b * (b_from_c * point_c)).norm(), 1e-12);
    const RigidTransform nothing = a_from_b.inverse() * a_from_b;
    EXPECT_LT(nothing.angle_rad() + nothing.distance_m(), 1e-12);
  }
}

TEST(RigidTransform, ExpIsSmoothThroughZero) {
  Vector6d twist;
  twist << 0.3, -0.2, 0.4, 1, 2, 3;
  for (const double scale : {1e-7, 0.999e-6 / 0.54, 1.001e-6 / 0.54, 1e-3}) {
    const RigidTransform half = RigidTransform::exp(0.5 * scale * twist);
    const RigidTransform whole = RigidTransform::exp(scale * twist);
    const RigidTransform difference = (half * half).inverse() * whole;
    EXPECT_LT(difference.angle_rad() + difference.distance_m(), 1e-13) << scale;
    EXPECT_NEAR(whole.angle_rad(), scale * twist.head<3>().norm(), 1e-13);
  }
}

TEST(PinholeCamera, UndistortionInvertsDistortion) {
  for (const char* name : {"fr1", "fr2", "fr3", "kinect-v1", "xtion"}) {
    const PinholeCamera camera = camera_preset(name).value();
    EXPECT_OK(camera.validate());
    for (double y = 0; y < camera.height; y += 37) {
      for (double x = 0; x < camera.width; x += 37) {
        const Eigen::Vector2d pixel(x, y);
        EXPECT_LT((camera.project(camera.unproject(pixel, 2.5)) - pixel).norm(), 1e-6)
            << name << x << ' ' << y;
      }
    }
  }
}

TEST(PinholeCamera, DistortsAsOpenCvDoes) {
  // cv::projectPoints gives this pixel for fr1 and the point (0.4, -0.3, 1.0): by hand from Brown's
  // model x' = 0.4, y' = -0.3, r2 = 0.25.
  const PinholeCamera camera = camera_preset("fr1").value();
  const double radial = 1 + 0.2624 * 0.25 - 0.9531 * 0.0625 + 1.1633 * 0.015625;
  const double x = 0.4 * radial + 2 * -0.0054 * 0.4 * -0.3 + 0.0026 * (0.25 + 2 * 0.16);
  const double y = -0.3 * radial + -0.0054 * (0.25 + 2 * 0.09) + 2 * 0.0026 * 0.4 * -0.3;
  const Eigen::Vector2d pixel = camera.project({0.4, -0.3, 1.0});
  EXPECT_NEAR(pixel.x(), 517.3 * x + 318.6, 1e-9);
  EXPECT_NEAR(pixel.y(), 516.5 * y + 255.3, 1e-9);
}

TEST(PinholeCamera, SaysWhatIsWrong) {
  PinholeCamera camera = camera_preset("fr3").value();
  camera.fx = std::numeric_limits<double>::quiet_NaN();
  EXPECT_ERROR(camera.validate(), "fx");
  const auto is_refused = [](double PinholeCamera::*value, double is, const char* why) {
    PinholeCamera wrong = camera_preset("fr3").value();
    wrong.*value = is;
    EXPECT_ERROR(wrong.validate(), why);
  };
  for (const double f : {1e300, 5.0, 0.0, -535.0, 127.0, 3201.0}) {
    is_refused(&PinholeCamera::fx, f,
               "cannot be: a camera of pictures 640 px wide has 128 to 3200");
    is_refused(&PinholeCamera::fy, f, "focal lengths");
  }
  for (const double c : {99999.0, -1.0, 640.0, std::numeric_limits<double>::infinity()}) {
    is_refused(&PinholeCamera::cx, c, "lies outside the picture of 640x480");
    is_refused(&PinholeCamera::cy, c, "lies outside");
  }
  for (const double units : {1e-6, 99.0, 100'001.0, 0.0}) {
    is_refused(&PinholeCamera::depth_units_per_metre, units, "expected 100 to 100000");
  }
  const auto of_lens = [](const LensDistortion& lens) {
    PinholeCamera bent = camera_preset("fr1").value();
    bent.distortion = lens;
    return bent.validate();
  };
  // Strong, but lenses like these there are.
  EXPECT_OK(of_lens({-0.35, 0.12, 0, 0, -0.02}));
  EXPECT_OK(of_lens({0.1, -0.3, 0.01, -0.01, 0.2}));
  for (const LensDistortion& lens :
       {LensDistortion{.k1 = -5}, LensDistortion{.k1 = -0.8}, LensDistortion{.k2 = -2},
        LensDistortion{.p1 = 3}, LensDistortion{.k1 = 1e300}, LensDistortion{.k3 = -1e300}}) {
    EXPECT_ERROR(of_lens(lens), "it folds the picture before its corner, or stretches it tenfold");
  }
  EXPECT_ERROR(camera_preset("fr9"), "fr1, fr2");
}

TEST(PinholeCamera, DoubtsWhatIsUnusual) {
  for (const char* name : {"fr1", "fr2", "fr3", "kinect-v1", "xtion"}) {
    EXPECT_EQ(camera_preset(name)->doubt(), std::nullopt) << name;
  }
  const auto is_doubted = [](double PinholeCamera::*value, double is, const char* why) {
    PinholeCamera unusual = camera_preset("fr3").value();
    unusual.*value = is;
    EXPECT_OK(unusual.validate());
    EXPECT_THAT(unusual.doubt().value_or(""), ::testing::HasSubstr(why));
  };
  is_doubted(&PinholeCamera::fx, 2000, "focal length of 2000 px is unusual");
  is_doubted(&PinholeCamera::fy, 300, "far from square");
  is_doubted(&PinholeCamera::cx, 20, "far from the middle");
  is_doubted(&PinholeCamera::depth_units_per_metre, 100, "100 depth units per metre are unusual");
}

TEST(AlignPoints, FindsTheTransformOfNoisyPoints) {
  RandomStream random(3);
  const RigidTransform to_from_from = random_transform(random);
  std::vector<Eigen::Vector3d> from;
  std::vector<Eigen::Vector3d> to;
  for (int i = 0; i < 200; ++i) {
    from.push_back(random_vector(random));
    to.push_back(to_from_from * from.back() + 1e-3 * random_vector(random));
  }
  const auto found = align_points(from, to);
  ASSERT_OK(found);
  const RigidTransform error = to_from_from.inverse() * *found;
  EXPECT_LT(error.angle_rad(), 5e-4);
  EXPECT_LT(error.distance_m(), 5e-4);
}

TEST(AlignPoints, NeverMirrors) {
  // Four points of a plane with their mirror image: the best proper rotation, never a reflection.
  const std::vector<Eigen::Vector3d> from{{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, 2, 0}};
  std::vector<Eigen::Vector3d> to = from;
  for (auto& point : to) point.x() = -point.x();
  EXPECT_NEAR(align_points(from, to).value().rotation_matrix().determinant(), 1, 1e-12);
}

TEST(AlignPoints, RefusesWhatDoesNotDetermineARotation) {
  const std::vector<Eigen::Vector3d> line{{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {5, 5, 5}};
  EXPECT_ERROR(align_points(line, line), "one line");
  EXPECT_ERROR(align_points(std::span(line).first(2), std::span(line).first(2)), "at least 3");
}

TEST(VoxelGrid, KeepsOneMeanPointAVoxel) {
  VoxelGrid grid(0.1);
  grid.add({0.01, 0.01, 0.01}, {10, 0, 0});
  grid.add({0.03, 0.05, 0.07}, {20, 0, 0});
  grid.add({-0.01, 0.01, 0.01}, {0, 255, 0});
  const PointCloud cloud = grid.cloud();
  ASSERT_EQ(cloud.size(), 2U);
  EXPECT_LT((cloud.points[0] - Eigen::Vector3f(-0.01F, 0.01F, 0.01F)).norm(), 1e-6F);
  EXPECT_LT((cloud.points[1] - Eigen::Vector3f(0.02F, 0.03F, 0.04F)).norm(), 1e-6F);
  EXPECT_EQ(cloud.colors[1], (Rgb8{15, 0, 0}));
}

TEST(VoxelGrid, LeavesOutWhatIsNoPlace) {
  VoxelGrid grid(0.1);
  grid.add({std::numeric_limits<double>::quiet_NaN(), 0, 0}, {});
  grid.add({1e9, 0, 0}, {});
  EXPECT_EQ(grid.size(), 0U);
}

}  // namespace
}  // namespace roomwise::geometry
