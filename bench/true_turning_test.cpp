#include "true_turning.h"

#include <gtest/gtest.h>

#include "roomwise/base/testing/testing.h"

namespace roomwise {
namespace {

recording::StampedPose turned(TimestampNs time_ns, double rad) {
  recording::StampedPose pose;
  pose.timestamp_ns = time_ns;
  pose.world_from_camera.rotation = Eigen::AngleAxisd(rad, Eigen::Vector3d::UnitY());
  return pose;
}

TEST(TrueTurning, IsToldByThePosesBeside) {
  const recording::Trajectory truth{turned(0, 0), turned(500'000'000, 0.1),
                                    turned(1'000'000'000, 0.4)};
  EXPECT_NEAR(true_turning_rad_s(truth, 0)->y(), 0.2, 1e-9);
  EXPECT_NEAR(true_turning_rad_s(truth, 1)->y(), 0.4, 1e-9);
  EXPECT_NEAR(true_turning_rad_s(truth, 2)->y(), 0.6, 1e-9);
}

TEST(TrueTurning, IsNotToldByOnePoseNorByOneTime) {
  EXPECT_ERROR(true_turning_rad_s({turned(5, 0.3)}, 0), "takes two at different times");
  EXPECT_ERROR(true_turning_rad_s({turned(5, 0.3), turned(5, 0.4)}, 1), "the true poses (2)");
}

}  // namespace
}  // namespace roomwise
