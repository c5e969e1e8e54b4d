#include "roomwise/evaluation/report/object_report.h"

#include <fmt/format.h>

#include "roomwise/evaluation/drawing/svg.h"
#include "roomwise/evaluation/statistics/proportion.h"

namespace roomwise::evaluation {
namespace {

std::vector<std::string> counts_row(const std::string& name, const ObjectCounts& counts) {
  return {name,
          std::to_string(counts.matched),
          std::to_string(counts.missed),
          std::to_string(counts.beyond),
          std::to_string(counts.duplicates),
          std::to_string(counts.wrong)};
}

std::string kinds_table(const ObjectReportContent::Way& way) {
  std::vector<std::vector<std::string>> rows{counts_row("all", way.errors.all)};
  for (const auto& [kind, counts] : way.errors.by_kind) rows.push_back(counts_row(kind, counts));
  return report_table(fmt::format("Things, {}", way.name),
                      {"Thing", "Found", "Missed", "Found beyond", "Found once more", "Not there"},
                      rows);
}

std::string shares_table(const std::vector<ObjectReportContent::Way>& ways) {
  std::vector<std::vector<std::string>> rows;
  for (const ObjectReportContent::Way& way : ways) {
    const ObjectCounts& all = way.errors.all;
    const auto metres = [&](double value) {
      return way.errors.matches.empty() ? std::string("–") : fmt::format("{:.2f} m", value);
    };
    rows.push_back({way.name, percent_of({all.matched, all.matched + all.missed}),
                    percent_of({all.duplicates, all.found()}), percent_of({all.wrong, all.found()}),
                    metres(way.errors.from_center_quantile_m(0.5)),
                    metres(way.errors.from_center_quantile_m(0.9)),
                    std::to_string(way.without_place)});
  }
  return report_table("Both ways; shares are of what was to be found, and of all that was found",
                      {"Way", "Found", "Found once more", "Not there", "Off by, median",
                       "90 % within", "Without a place"},
                      rows);
}

std::string section(const std::string& heading, const std::vector<PictureNote>& notes) {
  return fmt::format("<h2>{}: {}</h2>\n", escape_markup(heading), notes.size()) +
         (notes.empty() ? std::string("<p>None.</p>\n") : picture_list(notes));
}

}  // namespace

std::string render_object_report(const ObjectReportContent& content) {
  std::string body = "<h2>Found and missed</h2>\n" + shares_table(content.ways);
  for (const ObjectReportContent::Way& way : content.ways) body += kinds_table(way);
  body += "<h2>How often it was so</h2>\n" +
          reliability_table(fmt::format("What was told, by its probability, {}", content.shown_way),
                            content.reliability);
  body += section(fmt::format("Not there, {}", content.shown_way), content.wrong) +
          section(fmt::format("Found once more, {}", content.shown_way), content.duplicates) +
          section(fmt::format("Missed, {}", content.shown_way), content.missed) +
          section(fmt::format("Found, {}", content.shown_way), content.found);
  return report_page("Things of " + content.title, content.notes, body);
}

}  // namespace roomwise::evaluation
