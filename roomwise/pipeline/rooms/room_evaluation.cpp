#include "roomwise/pipeline/rooms/room_evaluation.h"

#include <algorithm>

#include "roomwise/base/stopwatch.h"
#include "roomwise/evaluation/statistics/quantile.h"
#include "roomwise/pipeline/rooms/find_places.h"
#include "roomwise/pipeline/rooms/predict_pictures.h"

namespace roomwise::pipeline {
namespace {

constexpr std::size_t kWalksToResample = 5;

std::vector<PictureSpan> singles_of(const std::vector<LabelledPicture>& pictures) {
  std::vector<PictureSpan> singles;
  for (std::size_t i = 0; i < pictures.size(); ++i) singles.push_back({i, i});
  return singles;
}

bool have_depth(const std::vector<LabelledPicture>& pictures) {
  return std::ranges::any_of(
      pictures, [](const LabelledPicture& picture) { return picture.read_to_locate != nullptr; });
}

bool have_walks(const std::vector<LabelledPicture>& pictures) {
  return std::ranges::any_of(pictures,
                             [](const LabelledPicture& picture) { return picture.frame > 0; });
}

// Whether a picture is one of a walk, and not a photo: photos are all the first of theirs.
bool is_on_walk(const std::vector<LabelledPicture>& pictures, std::size_t picture) {
  return std::ranges::any_of(pictures, [&](const LabelledPicture& other) {
    return other.walk == pictures[picture].walk && other.frame > 0;
  });
}

std::vector<PictureSpan> pairs_of(const std::vector<LabelledPicture>& pictures, std::size_t step) {
  std::vector<PictureSpan> pairs;
  for (std::size_t i = 0; i + step < pictures.size(); ++i) {
    if (pictures[i].sequence == pictures[i + step].sequence) pairs.push_back({i, i + step});
  }
  return pairs;
}

Judgement judgement_of(std::size_t picture, const rooms::RoomDecision& decision) {
  const rooms::RoomScore& best = decision.rooms.front();
  const bool named = decision.verdict == rooms::Verdict::kRoom;
  return {picture,    best.room,
          named,      named ? best.room : std::string(to_string(decision.verdict)),
          best.score, decision.why};
}

Judgement judgement_of(std::size_t picture, const rooms::RoomAnswer& answer) {
  std::string why(to_string(answer.reason));
  if (!answer.object.empty()) why += fmt::format(" ({})", answer.object);
  return {picture, answer.room, true, answer.room, answer.score, why};
}

// Runs every rule over the same pictures, with what the networks see in them.
class Evaluator {
 public:
  Evaluator(const std::vector<LabelledPicture>& pictures, const RoomRecognizer& recognizer,
            const RoomEvaluationOptions& options, RunContext& run)
      : pictures_(pictures), recognizer_(recognizer), options_(options), run_(run) {}

  Expected<void> look() {
    ROOMWISE_TRY(seen_, look_at(pictures_));
    for (const TimedPrediction& one : seen_) {
      ROOMWISE_TRY(const auto scores, recognizer_.paper_scores(one.prediction));
      paper_.push_back(scores.front());
      ROOMWISE_TRY(evidence_.emplace_back(), recognizer_.evidence(one.prediction));
    }
    return {};
  }
  [[nodiscard]] std::vector<std::vector<float>> features() const {
    std::vector<std::vector<float>> features;
    for (const TimedPrediction& one : seen_) features.push_back(one.prediction.features);
    return features;
  }

  RuleResult paper_single() const {
    RuleResult result{"paper_single", "the paper's way, one picture", {}, 0, {}};
    std::vector<double> ms;
    for (std::size_t i = 0; i < pictures_.size(); ++i) {
      result.judgements.push_back(judgement_of(
          i, rooms::RoomAnswer{paper_[i].room, paper_[i].score, rooms::Reason::kSingleFrame, ""}));
      ms.push_back(seen_[i].ms);
    }
    result.median_ms = evaluation::quantile(ms, 0.5);
    return result;
  }

