#include "roomwise/evaluation/training_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "roomwise/evaluation/plot_axes.h"

namespace roomwise::evaluation {
namespace {

using Eigen::Vector2d;
using Point = TrainingReportContent::Point;

constexpr std::string_view kTrainingStyle = R"(
:root { color-scheme: light dark; --ground: #ffffff; --text: #1a1a1a; --quiet: #555555;
  --line: #8a8a8a; --accent: #0b57d0; }
@media (prefers-color-scheme: dark) {
  :root { --ground: #1c1c1e; --text: #eeeeee; --quiet: #b8b8b8; --line: #7c7c80;
    --accent: #7aa9ff; } }
body { margin: 0 auto; padding: 1.5rem 1rem 3rem; max-width: 56rem; background: var(--ground);
  color: var(--text); font: 1rem/1.5 system-ui, "DejaVu Sans", sans-serif; }
h1 { font-size: 2rem; line-height: 1.2; margin: 0; overflow-wrap: anywhere; }
h2 { font-size: 1.375rem; margin: 2.5rem 0 0.75rem; }
.scroll { overflow-x: auto; }
.scroll:focus-visible { outline: 3px solid var(--accent); outline-offset: 2px; }
.drawing { display: block; width: 100%; height: auto; min-width: 34rem; }
table { border-collapse: collapse; min-width: 60%; font-variant-numeric: tabular-nums; }
caption { text-align: left; color: var(--quiet); padding-bottom: 0.375rem; }
th, td { text-align: left; padding: 0.375rem 1rem 0.375rem 0; border-bottom: 1px solid var(--line); }
th.number, td.number { text-align: right; white-space: nowrap; }
)";

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
  SvgDrawing drawing(700, axes.corner.y() + axes.size.y() + 60, title);
  drawing.rectangle({0, 0}, drawing.size(), "class=\"paper\"");
  drawing.text({axes.corner.x(), 36}, title, "class=\"heading\"");
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

std::string figure(const SvgDrawing& drawing, std::string_view name) {
  return fmt::format(
      "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"{}\">\n{}</div>\n", name,
      drawing.element());
}

std::string four_digits(double value) {
  return std::isfinite(value) ? fmt::format("{:.4f}", value) : "–";
}

std::string table_of(const TrainingReportContent& content) {
  std::string html =
      "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"The numbers\">\n<table>\n"
      "<caption>After so many steps; the best is marked with *</caption>\n<thead>\n<tr>"
      "<th scope=\"col\">steps</th><th scope=\"col\" class=\"number\">cross-entropy</th>"
      "<th scope=\"col\" class=\"number\">held out</th>"
      "<th scope=\"col\" class=\"number\">held-out precision</th></tr>\n</thead>\n<tbody>\n";
  for (const Point& point : content.points) {
    html += fmt::format("<tr><th scope=\"row\">{}{}</th>", point.step,
                        point.step == content.best_step ? " *" : "");
    for (const double value :
         {point.cross_entropy, point.held_out_cross_entropy, point.held_out_precision})
      html += fmt::format("<td class=\"number\">{}</td>", four_digits(value));
    html += "</tr>\n";
  }
  return html + "</tbody>\n</table>\n</div>\n";
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

std::string render_training_report(const TrainingReportContent& content) {
  const std::string title = escape_markup(content.network);
  std::string html = fmt::format(
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<title>Training of {0}</title>\n<style>{1}{2}</style>\n</head>\n<body>\n<main>\n"
      "<h1>Training of {0}</h1>\n<h2>Summary</h2>\n<table>\n<caption>What was trained</caption>\n",
      title, kTrainingStyle, svg_style());
  for (const auto& [name, value] : content.figures) {
    html += fmt::format("<tr><th scope=\"row\">{}</th><td>{}</td></tr>\n", escape_markup(name),
                        escape_markup(value));
  }
  html += "</table>\n<h2>Curves</h2>\n";
  if (content.points.empty()) {
    html += "<p>It ended before the network was looked at for the first time.</p>\n";
  } else {
    html += figure(plot_cross_entropy(content), "Cross-entropy against steps");
    if (has_held_out(content))
      html += figure(plot_precision(content), "Held-out precision against steps");
    html += "<h2>Numbers</h2>\n" + table_of(content);
  }
  return html + "</main>\n</body>\n</html>\n";
}

}  // namespace roomwise::evaluation
