#include "roomwise/evaluation/report/recognition_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "roomwise/evaluation/drawing/plot_axes.h"
#include "roomwise/evaluation/report/report_page.h"

namespace roomwise::evaluation {
namespace {

using Eigen::Vector2d;
using Content = RecognitionReportContent;

constexpr std::size_t kMaxCurves = 6;

std::string with_interval(const Proportion& proportion, const Interval& interval) {
  if (proportion.n == 0) return "–";
  return fmt::format("{} ({} to {})", percent(proportion.value()), percent(interval.low),
                     percent(interval.high));
}

std::string rules_table(const Content& content) {
  std::vector<std::vector<std::string>> rows;
  for (const Content::DecisionRule& rule : content.rules) {
    rows.push_back({rule.name, std::to_string(rule.decisions),
                    percent_of({rule.named_correct.n, rule.decisions}),
                    with_interval(rule.named_correct, rule.precision_interval),
                    with_interval(rule.top1_correct, rule.top1_interval),
                    fmt::format("{:.1f} ms", rule.median_ms)});
  }
  return report_table(
      "How often each way was right, with 95 % intervals",
      {"Way", "Decisions", "A room was named", "Of these right", "Best room right", "Time"}, rows);
}

std::string mistakes_list(const std::vector<Content::Mistake>& mistakes) {
  if (mistakes.empty()) return "<p>No room was named wrongly.</p>\n";
  std::vector<PictureNote> notes;
  for (const Content::Mistake& mistake : mistakes) {
    notes.push_back(
        {mistake.picture,
         fmt::format("A picture of {} that was taken for {}", mistake.room, mistake.answer),
         mistake.name,
         fmt::format("It is {}; {} said {}: {}", mistake.room, mistake.rule, mistake.answer,
                     mistake.why)});
  }
  return picture_list(notes);
}

// Lines that are told apart without colours, too.
constexpr std::string_view kDashes[kMaxCurves] = {"none", "8 4", "2 3", "12 4 2 4", "5 5", "1 5"};

}  // namespace

SvgDrawing plot_precision_against_coverage(const Content& content) {
  const std::size_t curves = std::min(content.rules.size(), kMaxCurves);
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
  SvgDrawing drawing = axes.paper(700, "Precision against coverage");
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
  std::string body = "<h2>Right and wrong</h2>\n" + rules_table(content);
  if (!content.figures.empty()) {
    body += "<h2>Places that were never learned</h2>\n" +
            figure_table("What was said of them", content.figures);
  }
  body +=
      "<h2>Precision against coverage</h2>\n" +
      scrolling("Precision against coverage", plot_precision_against_coverage(content).element()) +
      "<h2>Which rooms were taken for which</h2>\n";
  for (const Content::DecisionRule& rule : content.rules)
    body += confusion_table(rule.name, rule.confusion);
  body += "<h2>Rooms that were named wrongly</h2>\n" + mistakes_list(content.mistakes);
  return report_page("Rooms of " + content.title, content.notes, body);
}

}  // namespace roomwise::evaluation