  Expected<RuleResult> paper_pair(bool with_objects) {
    RuleResult result{with_objects ? "paper_pair" : "paper_pair_without_objects",
                      with_objects ? "the paper's way, two pictures"
                                   : "the paper's way, two pictures, no objects",
                      {},
                      0,
                      {}};
    std::vector<double> ms;
    for (const PictureSpan& pair : pairs_of(pictures_, options_.pair_step)) {
      double taken_ms = seen_[pair.first].ms + seen_[pair.second].ms;
      const auto see_names = with_objects ? namer(pair.second, taken_ms) : nullptr;
      ROOMWISE_TRY(const rooms::RoomAnswer answer,
                   recognizer_.paper_decide(paper_[pair.first], paper_[pair.second], see_names));
      result.judgements.push_back(judgement_of(pair.second, answer));
      ms.push_back(taken_ms);
    }
    result.median_ms = evaluation::quantile(ms, 0.5);
    return result;
  }

  // By comparing, the two pictures of each entry as one; with their places, unless these are empty.
  Expected<RuleResult> compared(std::string key, std::string rule,
                                const std::vector<PictureSpan>& spans, const TimedPlaces& places) {
    RuleResult result{std::move(key), std::move(rule), {}, 0, {}};
    std::vector<double> ms;
    for (std::size_t i = 0; i < spans.size(); ++i) {
      const PictureSpan& span = spans[i];
      double taken_ms = seen_[span.first].ms;
      if (span.second != span.first) taken_ms += seen_[span.second].ms;
      ROOMWISE_TRY(const rooms::RoomDecision decision,
                   recognizer_.decide(evidence_of(evidence_, span), namer(span.second, taken_ms),
                                      finder(places, i, taken_ms)));
      result.judgements.push_back(judgement_of(span.second, decision));
      ms.push_back(taken_ms);
    }
    result.median_ms = evaluation::quantile(ms, 0.5);
    return result;
  }

  Expected<RuleResult> stream(std::string key, std::string rule, const TimedPlaces& places) const {
    RuleResult result{std::move(key), std::move(rule), {}, 0, {}};
    std::vector<double> ms(pictures_.size());
    for (std::size_t i = 0; i < pictures_.size(); ++i) ms[i] = seen_[i].ms;
    ROOMWISE_TRY(const auto decisions, along_walks(pictures_, evidence_, places, ms));
    for (std::size_t i = 0; i < pictures_.size(); ++i) {
      result.judgements.push_back(judgement_of(i, decisions[i]));
    }
    result.median_ms = evaluation::quantile(ms, 0.5);
    return result;
  }

  // One picture, two, and every picture of a walk.
  Expected<void> compare_all(const HomePlaces* places, std::vector<RuleResult>& rules) {
    const std::vector<PictureSpan> singles = singles_of(pictures_);
    const std::vector<PictureSpan> pairs = pairs_of(pictures_, options_.pair_step);
    const bool has_walks = have_walks(pictures_);
    ROOMWISE_TRY(rules.emplace_back(), compared("single", "one picture", singles, {}));
    ROOMWISE_TRY(rules.emplace_back(), compared("pair", "two pictures", pairs, {}));
    if (has_walks) {
      ROOMWISE_TRY(rules.emplace_back(), stream("stream", "every picture of a walk", {}));
    }
    if (places == nullptr || !have_depth(pictures_)) return {};
    ROOMWISE_TRY(of_pictures_, look_for(*places, pictures_, singles));
    ROOMWISE_TRY(of_pairs_, look_for(*places, pictures_, pairs));
    ROOMWISE_TRY(rules.emplace_back(),
                 compared("single_place", "one picture, with its place", singles, of_pictures_));
    ROOMWISE_TRY(rules.emplace_back(),
                 compared("pair_place", "two pictures, with their place", pairs, of_pairs_));
    if (has_walks) {
      ROOMWISE_TRY(rules.emplace_back(),
                   stream("stream_place", "every picture of a walk, with its place", of_pictures_));
    }
    return {};
  }

