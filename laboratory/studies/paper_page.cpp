#include "laboratory/studies/paper_page.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "laboratory/studies/paper_published.h"
#include "laboratory/studies/paper_recordings.h"
#include "roomwise/evaluation/drawing/svg.h"
#include "roomwise/evaluation/report/report_page.h"
#include "roomwise/evaluation/statistics/quantile.h"

namespace roomwise::studies {
namespace {

using evaluation::middle_and_range;
using evaluation::report_table;
using Rows = std::vector<std::vector<std::string>>;

constexpr const char* kNone = "–";

std::string or_none(std::string_view text) {
  return std::string(text.empty() ? kNone : text);
}

std::string measured(const MeasuredData& data) {
  return data.is_simulated ? "measured here, simulated" : "measured here, real";
}
std::string by_others(std::size_t source) {
  const Source& of = published_sources()[source];
  return fmt::format("{}: {} [{}]", of.is_published ? "published" : "run elsewhere", of.name,
                     source + 1);
}

std::string method_words(const std::string& method) {
  return method == "paper" ? "the paper's" : "Roomwise's default";
}
std::string feature_words(const std::string& features) {
  std::string words = features;
  std::ranges::transform(words, words.begin(), [](unsigned char letter) {
    return static_cast<char>(std::toupper(letter));
  });
  return words;
}

std::string over_seeds(const MappingRow& row, double MappingTrial::*field, int decimals) {
  std::vector<double> values;
  for (const MappingTrial& trial : row.trials) values.push_back(trial.*field);
  return middle_and_range(std::move(values), decimals);
}

std::string rpe_over_seeds(const MappingRow& row) {
  std::vector<double> values;
  for (const MappingTrial& trial : row.trials) {
    if (trial.rpe_m) values.push_back(*trial.rpe_m);
  }
  return values.empty() ? kNone : middle_and_range(std::move(values), 4);
}

std::vector<std::string> error_row(const MappingRow& row) {
  return {row.data.name,
          measured(row.data),
          method_words(row.method),
          feature_words(row.features),
          fmt::format("{} of {:.0f}", over_seeds(row, &MappingTrial::placed, 0),
                      row.trials.front().frames),
          over_seeds(row, &MappingTrial::ate_m, 4),
          rpe_over_seeds(row)};
}

std::vector<std::string> time_row(const MappingRow& row) {
  return {row.data.name,
          measured(row.data),
          method_words(row.method),
          feature_words(row.features),
          over_seeds(row, &MappingTrial::reading_ms, 1),
          over_seeds(row, &MappingTrial::features_ms, 1),
          over_seeds(row, &MappingTrial::views_ms, 1),
          over_seeds(row, &MappingTrial::tracking_ms, 1),
          over_seeds(row, &MappingTrial::solving_ms, 1),
          over_seeds(row, &MappingTrial::floor_ms, 1),
          over_seeds(row, &MappingTrial::all_ms, 1)};
}

void add_published_errors(const std::string& recording, Rows& rows) {
  for (const PublishedTrajectory& one : published_trajectories()) {
    if (one.recording != recording) continue;
    rows.push_back({recording, by_others(one.source), kNone, kNone, or_none(one.frames),
                    std::string(one.ate_m), kNone});
  }
}
void add_published_times(const std::string& recording, Rows& rows) {
  for (const PublishedTrajectory& one : published_trajectories()) {
    if (one.recording != recording || one.cpu_ms.empty()) continue;
    rows.push_back({recording, by_others(one.source), kNone, kNone, kNone, kNone, kNone, kNone,
                    kNone, kNone, std::string(one.cpu_ms)});
  }
}

// Of real recordings in the order of the paper's, each with what others published; then of
// simulated ones.
template <typename Row>
Rows rows_of_recordings(const PaperResults& results, Row (*row)(const MappingRow&),
                        void (*add_published)(const std::string&, Rows&),
                        std::size_t columns_if_missing) {
  Rows rows;
  for (const PaperRecording& recording : paper_recordings()) {
    const std::size_t before = rows.size();
    for (const MappingRow& one : results.mapping) {
      if (!one.data.is_simulated && one.data.name == recording.title) rows.push_back(row(one));
    }
    if (rows.size() == before && columns_if_missing > 0) {
      rows.push_back({recording.title, "not measured here"});
      rows.back().resize(columns_if_missing, kNone);
    }
    add_published(recording.title, rows);
  }
  for (const MappingRow& one : results.mapping) {
    if (one.data.is_simulated) rows.push_back(row(one));
  }
  return rows;
}

std::string mapping_tables(const PaperResults& results) {
  const std::vector<std::string> errors{
      "Recording",          "From",        "Method",         "Features",
      "Frames with a pose", "ATE RMSE, m", "RPE over 1 s, m"};
  const std::vector<std::string> times{
      "Recording", "From",     "Method", "Features", "Reading", "Finding features",
      "Views",     "Tracking", "Graph",  "Floor",    "All"};
  constexpr std::size_t kTextColumns = 4;
  return "<h2>Where the camera was</h2>\n" +
         report_table(
             "Error of the camera's path, after it was laid on the truth (ATE), and of its motion "
             "over a second (RPE)",
             errors, rows_of_recordings(results, error_row, add_published_errors, errors.size()),
             kTextColumns) +
         "<h2>Time of each stage</h2>\n" +
         report_table("Processor time, ms a frame, all threads together, of the computer at hand",
                      times, rows_of_recordings(results, time_row, add_published_times, 0),
                      kTextColumns) +
         "<p>Views: frames made ready to be aligned whole. Tracking: with loop closures; "
         "Roomwise's default finds features on the way, only where a frame needs them, so their "
         "time is part of its tracking, too. Graph: the pose graph, and the default's bundle "
         "adjustment. Floor: the surface of the finished map, and the floor on it. All: of the "
         "whole program.</p>\n";
}

std::string objects_tables(const PaperResults& results) {
  Rows found;
  for (const ObjectsRow& row : results.objects) {
    found.push_back({row.data.name, measured(row.data), row.way,
                     fmt::format("{} of {}", row.found, row.found + row.missed),
                     std::to_string(row.beyond), std::to_string(row.twice),
                     std::to_string(row.wrong),
                     row.from_middle_m ? fmt::format("{:.2f}", *row.from_middle_m) : kNone});
  }
  Rows ruled;
  for (const RuledObject& object : results.ruled_objects) {
    ruled.push_back({object.data.name, measured(object.data), object.name,
                     fmt::format("{:.2f}", object.score), std::to_string(object.keyframes),
                     object.has_place ? "yes" : "no"});
  }
  std::string html = "<h2>Objects</h2>\n";
  if (!found.empty()) {
    html += report_table("Objects beside what is there; what need not be found counts as beyond",
                         {"Recording", "From", "Way", "Found of expected", "Beyond", "Found twice",
                          "Not there", "From the middle, median, m"},
                         found, 3);
  }
  if (!ruled.empty()) {
    html += report_table("What the paper's three rules find, right or not",
                         {"Recording", "From", "Object", "Best score", "Key-frames", "Has a place"},
                         ruled, 3);
  }
  return html +
         "<p>All ways look at the same key-frames, at their poses by Roomwise's default. What "
         "that "
         "default believes was fitted on homes of which fr1/rpy and office_walk are two; left out "
         "of the fit it finds less (docs/experiments/objects-kinds-as-data.md). The paper's rules "
         "and naive clustering were fitted on nothing. No count of the paper's own is at hand to "
         "stand beside these.</p>\n";
}

std::string rooms_table(const PaperResults& results) {
  Rows rows;
  for (const RoomsRow& row : results.rooms) {
    rows.push_back({row.changed, row.data.name, measured(row.data), row.way,
                    std::to_string(row.decisions), std::to_string(row.right_of_named.n),
                    row.right_of_named.n == 0
                        ? kNone
                        : fmt::format("{:.4f} ({:.3f} to {:.3f})", row.right_of_named.value(),
                                      row.interval.low, row.interval.high),
                    fmt::format("{:.1f}", row.ms)});
  }
  for (const PublishedRooms& row : published_rooms()) {
    rows.push_back({std::string(row.changed), "the paper's own", by_others(row.source),
                    "the paper's way, " + std::string(row.way), kNone, kNone,
                    std::string(row.precision), std::string(row.ms)});
  }
  return "<h2>Rooms</h2>\n" +
         report_table(
             "Rooms told after something changed; \"no objects\" is without representative objects",
             {"What changed", "Data", "From", "Way", "Decisions", "Named", "Of these right (95 %)",
              "ms a decision"},
             rows, 4) +
         "<p>The paper's way always names a room; Roomwise's own says where it is not sure. "
         "Intervals resample stays in rooms; of one walk they do not tell how walks differ, and "
         "where nothing "
         "was wrong they have no width. "
         "What Roomwise's own decides by was fitted on pictures of which office_walk and "
         "room_photos are two (docs/experiments/rooms-fitted.md).</p>\n";
}

std::string training_section(const PaperResults& results) {
  std::string html =
      "<h2>Training</h2>\n<p>The paper fine-tunes Inception-v3 for 22,000 steps [1]; no figure of "
      "its curve is at hand to stand beside this one.</p>\n";
  if (!results.training || results.training->points.empty()) return html;
  return html + evaluation::figure_table("What was trained", results.training->figures, 2) +
         evaluation::training_plots(*results.training) +
         evaluation::training_table(*results.training);
}

// Addresses become links: nothing is asked of the network until somebody follows one.
std::string with_links(std::string_view sentence) {
  std::string html;
  for (;;) {
    const std::size_t begin = std::min(sentence.find("http://"), sentence.find("https://"));
    html += evaluation::escape_markup(sentence.substr(0, begin));
    if (begin == std::string_view::npos) return html;
    sentence.remove_prefix(begin);
    std::size_t length = std::min(sentence.find(' '), sentence.size());
    while (length > 0 && (sentence[length - 1] == '.' || sentence[length - 1] == ';')) --length;
    const std::string address = evaluation::escape_markup(sentence.substr(0, length));
    html += fmt::format("<a href=\"{0}\">{0}</a>", address);
    sentence.remove_prefix(length);
  }
}

std::string missing_list(const PaperResults& results, PaperPart part) {
  const auto missing = results.missing.find(part);
  if (missing == results.missing.end() || missing->second.empty()) return "";
  std::string html = "<h3>Missing here</h3>\n<ul>\n";
  for (const std::string& sentence : missing->second) {
    html += fmt::format("<li>{}</li>\n", with_links(sentence));
  }
  return html + "</ul>\n";
}

std::string section(const PaperResults& results, PaperPart part) {
  switch (part) {
    case PaperPart::kMapping:
      return mapping_tables(results);
    case PaperPart::kObjects:
      return objects_tables(results);
    case PaperPart::kRooms:
      return rooms_table(results);
    case PaperPart::kTraining:
      return training_section(results);
  }
  return "";
}

// Of figures that stand in parts that were asked for; of objects there are none.
std::string sources_list(const std::vector<PaperPart>& parts) {
  const bool are_cited =
      std::ranges::any_of(parts, [](PaperPart part) { return part != PaperPart::kObjects; });
  if (!are_cited) return "";
  std::string html = "<h2>Sources</h2>\n<ol>\n";
  for (const Source& source : published_sources()) {
    html += fmt::format("<li>{}: {}</li>\n", evaluation::escape_markup(source.name),
                        evaluation::escape_markup(source.about));
  }
  return html + "</ol>\n";
}

std::vector<std::string> notes_of(const PaperResults& results) {
  std::vector<std::string> notes{
      "The tables of the paper Using Semantic Maps for Room Recognition to Aid Visually Impaired "
      "People, made anew by Roomwise: by the paper's own methods and by today's default. Simulated "
      "rows are of a made-up flat and stand where no real recording is.",
      results.seeds == 1
          ? std::string("Figures of paths and times are of one seed.")
          : fmt::format("Figures of paths and times are of {} seeds: the middle one and the range.",
                        results.seeds)};
  if (!results.networks.empty()) {
    notes.push_back(
        fmt::format("Networks that looked at pictures: {}.", fmt::join(results.networks, ", ")));
  }
  return notes;
}

}  // namespace

std::string paper_page(const PaperResults& results) {
  std::string body;
  for (const PaperPart part : results.parts) {
    body += section(results, part) + missing_list(results, part);
  }
  return evaluation::report_page("The paper's tables", notes_of(results),
                                 body + sources_list(results.parts));
}

}  // namespace roomwise::studies
