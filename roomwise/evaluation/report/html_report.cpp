#include "roomwise/evaluation/report/html_report.h"

#include <fmt/format.h>

#include "roomwise/evaluation/drawing/trajectory_plot.h"
#include "roomwise/evaluation/report/report_page.h"

namespace roomwise::evaluation {
namespace {

using Rows = std::vector<std::vector<std::string>>;

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

std::string summary_section(const std::vector<NamedFigure>& summary) {
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
         "<p class=\"quiet\">Each line is a walk, a dot a key-frame. The numbers are those of the "
         "objects below.</p>\n" +
         scrolling("Map from above", draw_map(*content.map, content.key_frames, objects).element(),
                   "map");
}

std::string rooms_section(const std::vector<ReportContent::Room>& rooms) {
  std::string html = "<h2>Rooms</h2>\n";
  if (rooms.empty()) return html + "<p>No rooms were named.</p>\n";
  Rows rows;
  for (const ReportContent::Room& room : rooms) {
    rows.push_back({room.name, room.type.empty() ? "–" : room.type,
                    room.recognition.empty() ? "not learned" : room.recognition,
                    std::to_string(room.key_frames)});
  }
  constexpr std::size_t kTextColumns = 3;
  return html + report_table("Rooms of this home", {"Room", "Type", "Recognised by", "Key-frames"},
                             rows, kTextColumns);
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
      "class=\"pictures\">\n";
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const ReportContent::Object& entry = objects[i];
    const Eigen::Vector3d& place = entry.object.place_world;
    const std::string& room = entry.room.empty() ? entry.seen_from : entry.room;
    html += fmt::format(
        "<li>\n{}<div class=\"about\">\n<h3>{}. {}</h3>\n<dl>\n"
        "<dt>{}</dt><dd>{}</dd>\n<dt>Score</dt><dd>{:.2f}</dd>\n<dt>Seen in</dt><dd>{} "
        "key-frame{}</dd>\n<dt>Place</dt><dd>{:.2f}, {:.2f}, {:.2f}</dd>\n</dl>\n</div>\n</li>\n",
        object_picture(entry, i + 1), i + 1, escape_markup(entry.object.name),
        entry.room.empty() ? "Seen from" : "Room", room.empty() ? "not known" : escape_markup(room),
        entry.score, entry.observations, entry.observations == 1 ? "" : "s", place.x(), place.y(),
        place.z());
  }
  return html + "</ol>\n";
}

std::string recognition_section(const std::vector<ReportContent::Recognition>& recognition) {
  if (recognition.empty()) return "";
  Rows rows;
  std::string confusions;
  const auto in_words = [](const Interval& interval) {
    return fmt::format("{} to {}", percent(interval.low), percent(interval.high));
  };
  for (const ReportContent::Recognition& entry : recognition) {
    rows.push_back({entry.rule, std::to_string(entry.top1_correct.n),
                    percent_of({entry.named_correct.n, entry.top1_correct.n}),
                    percent_of(entry.named_correct), in_words(entry.named_interval),
                    percent_of(entry.top1_correct), in_words(entry.top1_interval),
                    fmt::format("{:.1f} ms", entry.ms)});
    confusions += confusion_table(entry.rule, entry.confusion);
  }
  return "<h2>Recognition</h2>\n" +
         report_table("How often the room was right, with 95 % intervals",
                      {"Rule", "Answers", "A room was named", "Of these right", "Interval",
                       "Best room right", "Interval", "Time"},
                      rows) +
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
  Rows rows;
  const ErrorStatistics& statistics = error.error_m;
  for (const auto& [name, value] :
       {std::pair("RMSE (ATE)", statistics.rmse), std::pair("Mean", statistics.mean),
        std::pair("Median", statistics.median), std::pair("Standard deviation", statistics.std),
        std::pair("Smallest", statistics.min), std::pair("Largest", statistics.max)}) {
    rows.push_back({name, fmt::format("{:.4f}", value)});
  }
  const SvgDrawing plot = plot_trajectory(error, {.title = content.home, .up = content.truth_up});
  return "<h2>Trajectory against the truth</h2>\n" + scrolling("Trajectory plot", plot.element()) +
         fmt::format(
             "<p class=\"quiet\">The best scale is {:.3f}; with it the RMSE would be {:.4f} "
             "m.</p>\n",
             error.best_scale, error.scaled_rmse_m) +
         report_table(fmt::format("Distance to the true place, over {} poses", error.pairs.size()),
                      {"Figure", "Metres"}, rows);
}

std::string stages_section(const std::vector<ReportContent::Stage>& stages) {
  if (stages.empty()) return "";
  Rows rows;
  for (const ReportContent::Stage& stage : stages) {
    const double per_call_ms =
        stage.calls == 0 ? 0 : 1000 * stage.cpu_s / static_cast<double>(stage.calls);
    rows.push_back({stage.name, std::to_string(stage.calls), fmt::format("{:.2f} s", stage.wall_s),
                    fmt::format("{:.2f} s", stage.cpu_s), fmt::format("{:.2f} ms", per_call_ms)});
  }
  return "<h2>Time</h2>\n" +
         report_table("Time by stage, summed over all threads",
                      {"Stage", "Calls", "Time", "Processor time", "Of it per call"}, rows);
}

}  // namespace

std::string render_report(const ReportContent& content) {
  return report_page(
      content.home, {"The semantic map of a home, as Roomwise learned it from a recording."},
      warnings_section(content.warnings) + summary_section(content.summary) + map_section(content) +
          rooms_section(content.rooms) + objects_section(content.objects) +
          recognition_section(content.recognition) + trajectory_section(content) +
          stages_section(content.stages));
}

}  // namespace roomwise::evaluation