  // Pictures of places that were never learned, without and, where any has depth, with their place.
  Expected<void> unknown(const std::vector<LabelledPicture>& pictures, const HomePlaces* places,
                         RoomEvaluation& evaluation) {
    ROOMWISE_TRY(const auto seen, look_at(pictures));
    std::vector<rooms::PictureEvidence> evidence;
    for (const TimedPrediction& one : seen) {
      ROOMWISE_TRY(evidence.emplace_back(), recognizer_.evidence(one.prediction));
    }
    const std::vector<PictureSpan> singles = singles_of(pictures);
    const std::vector<PictureSpan> pairs = pairs_of(pictures, options_.pair_step);
    const bool have_places = places != nullptr && have_depth(pictures);
    TimedPlaces places_of_unknown;  // of single pictures
    for (const auto& [spans, of_known, places_of_known, key, rule] :
         {std::tuple(&singles, singles_of(pictures_), &of_pictures_, "unknown", "one picture"),
          std::tuple(&pairs, pairs_of(pictures_, options_.pair_step), &of_pairs_, "unknown_pair",
                     "two pictures")}) {
      if (spans->empty() || of_known.empty()) continue;
      const std::vector<double> known = familiarity_of(evidence_, of_known, {});
      ROOMWISE_TRY(evaluation.unknown.emplace_back(),
                   judge_unknown(key, rule, pictures, evidence, *spans, {}, known));
      if (!have_places) continue;
      ROOMWISE_TRY(const TimedPlaces found, look_for(*places, pictures, *spans));
      ROOMWISE_TRY(evaluation.unknown.emplace_back(),
                   judge_unknown(fmt::format("{}_place", key), fmt::format("{}, with place", rule),
                                 pictures, evidence, *spans, found,
                                 familiarity_of(evidence_, of_known, *places_of_known)));
      if (spans == &singles) places_of_unknown = found;
    }
    if (!have_walks(pictures_) || !have_walks(pictures)) return {};
    ROOMWISE_TRY(evaluation.unknown.emplace_back(),
                 judge_unknown_walks("unknown_stream", "every picture of a walk", pictures,
                                     evidence, {}, {}));
    if (!have_places) return {};
    ROOMWISE_TRY(evaluation.unknown.emplace_back(),
                 judge_unknown_walks("unknown_stream_place", "every picture of a walk, with place",
                                     pictures, evidence, places_of_unknown, of_pictures_));
    return {};
  }

 private:
  // Gives the place of an entry and adds the time that it took; empty where there is none.
  static RoomRecognizer::Localize finder(const TimedPlaces& places, std::size_t entry,
                                         double& taken_ms) {
    if (places.empty() || !places[entry]) return {};
    return [&place = *places[entry], &taken_ms]() -> Expected<rooms::LocalizationEvidence> {
      taken_ms += place.ms;
      return place.evidence;
    };
  }

  [[nodiscard]] Expected<TimedPlaces> look_for(const HomePlaces& places,
                                               const std::vector<LabelledPicture>& pictures,
                                               const std::vector<PictureSpan>& spans) {
    return find_places(places, pictures, spans, recognizer_.rooms(), run_);
  }

  static std::vector<rooms::PictureEvidence> evidence_of(
      const std::vector<rooms::PictureEvidence>& evidence, const PictureSpan& span) {
    std::vector<rooms::PictureEvidence> shown{evidence[span.first]};
    if (span.second != span.first) shown.push_back(evidence[span.second]);
    return shown;
  }

  // What is said at each picture of walks, each walk for itself. `ms` takes what the places took.
  Expected<std::vector<rooms::RoomDecision>> along_walks(
      const std::vector<LabelledPicture>& pictures,
      const std::vector<rooms::PictureEvidence>& evidence, const TimedPlaces& places,
      std::vector<double>& ms) const {
    std::vector<rooms::RoomDecision> decisions;
    rooms::RoomStream stream = recognizer_.stream();
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      if (i > 0 && pictures[i].walk != pictures[i - 1].walk) stream = recognizer_.stream();
      ROOMWISE_TRY(decisions.emplace_back(),
                   recognizer_.update(stream, evidence[i], elapsed_s(pictures, i),
                                      finder(places, i, ms[i])));
    }
    return decisions;
  }

  // Of each span; `places` are used wherever there are any.
  [[nodiscard]] std::vector<double> familiarity_of(
      const std::vector<rooms::PictureEvidence>& evidence, const std::vector<PictureSpan>& spans,
      const TimedPlaces& places) const {
    std::vector<double> known;
    for (std::size_t i = 0; i < spans.size(); ++i) {
      const rooms::PictureEvidence shown = rooms::combine(evidence_of(evidence, spans[i]));
      const bool is_placed = !places.empty() && places[i];
      known.push_back(
          is_placed ? rooms::with_place(shown, places[i]->evidence, recognizer_.model()).familiarity
                    : shown.familiarity);
    }
    return known;
  }

