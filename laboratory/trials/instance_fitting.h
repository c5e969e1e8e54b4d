#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "laboratory/trials/truth_evaluation.h"
#include "roomwise/evaluation/report/reliability.h"
#include "roomwise/evaluation/statistics/coverage.h"
#include "roomwise/objects/instances/instance_model.h"

// Fits the model that says which candidates are things, and how surely their middles are known
// (objects::InstanceModel), from homes whose things are known.
namespace roomwise::trials {

// What a candidate turned out to be.
enum class CandidateTruth {
  kThing,      // an expected one
  kUnasked,    // one that need not be found: neither learned from nor counted
  kDuplicate,  // one that another candidate is, too
  kNothing,
};

// A home to learn from. Its candidates hang on no model and are weighed once.
struct FittingCase {
  std::string name;
  std::string source;  // cases of one source share pictures and are left out together
  bool is_real = false;
  std::vector<objects::ObservedKeyframe> keyframes;  // of the largest component
  objects::WeighedCandidates weighed;
  std::vector<evaluation::TrueObject> truth;  // in the map's world
  std::vector<CandidateTruth> candidate_truth;
  std::vector<std::optional<std::size_t>> thing_of;  // of each candidate, which of the truth it is
};
// `truth` in the world of the key-frames. The case is its own source.
[[nodiscard]] FittingCase fitting_case(const std::string& name, bool is_real,
                                       std::vector<objects::ObservedKeyframe> keyframes,
                                       std::vector<evaluation::TrueObject> truth);
// Of a home, as the truth's walk shows it, by its file's name; its source is the truth's place
// (place_of()). A real one where the truth is a file of what people marked.
[[nodiscard]] Expected<FittingCase> fitting_case(const home::Home& home,
                                                 const ObjectTruthFiles& truth);

struct FittingOptions {
  // Ridge penalties, in units of one weighed candidate, of standardised evidence and of the kinds'
  // intercepts: half the square of a number costs so much.
  double weight_penalty = 10;
  double kind_penalty = 10;
  // Of the Student's t that a middle's error is taken for, more than 2: fewer take more errors for
  // outliers.
  double degrees_of_freedom = 4;
  double max_distance_m = 1.0;  // as in evaluate_objects()
};

// Logistic regression by Newton's method with ridge penalties. Candidates of real cases together
// weigh as much as those of simulated ones. The threshold is the one with the best F1, of all real
// and of all simulated cases in equal shares. The variance is fitted by maximum likelihood to the
// middles of all candidates that are true things, expected or not (variance_regression()). Fails
// where no candidate is a thing or none is nothing.
[[nodiscard]] Expected<objects::InstanceModel> fit_instances(
    std::span<const FittingCase* const> cases, const FittingOptions& options);

// On every case but those of a source. Fails where there is none.
[[nodiscard]] Expected<objects::InstanceModel> fit_without(const std::string& source,
                                                           std::span<const FittingCase> cases,
                                                           const FittingOptions& options);

// What a model finds in a case.
struct CaseResult {
  evaluation::ObjectCounts counts;
  evaluation::Coverage coverage;  // of the middles of what is told and there
  // Of each place the most probable candidate, told or not, but for what need not be found.
  std::vector<evaluation::Forecast> forecasts;
};
[[nodiscard]] CaseResult measure_case(const FittingCase& of, const objects::InstanceModel& model,
                                      double max_distance_m);
// The same model with the variance of the jackknife and of 2 cm for poses, which know nothing of
// what all views miss.
[[nodiscard]] objects::InstanceModel with_jackknife_alone(objects::InstanceModel model);
// What plain clustering finds (naive_objects()).
[[nodiscard]] evaluation::ObjectCounts naive_counts(const FittingCase& of, double max_distance_m);

// As instance_model.json has it.
[[nodiscard]] std::string to_json(const objects::InstanceModel& model,
                                  std::span<const FittingCase> fitted_on,
                                  const FittingOptions& options);

}  // namespace roomwise::trials
