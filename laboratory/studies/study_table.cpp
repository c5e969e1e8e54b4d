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

// One cell: of the same figure of several tasks. Texts are listed.
std::string cell_of(const std::vector<std::string>& texts) {
  std::vector<double> figures;
  std::vector<std::string> others;
  for (const std::string& text : texts) {
    if (const auto figure = figure_of(text)) {
      figures.push_back(*figure);
    } else if (!text.empty() && std::ranges::find(others, text) == others.end()) {
      others.push_back(text);
    }
  }
  if (figures.empty()) return others.empty() ? "–" : fmt::format("{}", fmt::join(others, ", "));
  const double mean =
      std::accumulate(figures.begin(), figures.end(), 0.0) / static_cast<double>(figures.size());
  const auto [least, largest] = std::ranges::minmax(figures);
  if (least == largest) return fmt::format("{:.9g}", mean);
  return fmt::format("{:.9g} ({:.9g} – {:.9g})", mean, least, largest);
}

std::string row_of(const std::vector<std::string>& cells) {
  return fmt::format("| {} |\n", fmt::join(cells, " | "));
}

}  // namespace

std::string table_of(const Study& study, const std::vector<StudyTask>& tasks,
                     const std::vector<TaskResult>& results) {
  std::map<std::string, const TaskResult*> by_id;
  for (const TaskResult& result : results) by_id[result.id] = &result;
  std::vector<std::string> head = study.rows;
  head.emplace_back("tasks");
  for (const StudyValue& value : study.values) head.push_back(value.name);
  std::string text = row_of(head);
  text += row_of(std::vector<std::string>(head.size(), "---"));

  std::vector<std::vector<std::string>> rows;  // of factors, in the order of the tasks
  std::map<std::vector<std::string>, std::vector<const StudyTask*>> of_row;
  for (const StudyTask& task : tasks) {
    std::vector<std::string> row;
    for (const std::string& name : study.rows) row.push_back(task.factors.at(name));
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
    std::vector<std::string> cells = row;
    cells.push_back(fmt::format("{} of {}", good.size(), of_row[row].size()));
    for (const StudyValue& value : study.values) {
      std::vector<std::string> texts;
      for (const TaskResult* result : good) {
        const auto figure = result->values.find(value.name);
        texts.push_back(figure == result->values.end() ? "" : figure->second);
      }
      cells.push_back(cell_of(texts));
    }
    text += row_of(cells);
  }
  if (!failures.empty()) text += "\nFailed:\n\n" + failures;
  if (open > 0) text += fmt::format("\n{} tasks are not done yet.\n", open);
  return text;
}

}  // namespace roomwise::studies