  // `known`: how well what shows learned rooms is known.
  Expected<UnknownResult> judge_unknown(std::string key, std::string rule,
                                        const std::vector<LabelledPicture>& pictures,
                                        const std::vector<rooms::PictureEvidence>& evidence,
                                        const std::vector<PictureSpan>& spans,
                                        const TimedPlaces& places,
                                        const std::vector<double>& known) const {
    std::vector<Judgement> judgements;
    double ignored_ms = 0;
    for (std::size_t i = 0; i < spans.size(); ++i) {
      const auto see_names = [&]() -> Expected<network::Prediction> {
        ROOMWISE_TRY(const image::ColorImage picture, pictures[spans[i].second].read());
        return recognizer_.naming()->predict(picture);
      };
      ROOMWISE_TRY(const rooms::RoomDecision decision,
                   recognizer_.decide(evidence_of(evidence, spans[i]), see_names,
                                      finder(places, i, ignored_ms)));
      judgements.push_back(judgement_of(spans[i].second, decision));
    }
    return sum_up(std::move(key), std::move(rule), pictures, judgements,
                  familiarity_of(evidence, spans, places), known);
  }

  // The same along walks; of photos nothing is said.
  Expected<UnknownResult> judge_unknown_walks(std::string key, std::string rule,
                                              const std::vector<LabelledPicture>& pictures,
                                              const std::vector<rooms::PictureEvidence>& evidence,
                                              const TimedPlaces& places,
                                              const TimedPlaces& places_of_known) const {
    std::vector<double> known;
    std::vector<double> ignored_ms(std::max(pictures.size(), pictures_.size()));
    ROOMWISE_TRY(const auto of_known,
                 along_walks(pictures_, evidence_, places_of_known, ignored_ms));
    for (const rooms::RoomDecision& decision : of_known) known.push_back(decision.familiarity);
    ROOMWISE_TRY(const auto decisions, along_walks(pictures, evidence, places, ignored_ms));
    std::vector<Judgement> judgements;
    std::vector<double> known_here;
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      if (!is_on_walk(pictures, i)) continue;
      judgements.push_back(judgement_of(i, decisions[i]));
      known_here.push_back(decisions[i].familiarity);
    }
    return sum_up(std::move(key), std::move(rule), pictures, judgements, known_here, known);
  }

  // `known_here`: how well each judgement's pictures are known.
  static UnknownResult sum_up(std::string key, std::string rule,
                              const std::vector<LabelledPicture>& pictures,
                              const std::vector<Judgement>& judgements,
                              const std::vector<double>& known_here,
                              const std::vector<double>& known) {
    UnknownResult result{std::move(key), std::move(rule), {}, {}, {}};
    result.all.decisions = judgements.size();
    result.walks.resize(pictures.back().walk + 1);
    std::vector<std::vector<double>> known_of_walks(result.walks.size());
    for (std::size_t i = 0; i < judgements.size(); ++i) {
      const std::size_t walk = pictures[judgements[i].picture].walk;
      ++result.answers[judgements[i].answer];
      ++result.walks[walk].decisions;
      known_of_walks[walk].push_back(known_here[i]);
      if (!judgements[i].named) continue;
      ++result.all.named;
      ++result.walks[walk].named;
    }
    result.all.area_under_roc = evaluation::area_under_roc(known, known_here);
    for (std::size_t walk = 0; walk < result.walks.size(); ++walk) {
      if (known_of_walks[walk].empty()) continue;
      result.walks[walk].area_under_roc = evaluation::area_under_roc(known, known_of_walks[walk]);
    }
    return result;
  }

  [[nodiscard]] Expected<std::vector<TimedPrediction>> look_at(
      const std::vector<LabelledPicture>& pictures) {
    return predict_pictures(
        pictures.size(), [&](std::size_t i) { return pictures[i].read(); }, recognizer_.features(),
        "recognising rooms", run_);
  }

  // Gives what the naming network sees in a picture, looked at once for all rules, and adds the
  // time that it took.
  RoomRecognizer::PredictLabels namer(std::size_t picture, double& taken_ms) {
    return [this, picture, &taken_ms]() -> Expected<network::Prediction> {
      auto named = named_.find(picture);
      if (named == named_.end()) {
        ROOMWISE_TRY(const image::ColorImage color, pictures_[picture].read());
        const Stopwatch watch;
        ROOMWISE_TRY(network::Prediction prediction, recognizer_.naming()->predict(color));
        named = named_.emplace(picture, TimedPrediction{std::move(prediction), watch.ms()}).first;
      }
      taken_ms += named->second.ms;
      return named->second.prediction;
    };
  }

