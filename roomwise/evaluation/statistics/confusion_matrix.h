#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "roomwise/evaluation/statistics/proportion.h"

namespace roomwise::evaluation {

// Which rooms were taken for which.
class ConfusionMatrix {
 public:
  void add(const std::string& truth, const std::string& answer, std::uint64_t times = 1);

  // Every room that was the truth or an answer, in the order of their names.
  [[nodiscard]] std::vector<std::string> rooms() const;
  [[nodiscard]] std::uint64_t count(const std::string& truth, const std::string& answer) const;
  // Of the answers `room`, the share that was right.
  [[nodiscard]] Proportion precision(const std::string& room) const;
  // Of the questions whose truth was `room`, the share that was answered right.
  [[nodiscard]] Proportion recall(const std::string& room) const;
  [[nodiscard]] bool empty() const { return counts_.empty(); }

 private:
  std::map<std::string, std::map<std::string, std::uint64_t>> counts_;  // [truth][answer]
};

}  // namespace roomwise::evaluation
