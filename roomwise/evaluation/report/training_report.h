#pragma once

#include <string>
#include <vector>

#include "roomwise/evaluation/drawing/svg.h"
#include "roomwise/evaluation/report/report_page.h"

namespace roomwise::evaluation {

// What a page about the training of a network says.
struct TrainingReportContent {
  // After so many steps; NaN where nothing was held out.
  struct Point {
    double step = 0;
    double cross_entropy = 0;
    double held_out_cross_entropy = 0;
    double held_out_precision = 0;
  };
  std::string network;  // its name, the page's title
  std::vector<NamedFigure> figures;
  std::vector<Point> points;
  double best_step = 0;
};

// Cross-entropy against steps, of training and of what was held out. At least one point.
[[nodiscard]] SvgDrawing plot_cross_entropy(const TrainingReportContent& content);
// The share of held-out pictures that were named rightly, against steps.
[[nodiscard]] SvgDrawing plot_precision(const TrainingReportContent& content);

// Both plots, or one where nothing was held out, each in a frame that scrolls; and their numbers as
// a table. HTML of a page's body. At least one point.
[[nodiscard]] std::string training_plots(const TrainingReportContent& content);
[[nodiscard]] std::string training_table(const TrainingReportContent& content);

// One page of HTML that needs nothing else, with both plots and their numbers as a table.
[[nodiscard]] std::string render_training_report(const TrainingReportContent& content);

}  // namespace roomwise::evaluation
