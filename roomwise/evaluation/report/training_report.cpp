#include "roomwise/evaluation/report/training_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "roomwise/evaluation/drawing/plot_axes.h"
#include "roomwise/evaluation/report/report_page.h"

namespace roomwise::evaluation {
namespace {

using Eigen::Vector2d;
using Point = TrainingReportContent::Point;

struct Curve {
  std::string name;
  std::string style;  // a class of svg_style()
  std::function<double(const Point&)> value;
};

// The curves over steps, from 0 to `high` (or, without it, a little above the highest value).
SvgDrawing plot(const TrainingReportContent& content, const std::string& title,
                std::string_view label, const std::vector<Curve>& curves, double high) {
  double most = high;
  for (const Curve& curve : curves) {
    for (const Point& point : content.points) {
      const double value = curve.value(point);
      if (high == 0 && std::isfinite(value)) most = std::max(most, 1.05 * value);
    }
  }
  PlotAxes axes;
  axes.corner = {88, 92};
  axes.size = {588, 300};
  axes.low = {0, 0};
  axes.high = {std::max(1.0, content.points.back().step), most > 0 ? most : 1};
  SvgDrawing drawing = axes.paper(700, title);
  axes.draw(drawing, "steps", label);
  double legend = axes.corner.x();
  for (const Curve& curve : curves) {
    const std::string style = fmt::format("class=\"{}\" fill=\"none\"", curve.style);
    drawing.line({legend, 65}, {legend + 32, 65}, style);
    drawing.text({legend + 40, 70}, curve.name, "");
    legend += 200;
    std::vector<Vector2d> line;
    for (const Point& point : content.points) {
      const double value = curve.value(point);
      if (std::isfinite(value)) line.push_back(axes.to_px({point.step, value}));
    }
    drawing.polyline(line, style);
    for (const Vector2d& place : line) drawing.circle(place, 2, style);
  }
  return drawing;
}

bool has_held_out(const TrainingReportContent& content) {
  return std::ranges::any_of(
      content.points, [](const Point& point) { return std::isfinite(point.held_out_precision); });
}

std::string four_digits(double value) {
  return std::isfinite(value) ? fmt::format("{:.4f}", value) : "–";
}

}  // namespace

SvgDrawing plot_cross_entropy(const TrainingReportContent& content) {
  std::vector<Curve> curves{
      {"training", "estimate", [](const Point& point) { return point.cross_entropy; }}};
  if (has_held_out(content)) {
    curves.push_back(
        {"held out", "truth", [](const Point& point) { return point.held_out_cross_entropy; }});
  }
  return plot(content, "Cross-entropy against steps", "cross-entropy", curves, 0);
}

SvgDrawing plot_precision(const TrainingReportContent& content) {
  return plot(content, "Held-out precision against steps", "precision",
              {{"held out", "truth", [](const Point& point) { return point.held_out_precision; }}},
              1);
}

std::string training_plots(const TrainingReportContent& content) {
  std::string html =
      scrolling("Cross-entropy against steps", plot_cross_entropy(content).element());
  if (has_held_out(content)) {
    html += scrolling("Held-out precision against steps", plot_precision(content).element());
  }
  return html;
}

std::string training_table(const TrainingReportContent& content) {
  std::vector<std::vector<std::string>> rows;
  for (const Point& point : content.points) {
    rows.push_back({fmt::format("{}{}", point.step, point.step == content.best_step ? " *" : ""),
                    four_digits(point.cross_entropy), four_digits(point.held_out_cross_entropy),
                    four_digits(point.held_out_precision)});
  }
  return report_table("After so many steps; the best is marked with *",
                      {"steps", "cross-entropy", "held out", "held-out precision"}, rows);
}

std::string render_training_report(const TrainingReportContent& content) {
  std::string body = "<h2>Summary</h2>\n" + figure_table("What was trained", content.figures, 2) +
                     "<h2>Curves</h2>\n";
  if (content.points.empty()) {
    body += "<p>It ended before the network was looked at for the first time.</p>\n";
  } else {
    body += training_plots(content) + "<h2>Numbers</h2>\n" + training_table(content);
  }
  return report_page("Training of " + content.network, {}, body);
}

}  // namespace roomwise::evaluation
