#include "roomwise/evaluation/report/report_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "roomwise/evaluation/drawing/data_address.h"
#include "roomwise/evaluation/drawing/svg.h"
#include "roomwise/evaluation/statistics/proportion.h"
#include "roomwise/image/resample.h"

namespace roomwise::evaluation {
namespace {

constexpr std::string_view kPageStyle = R"(
:root { color-scheme: light dark; --ground: #ffffff; --text: #1a1a1a; --quiet: #555555;
  --line: #8a8a8a; --panel: #f4f4f1; --warn: #fff4d6; --warn-line: #8a5a00; --accent: #0b57d0; }
@media (prefers-color-scheme: dark) {
  :root { --ground: #1c1c1e; --text: #eeeeee; --quiet: #b8b8b8; --line: #7c7c80; --panel: #2a2a2c;
    --warn: #3d3215; --warn-line: #e3b341; --accent: #7aa9ff; } }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 1.5rem 1rem 3rem; max-width: 80rem; background: var(--ground);
  color: var(--text); font: 1rem/1.5 system-ui, "DejaVu Sans", sans-serif; }
h1 { font-size: 2rem; line-height: 1.2; margin: 0; overflow-wrap: anywhere; }
h2 { font-size: 1.375rem; margin: 2.5rem 0 0.75rem; }
h3 { font-size: 1.0625rem; margin: 0; overflow-wrap: anywhere; }
p { margin: 0.5rem 0; max-width: 45rem; }
a { color: var(--accent); }
.quiet { color: var(--quiet); }
.warnings { border: 2px solid var(--warn-line); border-radius: 0.5rem; background: var(--warn);
  padding: 0.75rem 1rem; margin-top: 1.5rem; }
.warnings h2 { margin: 0; }
.warnings ul { margin: 0.25rem 0 0; padding-left: 1.25rem; }
.figures { display: grid; grid-template-columns: repeat(auto-fill, minmax(10.5rem, 1fr)); gap: 0.75rem;
  margin: 0; }
.figures div { background: var(--panel); border-radius: 0.5rem; padding: 0.625rem 0.875rem; }
.figures dt { color: var(--quiet); font-size: 0.875rem; }
.figures dd { margin: 0; font-size: 1.375rem; font-weight: 600; overflow-wrap: anywhere; }
.scroll { overflow-x: auto; margin-bottom: 1rem; }
.scroll:focus-visible { outline: 3px solid var(--accent); outline-offset: 2px; }
.drawing { display: block; width: 100%; height: auto; min-width: 34rem; max-width: 50rem; }
.map .drawing { min-width: 44rem; max-width: none; }
table { border-collapse: collapse; min-width: 60%; font-variant-numeric: tabular-nums; }
caption { text-align: left; color: var(--quiet); padding-bottom: 0.375rem; }
th, td { text-align: left; vertical-align: top; padding: 0.375rem 1rem 0.375rem 0;
  border-bottom: 1px solid var(--line); }
th.number, td.number { text-align: right; white-space: nowrap; }
td.right { font-weight: 700; background: var(--panel); }
tbody th { min-width: 11rem; }
.pictures { list-style: none; margin: 0; padding: 0; display: grid; gap: 1rem;
  grid-template-columns: repeat(auto-fill, minmax(min(100%, 17rem), 1fr)); }
.pictures li { background: var(--panel); border-radius: 0.5rem; overflow: hidden; }
.pictures img { display: block; width: 100%; height: auto; }
.pictures .about { padding: 0.75rem 0.875rem; }
.pictures p { margin: 0.25rem 0 0; overflow-wrap: anywhere; }
.pictures dl { display: grid; grid-template-columns: auto 1fr; gap: 0 0.75rem; margin: 0.25rem 0 0; }
.pictures dt { color: var(--quiet); }
.pictures dd { margin: 0; overflow-wrap: anywhere; }
footer { margin-top: 3rem; color: var(--quiet); font-size: 0.875rem; }
)";

}  // namespace

std::string picture_element(const image::ColorImage& picture, std::string_view alt) {
  constexpr int kWidth = 320;
  constexpr int kJpegQuality = 80;
  const int width = std::min(kWidth, picture.width());
  const int height = std::max(
      1, static_cast<int>(std::lround(double(picture.height()) * width / picture.width())));
  return fmt::format("<img src=\"{}\" width=\"{}\" height=\"{}\" loading=\"lazy\" alt=\"{}\"/>\n",
                     jpeg_address(image::resize(picture, width, height), kJpegQuality), width,
                     height, escape_markup(alt));
}

std::string report_page(std::string_view title, const std::vector<std::string>& notes,
                        std::string_view body) {
  std::string html = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n"
      "<title>{0} – "
      "Roomwise</title>\n<style>{1}{2}</style>\n</head>\n<body>\n<main>\n<h1>{0}</h1>\n",
      escape_markup(title), kPageStyle, svg_style());
  for (const std::string& note : notes) html += fmt::format("<p>{}</p>\n", escape_markup(note));
  return html + std::string(body) +
         "</main>\n<footer><p>Everything on this page is inside this file; opening it asks nothing "
         "of the network.</p></footer>\n</body>\n</html>\n";
}

std::string scrolling(std::string_view name, std::string_view html, std::string_view kind) {
  return fmt::format(
      "<div class=\"scroll {}\" tabindex=\"0\" role=\"region\" aria-label=\"{}\">\n{}</div>\n",
      kind, escape_markup(name), html);
}

std::string report_table(std::string_view caption, const std::vector<std::string>& columns,
                         const std::vector<std::vector<std::string>>& rows,
                         std::size_t text_columns, const std::vector<std::size_t>& highlighted) {
  const auto number_class = [&](std::size_t column) {
    return column < text_columns ? "" : " class=\"number\"";
  };
  std::string html =
      fmt::format("<table>\n<caption>{}</caption>\n<thead>\n<tr>", escape_markup(caption));
  for (std::size_t i = 0; i < columns.size(); ++i) {
    html += fmt::format("<th scope=\"col\"{}>{}</th>", number_class(i), escape_markup(columns[i]));
  }
  html += "</tr>\n</thead>\n<tbody>\n";
  for (std::size_t row = 0; row < rows.size(); ++row) {
    html += fmt::format("<tr><th scope=\"row\">{}</th>", escape_markup(rows[row].front()));
    for (std::size_t i = 1; i < rows[row].size(); ++i) {
      const bool stands_out = row < highlighted.size() && i == highlighted[row];
      html += fmt::format("<td{}>{}</td>", stands_out ? " class=\"number right\"" : number_class(i),
                          escape_markup(rows[row][i]));
    }
    html += "</tr>\n";
  }
  return scrolling(caption, html + "</tbody>\n</table>\n");
}

std::string confusion_table(std::string_view rule, const ConfusionMatrix& confusion) {
  if (confusion.empty()) return "";
  const std::vector<std::string> rooms = confusion.rooms();
  std::vector<std::string> columns = {"Truth"};
  for (const std::string& room : rooms) columns.push_back("said " + room);
  columns.insert(columns.end(), {"Precision", "Recall"});
  std::vector<std::vector<std::string>> rows;
  std::vector<std::size_t> right;
  for (std::size_t i = 0; i < rooms.size(); ++i) {
    if (confusion.recall(rooms[i]).n == 0) continue;  // an answer that is no room
    std::vector<std::string>& cells = rows.emplace_back(1, rooms[i]);
    for (const std::string& answer : rooms) {
      cells.push_back(std::to_string(confusion.count(rooms[i], answer)));
    }
    cells.push_back(percent_of(confusion.precision(rooms[i])));
    cells.push_back(percent_of(confusion.recall(rooms[i])));
    right.push_back(i + 1);
  }
  return report_table(fmt::format("{}: a row for each true room", rule), columns, rows, 1, right);
}

std::string figure_table(std::string_view caption, const std::vector<NamedFigure>& figures,
                         std::size_t text_columns) {
  std::vector<std::vector<std::string>> rows;
  for (const auto& [name, value] : figures) rows.push_back({name, value});
  return report_table(caption, {"Figure", "Value"}, rows, text_columns);
}

std::string picture_list(const std::vector<PictureNote>& notes) {
  std::string html = "<ul class=\"pictures\">\n";
  for (const PictureNote& note : notes) {
    html += fmt::format("<li>\n{}<div class=\"about\">\n<h3>{}</h3>\n<p>{}</p>\n</div>\n</li>\n",
                        picture_element(note.picture, note.alt), escape_markup(note.heading),
                        escape_markup(note.text));
  }
  return html + "</ul>\n";
}

}  // namespace roomwise::evaluation
