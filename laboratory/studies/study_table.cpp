#include "laboratory/studies/study_table.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <numeric>

namespace roomwise::studies {
namespace {

std::optional<double> figure_of(const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// One cell: of the same figure of several tasks. Texts are listed. Where not all have one it is
// said how many have.
std::string cell_of(const std::vector<std::string>& texts, int digits) {
  std::vector<double> figures;
  std::vector<std::string> others;
  for (const std::string& text : texts) {
    if (const auto figure = figure_of(text)) {
      figures.push_back(*figure);
    } else if (!text.empty() && std::ranges::find(others, text) == others.end()) {
      others.push_back(text);
    }
  }
  const auto there = static_cast<std::size_t>(
      std::ranges::count_if(texts, [](const std::string& text) { return !text.empty(); }));
  const std::string of = there < texts.size() ? fmt::format(" (of {})", there) : "";
  if (there == 0) return "–";
  if (figures.empty()) return fmt::format("{}{}", fmt::join(others, ", "), of);
  const double mean =
      std::accumulate(figures.begin(), figures.end(), 0.0) / static_cast<double>(figures.size());
  const auto [least, largest] = std::ranges::minmax(figures);
  if (least == largest) return fmt::format("{:.{}g}{}", mean, digits, of);
  return fmt::format("{0:.{3}g} ({1:.{3}g} – {2:.{3}g}){4}", mean, least, largest, digits, of);
}

using Cells = std::vector<std::string>;

std::string row_of(const Cells& cells) {
  return fmt::format("| {} |\n", fmt::join(cells, " | "));
}

std::vector<Cells> transposed(const std::vector<Cells>& rows) {
  std::vector<Cells> columns(rows.front().size());
  for (const Cells& row : rows) {
    for (std::size_t i = 0; i < columns.size(); ++i) columns[i].push_back(row[i]);
  }
  return columns;
}

// The first row is its head.
std::string markdown_of(const std::vector<Cells>& rows) {
  std::string text = row_of(rows.front()) + row_of(Cells(rows.front().size(), "---"));
  for (std::size_t i = 1; i < rows.size(); ++i) text += row_of(rows[i]);
  return text;
}

}  // namespace

std::string table_of(const Study& study, const std::vector<StudyTask>& tasks,
                     const std::vector<TaskResult>& results) {
  std::map<std::string, const TaskResult*> by_id;
  for (const TaskResult& result : results) by_id[result.id] = &result;
  Cells head = study.groups;
  head.emplace_back("tasks");
  for (const StudyValue& value : study.values) head.push_back(value.name);
  std::vector<Cells> written{head};

  std::vector<Cells> rows;  // of factors, in the order of the tasks
  std::map<Cells, std::vector<const StudyTask*>> of_row;
  for (const StudyTask& task : tasks) {
    Cells row;
    for (const std::string& name : study.groups) row.push_back(task.factors.at(name));
    if (!of_row.contains(row)) rows.push_back(row);
    of_row[row].push_back(&task);
  }
  std::string failures;
  std::size_t open = 0;
  for (const auto& row : rows) {
    std::vector<const TaskResult*> good;
    for (const StudyTask* task : of_row[row]) {
      const auto found = by_id.find(task->id);
      if (found == by_id.end()) {
        ++open;
      } else if (found->second->is_good) {
        good.push_back(found->second);
      } else {
        failures += fmt::format("- {}: {}\n", task->title(), found->second->why);
      }
    }
    Cells cells = row;
    cells.push_back(fmt::format("{} of {}", good.size(), of_row[row].size()));
    for (const StudyValue& value : study.values) {
      std::vector<std::string> texts;
      for (const TaskResult* result : good) {
        const auto figure = result->values.find(value.name);
        texts.push_back(figure == result->values.end() ? "" : figure->second);
      }
      cells.push_back(cell_of(texts, study.digits));
    }
    written.push_back(std::move(cells));
  }
  std::string text = study.about.empty() ? "" : study.about + "\n\n";
  text += markdown_of(study.are_columns ? transposed(written) : written);
  if (!failures.empty()) text += "\nFailed:\n\n" + failures;
  if (open > 0) text += fmt::format("\n{} tasks are not done yet.\n", open);
  return text;
}

}  // namespace roomwise::studies
