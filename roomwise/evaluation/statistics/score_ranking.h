#pragma once

#include <span>
#include <vector>

namespace roomwise::evaluation {

// How well a score tells two kinds of things apart: the probability that one of `high`, drawn at
// random, has a higher score than one of `low`; ties count half (the area under the ROC curve,
// AUROC; Hanley and McNeil, 1982). 0.5 tells nothing, 1 everything. 0.5 where either is empty.
[[nodiscard]] double area_under_roc(std::span<const double> high, std::span<const double> low);

// An answer with how sure it is.
struct ScoredAnswer {
  double score = 0;
  bool right = false;
};

// What is left where only answers with at least `threshold` are given.
struct CoveragePoint {
  double threshold = 0;
  double coverage = 0;   // share of questions that are answered
  double precision = 0;  // share of the answers that are right
};

// A point for every different score, from the surest answers alone to all of them. Empty where
// there are no answers.
[[nodiscard]] std::vector<CoveragePoint> precision_against_coverage(
    std::vector<ScoredAnswer> answers);

}  // namespace roomwise::evaluation
