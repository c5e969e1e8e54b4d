#include "roomwise/evaluation/html_report.h"

#include <fmt/format.h>

#include "roomwise/evaluation/report_page.h"
#include "roomwise/evaluation/trajectory_plot.h"

namespace roomwise::evaluation {
namespace {

constexpr std::string_view kHomeReportStyle = R"(
:root { color-scheme: light dark; --ground: #ffffff; --text: #1a1a1a; --quiet: #555555;
  --line: #8a8a8a; --panel: #f4f4f1; --warn: #fff4d6; --warn-line: #8a5a00; --accent: #0b57d0; }
@media (prefers-color-scheme: dark) {
  :root { --ground: #1c1c1e; --text: #eeeeee; --quiet: #b8b8b8; --line: #7c7c80; --panel: #2a2a2c;
    --warn: #3d3215; --warn-line: #e3b341; --accent: #7aa9ff; } }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 1.5rem 1rem 3rem; max-width: 68rem; background: var(--ground);
  color: var(--text); font: 1rem/1.5 system-ui, "DejaVu Sans", sans-serif; }
h1 { font-size: 2rem; line-height: 1.2; margin: 0; overflow-wrap: anywhere; }
h2 { font-size: 1.375rem; margin: 2.5rem 0 0.75rem; }
h3 { font-size: 1.0625rem; margin: 0; overflow-wrap: anywhere; }
p { margin: 0.5rem 0; max-width: 45rem; }
.quiet { color: var(--quiet); }
.warnings { border: 2px solid var(--warn-line); border-radius: 0.5rem; background: var(--warn);
  padding: 0.75rem 1rem; margin-top: 1.5rem; }
.warnings h2 { margin: 0; }
.warnings ul { margin: 0.25rem 0 0; padding-left: 1.25rem; }
.figures { display: grid; grid-template-columns: repeat(auto-fill, minmax(9rem, 1fr)); gap: 0.75rem;
  margin: 0; }
.figures div { background: var(--panel); border-radius: 0.5rem; padding: 0.625rem 0.875rem; }
.figures dt { color: var(--quiet); font-size: 0.875rem; }
.figures dd { margin: 0; font-size: 1.375rem; font-weight: 600; overflow-wrap: anywhere; }
.scroll { overflow-x: auto; }
.scroll:focus-visible { outline: 3px solid var(--accent); outline-offset: 2px; }
.drawing { display: block; width: 100%; height: auto; border-radius: 0.5rem; }
.map .drawing { min-width: 44rem; }
.plot .drawing { min-width: 34rem; max-width: 50rem; }
table { border-collapse: collapse; min-width: 60%; margin-bottom: 1rem;
  font-variant-numeric: tabular-nums; }
caption { text-align: left; color: var(--quiet); padding-bottom: 0.375rem; }
th, td { text-align: left; vertical-align: top; padding: 0.375rem 1rem 0.375rem 0;
  border-bottom: 1px solid var(--line); }
th.number, td.number { text-align: right; white-space: nowrap; }
thead th { font-size: 0.875rem; }
td.right { font-weight: 700; background: var(--panel); }
.objects { list-style: none; margin: 0; padding: 0; display: grid; gap: 1rem;
  grid-template-columns: repeat(auto-fill, minmax(min(100%, 17rem), 1fr)); }
.objects li { background: var(--panel); border-radius: 0.5rem; overflow: hidden; }
.objects img { display: block; width: 100%; height: auto; }
.objects .about { padding: 0.75rem 0.875rem; }
.objects dl { display: grid; grid-template-columns: auto 1fr; gap: 0 0.75rem; margin: 0.25rem 0 0; }
.objects dt { color: var(--quiet); }
.objects dd { margin: 0; overflow-wrap: anywhere; }
footer { margin-top: 3rem; color: var(--quiet); font-size: 0.875rem; }
)";

// A table whose first column heads its rows.
class Table {
 public:
  Table(std::string_view caption, std::vector<std::string> columns, std::size_t text_columns)
      : text_columns_(text_columns) {
    html_ = fmt::format(
        "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"{0}\">\n<table>\n"
        "<caption>{0}</caption>\n<thead>\n<tr>",
        escape_markup(caption));
    for (std::size_t i = 0; i < columns.size(); ++i) {
      html_ +=
          fmt::format("<th scope=\"col\"{}>{}</th>", number_class(i), escape_markup(columns[i]));
    }
    html_ += "</tr>\n</thead>\n<tbody>\n";
  }

  // highlighted: the column of a cell that stands out.
  void row(const std::vector<std::string>& cells, std::size_t highlighted = 0) {
    html_ += fmt::format("<tr><th scope=\"row\">{}</th>", escape_markup(cells.front()));
    for (std::size_t i = 1; i < cells.size(); ++i) {
      html_ += i == highlighted ? std::string("<td class=\"number right\">")
                                : fmt::format("<td{}>", number_class(i));
      html_ += escape_markup(cells[i]) + "</td>";
    }
    html_ += "</tr>\n";
  }

  [[nodiscard]] std::string html() const { return html_ + "</tbody>\n</table>\n</div>\n"; }

 private:
  // The first columns hold text, the others numbers.
  [[nodiscard]] std::string_view number_class(std::size_t column) const {
    return column < text_columns_ ? "" : " class=\"number\"";
  }
  std::size_t text_columns_;
  std::string html_;
};

// The drawing in a frame that scrolls sideways on a narrow screen, reachable by keyboard.
std::string figure(const SvgDrawing& drawing, std::string_view kind, std::string_view name) {
  return fmt::format(
      "<div class=\"scroll {}\" tabindex=\"0\" role=\"region\" aria-label=\"{}\">\n{}</div>\n",
      kind, escape_markup(name), drawing.element());
}

std::string warnings_section(const std::vector<std::string>& warnings) {
  if (warnings.empty()) return "";
  std::string html =
      "<section class=\"warnings\" aria-labelledby=\"warnings\">\n<h2 id=\"warnings\">Please "
      "note</h2>"
      "\n<ul>\n";
  for (const std::string& warning : warnings) {
    html += fmt::format("<li>{}</li>\n", escape_markup(warning));
  }
  return html + "</ul>\n</section>\n";
}

std::string summary_section(const std::vector<ReportContent::Figure>& summary) {
  if (summary.empty()) return "";
  std::string html = "<h2>Summary</h2>\n<dl class=\"figures\">\n";
  for (const auto& [name, value] : summary) {
    html += fmt::format("<div><dt>{}</dt><dd>{}</dd></div>\n", escape_markup(name),
                        escape_markup(value));
  }
  return html + "</dl>\n";
}

std::string map_section(const ReportContent& content) {
  if (!content.map) return "";
  std::vector<MapObject> objects;
  for (const ReportContent::Object& entry : content.objects) objects.push_back(entry.object);
  return "<h2>Map from above</h2>\n"
         "<p class=\"quiet\">The line is the walk, a dot a key-frame. The numbers are those of the "
         "objects below.</p>\n" +
         figure(draw_map(*content.map, content.key_frames, objects), "map", "Map from above");
}

std::string rooms_section(const std::vector<ReportContent::Room>& rooms) {
  std::string html = "<h2>Rooms</h2>\n";
  if (rooms.empty()) return html + "<p>No rooms were named.</p>\n";
  constexpr std::size_t kTextColumns = 3;
  Table table("Rooms of this home", {"Room", "Type", "Recognised by", "Key-frames"}, kTextColumns);
  for (const ReportContent::Room& room : rooms) {
    table.row({room.name, room.type.empty() ? "–" : room.type,
               room.recognition.empty() ? "not learned" : room.recognition,
               std::to_string(room.key_frames)});
  }
  return html + table.html();
}

std::string object_picture(const ReportContent::Object& entry, std::size_t number) {
  if (entry.picture.empty()) return "";
  return picture_element(entry.picture, fmt::format("The key-frame that shows object {}, {}, best",
                                                    number, entry.object.name));
}

std::string objects_section(const std::vector<ReportContent::Object>& objects) {
  std::string html = "<h2>Objects</h2>\n";
  if (objects.empty()) return html + "<p>No objects were found.</p>\n";
  html +=
      "<p class=\"quiet\">Places are in the frame of the map, in metres. The score, from 0 to "
      "1, says how sure it is that the thing stands there and is called so.</p>\n<ol "
      "class=\"objects\">\n";
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const ReportContent::Object& entry = objects[i];
    const Eigen::Vector3d& place = entry.object.place_world;
    html += fmt::format(
        "<li>\n{}<div class=\"about\">\n<h3>{}. {}</h3>\n<dl>\n"
        "<dt>Room</dt><dd>{}</dd>\n<dt>Score</dt><dd>{:.2f}</dd>\n<dt>Seen in</dt><dd>{} "
        "key-frame{}</dd>\n<dt>Place</dt><dd>{:.2f}, {:.2f}, {:.2f}</dd>\n</dl>\n</div>\n</li>\n",
        object_picture(entry, i + 1), i + 1, escape_markup(entry.object.name),
        entry.room.empty() ? "not known" : escape_markup(entry.room), entry.score,
        entry.observations, entry.observations == 1 ? "" : "s", place.x(), place.y(), place.z());
  }
  return html + "</ol>\n";
}

std::string confusion_table(const ReportContent::Recognition& recognition) {
  const ConfusionMatrix& confusion = recognition.confusion;
  if (confusion.empty()) return "";
  const std::vector<std::string> rooms = confusion.rooms();
  std::vector<std::string> columns = {"Truth"};
  for (const std::string& room : rooms) columns.push_back("said " + room);
  columns.insert(columns.end(), {"Precision", "Recall"});
  Table table(
      fmt::format("{}: a row for each true room, a column for each answer", recognition.rule),
      std::move(columns), 1);
  for (std::size_t i = 0; i < rooms.size(); ++i) {
    if (confusion.recall(rooms[i]).n == 0) continue;  // an answer that is no room
    std::vector<std::string> cells = {rooms[i]};
    for (const std::string& answer : rooms) {
      cells.push_back(std::to_string(confusion.count(rooms[i], answer)));
    }
    cells.push_back(percent_of(confusion.precision(rooms[i])));
    cells.push_back(percent_of(confusion.recall(rooms[i])));
    table.row(cells, i + 1);
  }
  return table.html();
}

std::string recognition_section(const std::vector<ReportContent::Recognition>& recognition) {
  if (recognition.empty()) return "";
  Table table("How often the room was right, with 95 % intervals",
              {"Rule", "Answers", "A room was named", "Of these right", "Interval",
               "Best room right", "Interval", "Time"},
              1);
  std::string confusions;
  const auto in_words = [](const Interval& interval) {
    return fmt::format("{} to {}", percent(interval.low), percent(interval.high));
  };
  for (const ReportContent::Recognition& entry : recognition) {
    table.row({entry.rule, std::to_string(entry.top1_correct.n),
               percent_of({entry.named_correct.n, entry.top1_correct.n}),
               percent_of(entry.named_correct), in_words(entry.named_interval),
               percent_of(entry.top1_correct), in_words(entry.best_interval),
               fmt::format("{:.1f} ms", entry.ms)});
    confusions += confusion_table(entry);
  }
  return "<h2>Recognition</h2>\n" + table.html() +
         fmt::format(
             "<p class=\"quiet\">The best room is the most probable one, said or not: \"not sure\" "
             "and \"none of them\" are answers, too. Intervals resample {}, not single pictures."
             "</p>\n",
             escape_markup(recognition.front().resampled)) +
         confusions;
}

std::string trajectory_section(const ReportContent& content) {
  if (!content.trajectory_error) return "";
  const AbsoluteTrajectoryError& error = *content.trajectory_error;
  Table table(fmt::format("Distance to the true place, over {} poses", error.pairs.size()),
              {"Figure", "Metres"}, 1);
  const ErrorStatistics& statistics = error.error_m;
  for (const auto& [name, value] :
       {std::pair("RMSE (ATE)", statistics.rmse), std::pair("Mean", statistics.mean),
        std::pair("Median", statistics.median), std::pair("Standard deviation", statistics.std),
        std::pair("Smallest", statistics.min), std::pair("Largest", statistics.max)}) {
    table.row({name, fmt::format("{:.4f}", value)});
  }
  const SvgDrawing plot = plot_trajectory(error, {.title = content.home, .up = content.truth_up});
  return "<h2>Trajectory against the truth</h2>\n" + figure(plot, "plot", "Trajectory plot") +
         fmt::format(
             "<p class=\"quiet\">The best scale is {:.3f}; with it the RMSE would be {:.4f} "
             "m.</p>\n",
             error.best_scale, error.scaled_rmse_m) +
         table.html();
}

std::string stages_section(const std::vector<ReportContent::Stage>& stages) {
  if (stages.empty()) return "";
  Table table("Time by stage, summed over all threads",
              {"Stage", "Calls", "Time", "Processor time", "Of it per call"}, 1);
  for (const ReportContent::Stage& stage : stages) {
    const double per_call_ms =
        stage.calls == 0 ? 0 : 1000 * stage.cpu_s / static_cast<double>(stage.calls);
    table.row({stage.name, std::to_string(stage.calls), fmt::format("{:.2f} s", stage.wall_s),
               fmt::format("{:.2f} s", stage.cpu_s), fmt::format("{:.2f} ms", per_call_ms)});
  }
  return "<h2>Time</h2>\n" + table.html();
}

}  // namespace

std::string render_report(const ReportContent& content) {
  const std::string home = escape_markup(content.home);
  return fmt::format(
             "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n"
             "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n"
             "<title>{0} – Roomwise report</title>\n<style>{1}{2}</style>\n</head>\n<body>\n"
             "<header>\n<h1>{0}</h1>\n<p class=\"quiet\">The semantic map of a home, as Roomwise "
             "learned it from a recording.</p>\n</header>\n<main>\n",
             home, kHomeReportStyle, svg_style()) +
         warnings_section(content.warnings) + summary_section(content.summary) +
         map_section(content) + rooms_section(content.rooms) + objects_section(content.objects) +
         recognition_section(content.recognition) + trajectory_section(content) +
         stages_section(content.stages) +
         "</main>\n<footer><p>Everything on this page is inside this file; opening it asks nothing "
         "of the network.</p></footer>\n</body>\n</html>\n";
}

}  // namespace roomwise::evaluation
