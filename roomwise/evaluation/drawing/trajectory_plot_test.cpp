#include "roomwise/evaluation/drawing/trajectory_plot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "roomwise/evaluation/testing/test_markup.h"

namespace roomwise::evaluation {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// A circle of radius 1 m across `up`, estimated 0.1 m too high.
AbsoluteTrajectoryError circle(const Eigen::Vector3d& up, int count) {
  const Eigen::Vector3d right = up.unitOrthogonal();
  const Eigen::Vector3d ahead = up.cross(right);
  AbsoluteTrajectoryError error;
  for (int i = 0; i < count; ++i) {
    const double angle = 0.1 * i;
    const Eigen::Vector3d place = std::cos(angle) * right + std::sin(angle) * ahead;
    error.pairs.push_back({i, place, place + 0.1 * up});
  }
  error.error_m.rmse = 0.1;
  return error;
}

TEST(TrajectoryPlot, DrawsTruthEstimateAndEachDifference) {
  const std::string svg =
      plot_trajectory(circle(Eigen::Vector3d::UnitZ(), 60), {.title = "fr1 <rpy>"}).element();
  EXPECT_EQ(count_of(svg, "<polyline"), 2);
  EXPECT_EQ(count_of(svg, "class=\"difference\""), 60 + 1);  // and one in the legend
  EXPECT_THAT(svg, HasSubstr(">fr1 &lt;rpy&gt;: ATE 0.1000 m RMSE over 60 poses<"));
  for (const char* name : {">truth<", ">estimate<", ">difference<"}) {
    EXPECT_THAT(svg, HasSubstr(name));
  }
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
}

TEST(TrajectoryPlot, ShowsTheTwoAxesOfLargestExtent) {
  const std::string level = plot_trajectory(circle(Eigen::Vector3d::UnitZ(), 60)).element();
  EXPECT_THAT(level, HasSubstr(">x [m]<"));
  EXPECT_THAT(level, HasSubstr(">y [m]<"));
  const std::string upright = plot_trajectory(circle(Eigen::Vector3d::UnitY(), 60)).element();
  EXPECT_THAT(upright, HasSubstr(">x [m]<"));
  EXPECT_THAT(upright, HasSubstr(">z [m]<"));
  const std::string across_x = plot_trajectory(circle(Eigen::Vector3d::UnitX(), 60)).element();
  EXPECT_THAT(across_x, HasSubstr(">y [m]<"));
  EXPECT_THAT(across_x, HasSubstr(">z [m]<"));
}

TEST(TrajectoryPlot, FromAboveADifferenceInHeightDoesNotShow) {
  const Eigen::Vector3d up = Eigen::Vector3d(0.2, -0.9, 0.3).normalized();
  const std::string svg = plot_trajectory(circle(up, 30), {.title = "above", .up = up}).element();
  const std::size_t truth = svg.find("<polyline");
  const std::size_t estimate = svg.find("<polyline", truth + 1);
  const auto points = [&](std::size_t place) {
    return svg.substr(place, svg.find("\" fill", place) - place);
  };
  EXPECT_EQ(points(truth), points(estimate));
}

TEST(TrajectoryPlot, BothAxesHaveOneScale) {
  // One metre is as long upwards as sideways, whatever the extent.
  AbsoluteTrajectoryError corner;
  for (const Eigen::Vector3d& place :
       {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(8, 0, 0), Eigen::Vector3d(8, 1, 0)}) {
    corner.pairs.push_back({0, place, place});
  }
  const std::string svg = plot_trajectory(corner).element();
  const std::size_t begin = svg.find("points=\"") + 8;
  double x[3];
  double y[3];
  ASSERT_EQ(std::sscanf(svg.c_str() + begin, "%lf,%lf %lf,%lf %lf,%lf", &x[0], &y[0], &x[1], &y[1],
                        &x[2], &y[2]),
            6);
  EXPECT_NEAR((x[1] - x[0]) / 8, y[1] - y[2], 0.02);
  EXPECT_GT(x[1] - x[0], 400);
}

TEST(TrajectoryPlot, ACameraThatStoodStillIsDrawnToo) {
  AbsoluteTrajectoryError still;
  for (int i = 0; i < 3; ++i) still.pairs.emplace_back();
  EXPECT_THAT(plot_trajectory(still).element(), Not(HasSubstr("nan")));
}

TEST(TrajectoryPlot, KnowsUpByHowTheCameraIsHeld) {
  // A camera that looks along x of a frame with z up, a little downwards, to all sides.
  recording::Trajectory upright;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Quaterniond world_from_gravity(
        (Eigen::Matrix3d() << 0, 0, 1, -1, 0, 0, 0, -1, 0).finished());
    const Eigen::AngleAxisd turn(0.7 * i, Eigen::Vector3d::UnitZ());
    const Eigen::AngleAxisd pitch(-0.3, Eigen::Vector3d::UnitX());
    upright.push_back({i, {turn * world_from_gravity * pitch, Eigen::Vector3d::Zero()}});
  }
  EXPECT_EQ(axis_nearest_up(upright), Eigen::Vector3d(0, 0, 1));
  // Without any turn the camera's own frame has y down.
  EXPECT_EQ(axis_nearest_up(recording::Trajectory{{0, {}}}), Eigen::Vector3d(0, -1, 0));
  // A camera that rolls over has no up.
  recording::Trajectory rolling;
  for (int i = 0; i < 4; ++i) {
    rolling.push_back(
        {i,
         {Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi / 2 * i, Eigen::Vector3d::UnitZ())),
          Eigen::Vector3d::Zero()}});
  }
  EXPECT_EQ(axis_nearest_up(rolling), std::nullopt);
}

}  // namespace
}  // namespace roomwise::evaluation
