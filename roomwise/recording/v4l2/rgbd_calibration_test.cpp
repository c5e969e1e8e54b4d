#include "roomwise/recording/v4l2/rgbd_calibration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "roomwise/base/file.h"
#include "roomwise/base/testing/testing.h"

namespace roomwise::recording {
namespace {

constexpr const char* kColorLine = "color 610 611 320.5 240.5 640 480\n";
constexpr const char* kUnitsLine = "depth_units_per_metre 1000\n";
constexpr const char* kDepthLine = "depth 430 430 424 240 848 480 0.1 0 0 0 0\n";
constexpr const char* kMotionLine = "color_from_depth 0 -1 0 0.015 1 0 0 0 0 0 1 0.001\n";

class RgbdCalibrationFile : public ::testing::Test {
 protected:
  [[nodiscard]] Expected<RgbdCalibration> read(const std::string& text) const {
    EXPECT_OK(write_file(folder_ / "rgbd.txt", text));
    return read_rgbd_calibration(folder_ / "rgbd.txt");
  }
  testing::ScratchFolder folder_;
};

TEST_F(RgbdCalibrationFile, HoldsTwoCamerasAndTheirPlaces) {
  const auto both = read(std::string("# of a camera\n") + kMotionLine + kColorLine + "\n" +
                         kDepthLine + kUnitsLine);
  ASSERT_OK(both);
  EXPECT_EQ(both->color.fy, 611);
  EXPECT_EQ(both->color.width, 640);
  EXPECT_EQ(both->color.depth_units_per_metre, 1000);
  EXPECT_EQ(both->depth.value().cx, 424);
  EXPECT_EQ(both->depth.value().distortion.k1, 0.1);
  EXPECT_EQ(both->depth.value().depth_units_per_metre, 1000);
  const Eigen::Vector3d moved = both->color_from_depth * Eigen::Vector3d(1, 0, 0);
  EXPECT_LT((moved - Eigen::Vector3d(0.015, 1, 0.001)).norm(), 1e-9);
}

TEST_F(RgbdCalibrationFile, HoldsOneWhereDepthIsRegistered) {
  const auto one = read(std::string(kColorLine) + kUnitsLine);
  ASSERT_OK(one);
  EXPECT_FALSE(one->depth.has_value());
}

TEST_F(RgbdCalibrationFile, NamesWhatIsWrongAndWhere) {
  const std::string color = kColorLine, units = kUnitsLine;
  EXPECT_ERROR(read(color), "rgbd.txt: has no line 'depth_units_per_metre'");
  EXPECT_ERROR(read(units), "rgbd.txt: has no line 'color'");
  EXPECT_ERROR(read(color + units + kDepthLine),
               "has 'depth' but not 'color_from_depth'; give both, or neither");
  EXPECT_ERROR(read(color + units + kMotionLine), "has 'color_from_depth' but not 'depth'");
  EXPECT_ERROR(read(color + color), "rgbd.txt:2: 'color' is there twice");
  EXPECT_ERROR(read("colour 1\n"), "rgbd.txt:1: 'colour' is not known; expected color, depth");
  EXPECT_ERROR(read("color 1 two\n"), "rgbd.txt:1: 'two' is not a number");
  EXPECT_ERROR(read(units + "color 610 611 320 240\n"),
               "rgbd.txt:2: 'color' has 4 numbers, expected 6 or 11");
  EXPECT_ERROR(read(units + "color 610 611 320 240 640.5 480\n"), "whole numbers of pixels");
  EXPECT_ERROR(read(units + "color 610 611 3200 240 640 480\n"), "rgbd.txt:2: ");
  EXPECT_ERROR(read(color + "depth_units_per_metre 0\n"), "rgbd.txt:1: ");
  EXPECT_ERROR(read(color + units + kDepthLine + "color_from_depth 2 0 0 0 0 1 0 0 0 0 1 0\n"),
               "rgbd.txt:4: 'color_from_depth' has no rotation");
  EXPECT_ERROR(read(color + units + kDepthLine + "color_from_depth 1 0 0 15 0 1 0 0 0 0 1 0\n"),
               "15.00 m apart; give its last column in metres");
}

}  // namespace
}  // namespace roomwise::recording
