#include "roomwise/evaluation/statistics/score_ranking.h"

#include <algorithm>

namespace roomwise::evaluation {

double area_under_roc(std::span<const double> high, std::span<const double> low) {
  if (high.empty() || low.empty()) return 0.5;
  std::vector<double> sorted(low.begin(), low.end());
  std::ranges::sort(sorted);
  double sum = 0;
  for (const double score : high) {
    const auto [first, last] = std::ranges::equal_range(sorted, score);
    sum += static_cast<double>(first - sorted.begin()) + static_cast<double>(last - first) / 2;
  }
  return sum / static_cast<double>(high.size()) / static_cast<double>(low.size());
}

std::vector<CoveragePoint> precision_against_coverage(std::vector<ScoredAnswer> answers) {
  std::ranges::sort(answers, std::ranges::greater{}, &ScoredAnswer::score);
  std::vector<CoveragePoint> points;
  double right = 0;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    right += answers[i].right ? 1 : 0;
    if (i + 1 < answers.size() && answers[i + 1].score == answers[i].score) continue;
    const auto given = static_cast<double>(i + 1);
    points.push_back(
        {answers[i].score, given / static_cast<double>(answers.size()), right / given});
  }
  return points;
}

}  // namespace roomwise::evaluation
