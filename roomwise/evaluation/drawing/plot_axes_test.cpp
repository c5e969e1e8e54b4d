#include "roomwise/evaluation/drawing/plot_axes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace roomwise::evaluation {
namespace {

using ::testing::DoubleEq;
using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(RoundTicks, AreRoundAndInside) {
  EXPECT_THAT(round_ticks(0, 1, 5).values,
              ElementsAre(0, DoubleEq(0.2), DoubleEq(0.4), DoubleNear(0.6, 1e-12), DoubleEq(0.8),
                          DoubleEq(1)));
  EXPECT_THAT(round_ticks(-3, 7.5, 5).values, ElementsAre(0, 5));
  EXPECT_THAT(round_ticks(-30, 75, 6).values, ElementsAre(-20, 0, 20, 40, 60));
  EXPECT_EQ(round_ticks(0.001, 0.0043, 4).step, 0.001);
}

TEST(RoundTicks, AreNoMoreThanAskedForByMuch) {
  for (double extent = 0.01; extent < 1000; extent *= 1.37) {
    for (const int count : {2, 5, 9}) {
      const Ticks ticks = round_ticks(-extent / 3, 2 * extent / 3, count);
      EXPECT_LE(ticks.values.size(), static_cast<std::size_t>(count) + 1) << extent;
      EXPECT_GE(ticks.values.size(), 1) << extent;
      for (const double tick : ticks.values) {
        EXPECT_GE(tick, -extent / 3 - 1e-6 * extent);
        EXPECT_LE(tick, 2 * extent / 3 + 1e-6 * extent);
      }
    }
  }
}

TEST(PlotAxes, PutValuesOnThePaper) {
  PlotAxes axes;
  axes.corner = {100, 20};
  axes.size = {200, 50};
  axes.low = {-1, 0};
  axes.high = {1, 10};
  EXPECT_EQ(axes.to_px({-1, 0}), Eigen::Vector2d(100, 70));
  EXPECT_EQ(axes.to_px({1, 10}), Eigen::Vector2d(300, 20));
  EXPECT_EQ(axes.to_px({0, 5}), Eigen::Vector2d(200, 45));
}

TEST(PlotAxes, SayWhatTheyShow) {
  SvgDrawing drawing(400, 300, "plot");
  PlotAxes axes;
  axes.corner = {80, 20};
  axes.size = {300, 200};
  axes.high = {0.3, 0.2};
  axes.draw(drawing, "x [m]", "y [m]");
  const std::string svg = drawing.element();
  for (const char* text : {">x [m]<", ">y [m]<", ">0.0<", ">0.1<", ">0.2<", ">0.3<"}) {
    EXPECT_THAT(svg, HasSubstr(text));
  }
}

}  // namespace
}  // namespace roomwise::evaluation