  // Between a picture and the one before it on its walk.
  [[nodiscard]] double elapsed_s(const std::vector<LabelledPicture>& pictures,
                                 std::size_t i) const {
    if (i == 0 || pictures[i].walk != pictures[i - 1].walk) return 0;
    if (options_.interval_s) {
      return *options_.interval_s * static_cast<double>(pictures[i].frame - pictures[i - 1].frame);
    }
    return std::max(0.0, pictures[i].time_s - pictures[i - 1].time_s);
  }

  const std::vector<LabelledPicture>& pictures_;
  const RoomRecognizer& recognizer_;
  const RoomEvaluationOptions& options_;
  RunContext& run_;
  std::vector<TimedPrediction> seen_;
  std::vector<rooms::RoomScore> paper_;  // the best of each picture
  std::vector<rooms::PictureEvidence> evidence_;
  std::map<std::size_t, TimedPrediction> named_;
  TimedPlaces of_pictures_;  // empty where none was looked for
  TimedPlaces of_pairs_;     // likewise
};

// How many of the judgements that count have the right room as the most probable one.
template <typename Counts>
evaluation::BlockedProportion share_right(const RuleResult& result,
                                          const std::vector<LabelledPicture>& pictures,
                                          bool by_walks, Counts counts) {
  evaluation::BlockedProportion proportion;
  for (const Judgement& judgement : result.judgements) {
    if (!counts(judgement)) continue;
    const LabelledPicture& picture = pictures[judgement.picture];
    proportion.add(by_walks ? picture.walk : picture.sequence, judgement.best == picture.room);
  }
  return proportion;
}

}  // namespace

evaluation::BlockedProportion precision_of(const RuleResult& result,
                                           const std::vector<LabelledPicture>& pictures,
                                           bool by_walks) {
  return share_right(result, pictures, by_walks, [](const Judgement& one) { return one.named; });
}

evaluation::BlockedProportion top1_accuracy_of(const RuleResult& result,
                                               const std::vector<LabelledPicture>& pictures,
                                               bool by_walks) {
  return share_right(result, pictures, by_walks, [](const Judgement&) { return true; });
}

evaluation::ConfusionMatrix confusion_of(const RuleResult& result,
                                         const std::vector<LabelledPicture>& pictures) {
  evaluation::ConfusionMatrix confusion;
  for (const Judgement& judgement : result.judgements) {
    confusion.add(pictures[judgement.picture].room, judgement.answer);
  }
  return confusion;
}

std::vector<evaluation::CoveragePoint> curve_of(const RuleResult& result,
                                                const std::vector<LabelledPicture>& pictures) {
  std::vector<evaluation::ScoredAnswer> answers;
  for (const Judgement& judgement : result.judgements) {
    answers.push_back({judgement.score, judgement.best == pictures[judgement.picture].room});
  }
  return evaluation::precision_against_coverage(std::move(answers));
}

Expected<RoomEvaluation> evaluate_rooms(const std::vector<LabelledPicture>& pictures,
                                        const std::vector<LabelledPicture>& unknown,
                                        const RoomRecognizer& recognizer, const HomePlaces* places,
                                        const RoomEvaluationOptions& options, RunContext& run) {
  if (options.pair_step == 0) return fail("the two pictures of a pair must be at least 1 apart");
  Evaluator evaluator(pictures, recognizer, options, run);
  ROOMWISE_RETURN_IF_ERROR(evaluator.look());
  RoomEvaluation evaluation;
  evaluation.features = evaluator.features();
  evaluation.by_walks = !pictures.empty() && pictures.back().walk + 1 >= kWalksToResample;
  ROOMWISE_RETURN_IF_ERROR(evaluator.compare_all(places, evaluation.rules));
  if (!unknown.empty()) ROOMWISE_RETURN_IF_ERROR(evaluator.unknown(unknown, places, evaluation));
  evaluation.rules.push_back(evaluator.paper_single());
  ROOMWISE_TRY(evaluation.rules.emplace_back(), evaluator.paper_pair(false));
  if (recognizer.naming() != nullptr) {
    ROOMWISE_TRY(evaluation.rules.emplace_back(), evaluator.paper_pair(true));
  }
  for (RuleResult& rule : evaluation.rules) {
    for (const Judgement& judgement : rule.judgements) {
      if (rule.key.starts_with("paper")) ++rule.reasons[judgement.why];
    }
  }
  return evaluation;
}

}  // namespace roomwise::pipeline
