#include "roomwise/evaluation/recognition_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "roomwise/evaluation/data_address.h"
#include "roomwise/evaluation/plot_axes.h"
#include "roomwise/image/resample.h"

namespace roomwise::evaluation {
namespace {

using Eigen::Vector2d;
using Content = RecognitionReportContent;

constexpr std::size_t kMostCurves = 6;

constexpr std::string_view kRecognitionStyle = R"(
:root { color-scheme: light dark; --ground: #ffffff; --text: #1a1a1a; --quiet: #555555;
  --line: #8a8a8a; --panel: #f4f4f1; --accent: #0b57d0; }
@media (prefers-color-scheme: dark) {
  :root { --ground: #1c1c1e; --text: #eeeeee; --quiet: #b8b8b8; --line: #7c7c80; --panel: #2a2a2c;
    --accent: #7aa9ff; } }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 1.5rem 1rem 3rem; max-width: 80rem; background: var(--ground);
  color: var(--text); font: 1rem/1.5 system-ui, "DejaVu Sans", sans-serif; }
h1 { font-size: 2rem; line-height: 1.2; margin: 0; overflow-wrap: anywhere; }
h2 { font-size: 1.375rem; margin: 2.5rem 0 0.75rem; }
h3 { font-size: 1.0625rem; margin: 0; overflow-wrap: anywhere; }
.scroll { overflow-x: auto; margin-bottom: 1rem; }
.scroll:focus-visible { outline: 3px solid var(--accent); outline-offset: 2px; }
.drawing { display: block; width: 100%; height: auto; min-width: 34rem; max-width: 50rem; }
table { border-collapse: collapse; min-width: 60%; font-variant-numeric: tabular-nums; }
caption { text-align: left; color: var(--quiet); padding-bottom: 0.375rem; }
th, td { text-align: left; vertical-align: top; padding: 0.375rem 1rem 0.375rem 0;
  border-bottom: 1px solid var(--line); }
th.number, td.number { text-align: right; white-space: nowrap; }
tbody th { min-width: 11rem; }
.mistakes { list-style: none; margin: 0; padding: 0; display: grid; gap: 1rem;
  grid-template-columns: repeat(auto-fill, minmax(min(100%, 17rem), 1fr)); }
.mistakes li { background: var(--panel); border-radius: 0.5rem; overflow: hidden; }
.mistakes img { display: block; width: 100%; height: auto; }
.mistakes .about { padding: 0.75rem 0.875rem; }
.mistakes p { margin: 0.25rem 0 0; overflow-wrap: anywhere; }
)";

std::string table_head(const std::string& caption, const std::vector<std::string>& columns) {
  std::string html = fmt::format(
      "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"{0}\">\n<table>\n"
      "<caption>{0}</caption>\n<thead>\n<tr>",
      escape_markup(caption));
  for (std::size_t i = 0; i < columns.size(); ++i) {
    html += fmt::format("<th scope=\"col\"{}>{}</th>", i == 0 ? "" : " class=\"number\"",
                        escape_markup(columns[i]));
  }
  return html + "</tr>\n</thead>\n<tbody>\n";
}

std::string table_row(const std::vector<std::string>& cells) {
  std::string html = fmt::format("<tr><th scope=\"row\">{}</th>", escape_markup(cells.front()));
  for (std::size_t i = 1; i < cells.size(); ++i) {
    html += fmt::format("<td class=\"number\">{}</td>", escape_markup(cells[i]));
  }
  return html + "</tr>\n";
}

constexpr std::string_view kTableEnd = "</tbody>\n</table>\n</div>\n";

std::string with_interval(const Proportion& proportion, const Interval& interval) {
  if (proportion.n == 0) return "–";
  return fmt::format("{} ({} to {})", percent(proportion.value()), percent(interval.low),
                     percent(interval.high));
}

std::string rules_table(const Content& content) {
  std::string html = table_head(
      "How often each way was right, with 95 % intervals",
      {"Way", "Decisions", "A room was named", "Of these right", "Best room right", "Time"});
  for (const Content::Rule& rule : content.rules) {
    html += table_row({rule.name, std::to_string(rule.decisions),
                       percent_of({rule.named_rightly.n, rule.decisions}),
                       with_interval(rule.named_rightly, rule.precision_interval),
                       with_interval(rule.best_right, rule.best_interval),
                       fmt::format("{:.1f} ms", rule.ms)});
  }
  return html + std::string(kTableEnd);
}

std::string confusion_table(const Content::Rule& rule) {
  const std::vector<std::string> rooms = rule.confusion.rooms();
  std::vector<std::string> columns{"Truth"};
  for (const std::string& room : rooms) columns.push_back("said " + room);
  std::string html = table_head(rule.name + ": a row for each true room", columns);
  for (const std::string& truth : rooms) {
    if (rule.confusion.recall(truth).n == 0) continue;
    std::vector<std::string> cells{truth};
    for (const std::string& answer : rooms) {
      cells.push_back(std::to_string(rule.confusion.count(truth, answer)));
    }
    html += table_row(cells);
  }
  return html + std::string(kTableEnd);
}

std::string mistakes_list(const std::vector<Content::Mistake>& mistakes) {
  if (mistakes.empty()) return "<p>No room was named wrongly.</p>\n";
  constexpr int kWidth = 320;
  constexpr int kJpegQuality = 75;
  std::string html = "<ul class=\"mistakes\">\n";
  for (const Content::Mistake& mistake : mistakes) {
    const int width = std::min(kWidth, mistake.picture.width());
    const int height = std::max(1, static_cast<int>(std::lround(double(mistake.picture.height()) *
                                                                width / mistake.picture.width())));
    html += fmt::format(
        "<li>\n<img src=\"{}\" width=\"{}\" height=\"{}\" loading=\"lazy\" alt=\"A picture of {} "
        "that was taken for {}\"/>\n<div class=\"about\">\n<h3>{}</h3>\n<p>It is {}; {} said {}: "
        "{}</p>\n</div>\n</li>\n",
        jpeg_address(image::resize(mistake.picture, width, height), kJpegQuality), width, height,
        escape_markup(mistake.room), escape_markup(mistake.answer), escape_markup(mistake.name),
        escape_markup(mistake.room), escape_markup(mistake.rule), escape_markup(mistake.answer),
        escape_markup(mistake.why));
  }
  return html + "</ul>\n";
}

// Lines that are told apart without colours, too.
constexpr std::string_view kDashes[kMostCurves] = {"none", "8 4", "2 3", "12 4 2 4", "5 5", "1 5"};

}  // namespace

SvgDrawing plot_precision_against_coverage(const Content& content) {
  const std::size_t curves = std::min(content.rules.size(), kMostCurves);
  PlotAxes axes;
  axes.corner = {88, 60 + 22 * static_cast<double>(curves)};
  axes.size = {588, 300};
  double lowest = 1;
  for (std::size_t i = 0; i < curves; ++i) {
    for (const CoveragePoint& point : content.rules[i].curve) {
      if (point.coverage >= 0.1) lowest = std::min(lowest, point.precision);
    }
  }
  axes.low = {0, std::max(0.0, std::floor(10 * lowest) / 10 - 0.1)};
  axes.high = {1, 1};
  SvgDrawing drawing(700, axes.corner.y() + axes.size.y() + 60, "Precision against coverage");
  drawing.rectangle({0, 0}, drawing.size(), "class=\"paper\"");
  drawing.text({axes.corner.x(), 36}, "Precision against coverage", "class=\"heading\"");
  axes.draw(drawing, "share of decisions, the most probable first", "share of these that is right");
  for (std::size_t i = 0; i < curves; ++i) {
    const std::string style = fmt::format("class=\"{}\" stroke-dasharray=\"{}\"",
                                          i % 2 == 0 ? "estimate" : "truth", kDashes[i]);
    const double y = 56 + 22 * static_cast<double>(i);
    drawing.line({axes.corner.x(), y - 5}, {axes.corner.x() + 48, y - 5}, style);
    drawing.text({axes.corner.x() + 56, y}, content.rules[i].name, "");
    std::vector<Vector2d> line;
    for (const CoveragePoint& point : content.rules[i].curve) {
      line.push_back(axes.to_px({point.coverage, std::max(point.precision, axes.low.y())}));
    }
    drawing.polyline(line, style);
  }
  return drawing;
}

std::string render_recognition_report(const Content& content) {
  const std::string title = escape_markup(content.title);
  std::string html = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n"
      "<title>Rooms of {0}</title>\n<style>{1}{2}</style>\n</head>\n<body>\n<main>\n"
      "<h1>Rooms of {0}</h1>\n",
      title, kRecognitionStyle, svg_style());
  for (const std::string& note : content.notes) {
    html += fmt::format("<p>{}</p>\n", escape_markup(note));
  }
  html += "<h2>Right and wrong</h2>\n" + rules_table(content);
  if (!content.figures.empty()) {
    html += "<h2>Places that were never learned</h2>\n" +
            table_head("What was said of them", {"Figure", "Value"});
    for (const auto& [name, value] : content.figures) html += table_row({name, value});
    html += kTableEnd;
  }
  html +=
      "<h2>Precision against coverage</h2>\n<div class=\"scroll\" tabindex=\"0\" role=\"region\" "
      "aria-label=\"Precision against coverage\">\n" +
      plot_precision_against_coverage(content).element() +
      "</div>\n<h2>Which rooms were taken for which</h2>\n";
  for (const Content::Rule& rule : content.rules) html += confusion_table(rule);
  html += "<h2>Rooms that were named wrongly</h2>\n" + mistakes_list(content.mistakes);
  return html + "</main>\n</body>\n</html>\n";
}

}  // namespace roomwise::evaluation
