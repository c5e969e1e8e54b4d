#pragma once

#include <string_view>
#include <vector>

#include "roomwise/evaluation/drawing/svg.h"

namespace roomwise::evaluation {

struct Ticks {
  std::vector<double> values;
  double step = 0;
};

// Round numbers (1, 2 or 5 times a power of ten apart) from low to high, `count` of them or a few
// less. low < high.
[[nodiscard]] Ticks round_ticks(double low, double high, int count);

// The part of a drawing that a plot fills: where its axes lie and which values they span.
struct PlotAxes {
  Eigen::Vector2d corner = Eigen::Vector2d::Zero();  // top left, px
  Eigen::Vector2d size = Eigen::Vector2d::Zero();    // px
  Eigen::Vector2d low = Eigen::Vector2d::Zero();     // values at the left and at the bottom
  Eigen::Vector2d high = Eigen::Vector2d::Ones();    // values at the right and at the top

  // The drawing to plot in, which is as high as the axes ask for, with its title as a heading.
  // `kind` goes before the title for those who do not see the drawing.
  [[nodiscard]] SvgDrawing paper(double width, std::string_view title,
                                 std::string_view kind = "") const;
  [[nodiscard]] Eigen::Vector2d to_px(const Eigen::Vector2d& value) const;
  // Grid, frame, ticks with their numbers, and what the axes are ("x [m]").
  void draw(SvgDrawing& drawing, std::string_view x_label, std::string_view y_label) const;
};

}  // namespace roomwise::evaluation
