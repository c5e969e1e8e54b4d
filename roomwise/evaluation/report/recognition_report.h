#pragma once

#include <string>
#include <vector>

#include "roomwise/evaluation/drawing/svg.h"
#include "roomwise/evaluation/report/report_page.h"
#include "roomwise/evaluation/statistics/confusion_matrix.h"
#include "roomwise/evaluation/statistics/score_ranking.h"
#include "roomwise/image/image.h"

namespace roomwise::evaluation {

// What a page about the recognition of rooms says.
struct RecognitionReportContent {
  struct DecisionRule {
    std::string name;  // "two pictures"
    std::uint64_t decisions = 0;
    Proportion named_correct;     // of the rooms that were named
    Interval precision_interval;  // 95 %
    Proportion top1_correct;      // of all: the most probable room, named or not
    Interval top1_interval;       // 95 %
    double median_ms = 0;         // of a decision
    ConfusionMatrix confusion;    // answers may be "not sure" and "none of them"
    std::vector<CoveragePoint> curve;
  };
  // A picture whose room was named wrongly.
  struct Mistake {
    image::ColorImage picture;
    std::string name;  // "walk: frame 12"
    std::string rule;
    std::string room;    // the true one
    std::string answer;  // what was said
    std::string why;
  };

  std::string title;
  std::vector<std::string> notes;    // how it was measured
  std::vector<NamedFigure> figures;  // what else is to be said, of unknown pictures
  std::vector<DecisionRule> rules;
  std::vector<Mistake> mistakes;
};

// Precision against coverage, a curve a rule (at most six).
[[nodiscard]] SvgDrawing plot_precision_against_coverage(const RecognitionReportContent& content);

// A page (report_page.h).
[[nodiscard]] std::string render_recognition_report(const RecognitionReportContent& content);

}  // namespace roomwise::evaluation
