#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "roomwise/evaluation/statistics/confusion_matrix.h"
#include "roomwise/evaluation/statistics/resampling.h"
#include "roomwise/evaluation/statistics/score_ranking.h"
#include "roomwise/pipeline/rooms/home_places.h"
#include "roomwise/pipeline/rooms/labelled_pictures.h"
#include "roomwise/pipeline/rooms/room_recognizer.h"
#include "roomwise/pipeline/run_context.h"

namespace roomwise::pipeline {

// What was said of one picture (of a pair: of its second one).
struct Judgement {
  std::size_t picture = 0;  // of the pictures that were evaluated
  std::string best;         // the most probable room
  bool named = true;        // false: it was not said, but "not sure" or "none of them"
  std::string answer;       // what was said: the best room, "not sure" or "none of them"
  double score = 0;         // of the best room, by which answers are ranked
  std::string why;
};

// How well one way of recognising rooms did.
struct RuleResult {
  std::string key;   // for machines: "pair"
  std::string rule;  // for people: "two pictures"
  std::vector<Judgement> judgements;
  double median_ms = 0;                          // of wall time a decision
  std::map<std::string, std::uint64_t> reasons;  // how the answers were reached; may be empty
};

// Of the rooms that were named: how many rightly.
[[nodiscard]] evaluation::BlockedProportion precision_of(
    const RuleResult& result, const std::vector<LabelledPicture>& pictures, bool by_walks);
// Of all: how often the most probable room is right, whether it was named or not.
[[nodiscard]] evaluation::BlockedProportion top1_accuracy_of(
    const RuleResult& result, const std::vector<LabelledPicture>& pictures, bool by_walks);
[[nodiscard]] evaluation::ConfusionMatrix confusion_of(
    const RuleResult& result, const std::vector<LabelledPicture>& pictures);
[[nodiscard]] std::vector<evaluation::CoveragePoint> curve_of(
    const RuleResult& result, const std::vector<LabelledPicture>& pictures);

// What was made of pictures of places that were never learned.
struct UnknownResult {
  struct Share {
    std::size_t decisions = 0;
    std::uint64_t named = 0;
    // The probability that what shows a learned room is known better than what shows one of these.
    double area_under_roc = 0;
  };
  std::string key;                               // for machines: "unknown_pair"
  std::string rule;                              // for people: "two pictures"
  std::map<std::string, std::uint64_t> answers;  // "not sure", "none of them", names of rooms
  Share all;
  std::vector<Share> walks;  // of each LabelledPicture::walk; photos make no pairs
};

struct RoomEvaluation {
  std::vector<RuleResult> rules;
  std::vector<UnknownResult> unknown;  // with places where one of them has depth
  // Whether intervals resample whole walks (from five walks on), or else visits of rooms.
  bool by_walks = false;
  std::vector<std::vector<float>> features;  // of each picture, as the network gives them
};

struct RoomEvaluationOptions {
  std::size_t pair_step = 1;  // pictures between the two of a pair
  // The pictures of a walk were taken so far apart, s; absent: by their time stamps.
  std::optional<double> interval_s;
};

// Recognises every picture, every pair of pictures `pair_step` apart and (photos apart) every walk
// as a stream, by comparing and by the paper's rule. The stream sees the evaluated pictures alone.
// Where pictures have depth and `places` is given, the same again with their places, whose time
// counts where they were asked for.
// `unknown`: pictures of places that were never learned, or none.
[[nodiscard]] Expected<RoomEvaluation> evaluate_rooms(const std::vector<LabelledPicture>& pictures,
                                                      const std::vector<LabelledPicture>& unknown,
                                                      const RoomRecognizer& recognizer,
                                                      const HomePlaces* places,
                                                      const RoomEvaluationOptions& options,
                                                      RunContext& run);

}  // namespace roomwise::pipeline
