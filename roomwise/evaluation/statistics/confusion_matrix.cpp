#include "roomwise/evaluation/statistics/confusion_matrix.h"

#include <set>

namespace roomwise::evaluation {

void ConfusionMatrix::add(const std::string& truth, const std::string& answer,
                          std::uint64_t times) {
  counts_[truth][answer] += times;
}

std::vector<std::string> ConfusionMatrix::rooms() const {
  std::set<std::string> names;
  for (const auto& [truth, answers] : counts_) {
    names.insert(truth);
    for (const auto& [answer, count] : answers) names.insert(answer);
  }
  return {names.begin(), names.end()};
}

std::uint64_t ConfusionMatrix::count(const std::string& truth, const std::string& answer) const {
  const auto row = counts_.find(truth);
  if (row == counts_.end()) return 0;
  const auto cell = row->second.find(answer);
  return cell == row->second.end() ? 0 : cell->second;
}

Proportion ConfusionMatrix::precision(const std::string& room) const {
  Proportion right{.successes = count(room, room)};
  for (const auto& [truth, answers] : counts_) right.n += count(truth, room);
  return right;
}

Proportion ConfusionMatrix::recall(const std::string& room) const {
  Proportion right{.successes = count(room, room)};
  for (const std::string& answer : rooms()) right.n += count(room, answer);
  return right;
}

}  // namespace roomwise::evaluation
