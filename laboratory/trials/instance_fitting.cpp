#include "laboratory/trials/instance_fitting.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>

#include "laboratory/trials/logistic_regression.h"
#include "laboratory/trials/naive_objects.h"
#include "laboratory/trials/variance_regression.h"
#include "roomwise/objects/kinds/kinds.h"
#include "roomwise/pipeline/objects/stored_detections.h"

namespace roomwise::trials {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using objects::kEvidenceNames;

constexpr double kTouches_m = 0.15;  // a candidate's middle from the box of what it may be

bool may_be_called(const evaluation::TrueObject& thing, const std::string& name) {
  return thing.kind == name || thing.also_called.contains(name);
}

double sum_of_scores(const objects::Candidate& candidate,
                     std::span<const objects::WorldObservation> observations) {
  return std::accumulate(candidate.group.begin(), candidate.group.end(), 0.0,
                         [&](double sum, std::size_t i) {
                           return sum + static_cast<double>(observations[i].detection->score);
                         });
}

// The candidates that most speaks for choose first; each is the nearest thing of its name that is
// free and that it touches.
void find_truth(FittingCase& of) {
  const objects::WeighedCandidates& weighed = of.weighed;
  const std::span<const evaluation::TrueObject> truth = of.truth;
  std::vector<std::size_t> order(weighed.candidates.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::ranges::greater(), [&](std::size_t i) {
    return sum_of_scores(weighed.candidates[i], weighed.observations);
  });
  std::vector<CandidateTruth>& result = of.candidate_truth;
  result.assign(order.size(), CandidateTruth::kNothing);
  of.thing_of.assign(order.size(), std::nullopt);
  std::vector<bool> used(truth.size());
  for (const std::size_t i : order) {
    const objects::Candidate& candidate = weighed.candidates[i];
    if (const objects::Kind* kind = objects::find_kind(candidate.class_name);
        kind != nullptr && !kind->is_spoken_of) {
      result[i] = CandidateTruth::kUnasked;
      continue;
    }
    double nearest_m = std::numeric_limits<double>::infinity();
    std::optional<std::size_t> nearest;
    bool is_another = false;
    for (std::size_t t = 0; t < truth.size(); ++t) {
      if (!may_be_called(truth[t], candidate.class_name)) continue;
      const double reach_m = kTouches_m + 0.25 * truth[t].box.size_m.maxCoeff();
      const double from_box_m = std::min(truth[t].box.distance_m(candidate.middle_world),
                                         truth[t].box.distance_m(candidate.box_world.center()));
      if (from_box_m > reach_m) continue;
      const double from_middle_m = (truth[t].box.center() - candidate.box_world.center()).norm();
      if (used[t]) {
        is_another = true;
      } else if (from_middle_m < nearest_m) {
        nearest_m = from_middle_m;
        nearest = t;
      }
    }
    if (nearest) {
      used[*nearest] = true;
      of.thing_of[i] = nearest;
      result[i] = truth[*nearest].is_expected ? CandidateTruth::kThing : CandidateTruth::kUnasked;
    } else if (is_another) {
      result[i] = CandidateTruth::kDuplicate;
    } else if (std::ranges::any_of(truth, [&](const evaluation::TrueObject& thing) {
                 return thing.holds.contains(candidate.class_name) &&
                        thing.box.distance_m(candidate.box_world.center()) <= kTouches_m;
               })) {
      result[i] = CandidateTruth::kUnasked;
    }
  }
}

// What is learned from: a row a candidate, standardised evidence and then the kinds.
struct Samples {
  MatrixXd rows;
  VectorXd is_thing, weights;
  VectorXd mean, scale;  // of the evidence
  std::vector<std::string> kinds;
};

bool is_learned_from(CandidateTruth truth) {
  return truth != CandidateTruth::kUnasked;
}

std::size_t learned_from(const FittingCase& of) {
  return static_cast<std::size_t>(std::ranges::count_if(of.candidate_truth, is_learned_from));
}

std::size_t true_things(const FittingCase& of) {
  return static_cast<std::size_t>(
      std::ranges::count_if(of.thing_of, [](const auto& thing) { return thing.has_value(); }));
}

// Of what is learned from, so that real and simulated ones weigh the same together, and 1 in the
// mean.
struct SortWeights {
  double real = 1, simulated = 1;
  [[nodiscard]] double of(const FittingCase& one) const { return one.is_real ? real : simulated; }
};
SortWeights sort_weights(std::span<const FittingCase* const> cases,
                         std::size_t (*count)(const FittingCase&)) {
  double real = 0, simulated = 0;
  for (const FittingCase* one : cases) {
    (one->is_real ? real : simulated) += static_cast<double>(count(*one));
  }
  if (real == 0 || simulated == 0) return {};
  return {(real + simulated) / (2 * real), (real + simulated) / (2 * simulated)};
}

Samples samples_of(std::span<const FittingCase* const> cases) {
  Samples samples;
  std::map<std::string, int> places;
  int count = 0;
  for (const FittingCase* one : cases) {
    for (std::size_t i = 0; i < one->candidate_truth.size(); ++i) {
      if (!is_learned_from(one->candidate_truth[i])) continue;
      ++count;
      places.emplace(one->weighed.candidates[i].class_name, 0);
    }
  }
  const int numbers = static_cast<int>(kEvidenceNames.size());
  for (auto& [kind, place] : places) {
    place = numbers + static_cast<int>(samples.kinds.size());
    samples.kinds.push_back(kind);
  }
  samples.rows = MatrixXd::Zero(count, numbers + static_cast<int>(places.size()));
  samples.is_thing = VectorXd::Zero(count);
  samples.weights = VectorXd::Zero(count);
  const SortWeights sort = sort_weights(cases, learned_from);
  int row = 0;
  for (std::size_t c = 0; c < cases.size(); ++c) {
    const FittingCase& one = *cases[c];
    for (std::size_t i = 0; i < one.candidate_truth.size(); ++i) {
      if (!is_learned_from(one.candidate_truth[i])) continue;
      for (int e = 0; e < numbers; ++e) {
        samples.rows(row, e) = one.weighed.evidence[i][static_cast<std::size_t>(e)];
      }
      samples.rows(row, places.at(one.weighed.candidates[i].class_name)) = 1;
      samples.is_thing[row] = one.candidate_truth[i] == CandidateTruth::kThing ? 1 : 0;
      samples.weights[row] = sort.of(one);
      ++row;
    }
  }
  const MatrixXd evidence = samples.rows.leftCols(numbers);
  samples.mean = evidence.transpose() * samples.weights / count;
  samples.scale = VectorXd::Ones(numbers);
  for (int e = 0; e < numbers; ++e) {
    const VectorXd off = evidence.col(e).array() - samples.mean[e];
    const double deviation = std::sqrt(off.cwiseAbs2().dot(samples.weights) / count);
    if (deviation > 1e-9) samples.scale[e] = deviation;
    samples.rows.col(e) = off / samples.scale[e];
  }
  return samples;
}

// The bias first, then a number a column.
VectorXd regress(const Samples& samples, const FittingOptions& options) {
  constexpr double kBiasPenalty = 1e-6;
  const Eigen::Index columns = samples.rows.cols();
  const auto numbers = static_cast<Eigen::Index>(kEvidenceNames.size());
  MatrixXd rows(samples.rows.rows(), columns + 1);
  rows << VectorXd::Ones(samples.rows.rows()), samples.rows;
  VectorXd penalty = VectorXd::Constant(columns + 1, options.weight_penalty);
  penalty[0] = kBiasPenalty;
  penalty.tail(columns - numbers).setConstant(options.kind_penalty);
  return logistic_regression(rows, samples.is_thing, samples.weights, penalty);
}

double f1_of(const evaluation::ObjectCounts& counts) {
  const auto matched = static_cast<double>(counts.matched);
  const auto wrong = static_cast<double>(counts.missed + counts.duplicates + counts.wrong);
  return matched == 0 ? 0 : 2 * matched / (2 * matched + wrong);
}

// Instances of a case, in the world, beside what is there.
struct Comparison {
  std::vector<geometry::OrientedBox> boxes_world;
  evaluation::ObjectErrors errors;
};
evaluation::ObjectErrors errors_of(const FittingCase& of,
                                   std::span<const evaluation::FoundObject> found,
                                   double max_distance_m) {
  return evaluation::object_errors(of.truth, found, max_distance_m)
      .value_or(evaluation::ObjectErrors{});
}
Comparison compare(const FittingCase& of, std::span<const objects::Instance> instances,
                   double max_distance_m) {
  std::map<std::uint64_t, const objects::ObservedKeyframe*> keyframes;
  for (const objects::ObservedKeyframe& keyframe : of.keyframes) {
    keyframes[keyframe.keyframe_id] = &keyframe;
  }
  Comparison result;
  std::vector<evaluation::FoundObject> found;
  for (const objects::Instance& instance : instances) {
    const auto& pose = keyframes.at(instance.keyframe_id)->world_from_camera;
    result.boxes_world.push_back(instance.box_world(pose));
    found.push_back({instance.name, result.boxes_world.back().center()});
  }
  result.errors = errors_of(of, found, max_distance_m);
  return result;
}

std::vector<objects::Instance> all_instances(const FittingCase& of,
                                             const objects::InstanceModel& model) {
  objects::InstanceOptions options;
  options.min_probability = 0;
  return believed_instances(of.weighed, of.keyframes, model, options);
}

// The one with the best F1, of all real and of all simulated cases in equal shares.
double best_threshold(std::span<const FittingCase* const> cases,
                      const objects::InstanceModel& model, double max_distance_m) {
  std::vector<std::vector<objects::Instance>> all;
  for (const FittingCase* one : cases) all.push_back(all_instances(*one, model));
  double best = 0.5, most = -1;
  for (int percent = 10; percent <= 90; percent += 2) {
    const double threshold = percent / 100.0;
    evaluation::ObjectCounts real, simulated;
    for (std::size_t c = 0; c < cases.size(); ++c) {
      std::vector<objects::Instance> believed;
      std::ranges::copy_if(all[c], std::back_inserter(believed),
                           [&](const auto& instance) { return instance.probability >= threshold; });
      (cases[c]->is_real ? real : simulated) +=
          compare(*cases[c], believed, max_distance_m).errors.all;
    }
    const double both = f1_of(real) + f1_of(simulated);
    if (both <= most) continue;
    most = both;
    best = threshold;
  }
  return best;
}

// Of the true things among the candidates, an axis of a box a row.
objects::VarianceTerms fit_variance(std::span<const FittingCase* const> cases,
                                    double degrees_of_freedom) {
  std::vector<objects::VarianceTerms> terms;
  std::vector<double> errors_m, weights;
  const SortWeights sort = sort_weights(cases, true_things);
  for (const FittingCase* one : cases) {
    for (std::size_t i = 0; i < one->thing_of.size(); ++i) {
      if (!one->thing_of[i]) continue;
      const objects::Candidate& candidate = one->weighed.candidates[i];
      const Eigen::Vector3d error_m =
          candidate.box_world.world_from_box.inverse() * one->truth[*one->thing_of[i]].box.center();
      const auto along = variance_terms(candidate);
      terms.insert(terms.end(), along.begin(), along.end());
      errors_m.insert(errors_m.end(), error_m.begin(), error_m.end());
      weights.insert(weights.end(), 3, sort.of(*one));
    }
  }
  using Rows =
      Eigen::Matrix<double, Eigen::Dynamic, objects::kVarianceNames.size(), Eigen::RowMajor>;
  const auto count = static_cast<Eigen::Index>(errors_m.size());
  const VectorXd fitted = variance_regression(
      Eigen::Map<const Rows>(terms.front().data(), count, objects::kVarianceNames.size()),
      Eigen::Map<const VectorXd>(errors_m.data(), count),
      Eigen::Map<const VectorXd>(weights.data(), count), degrees_of_freedom);
  objects::VarianceTerms result{};
  std::ranges::copy(fitted, result.begin());
  return result;
}

double rounded(double value, double parts = 1e4) {
  return std::round(value * parts) / parts;
}

}  // namespace

FittingCase fitting_case(const std::string& name, bool is_real,
                         std::vector<objects::ObservedKeyframe> keyframes,
                         std::vector<evaluation::TrueObject> truth) {
  FittingCase result{name, name, is_real, std::move(keyframes), {}, std::move(truth), {}, {}};
  result.weighed = weigh_candidates(result.keyframes, fit_ground_plane(result.keyframes), {});
  find_truth(result);
  return result;
}

Expected<FittingCase> fitting_case(const home::Home& home, const ObjectTruthFiles& truth) {
  ROOMWISE_TRY(HomeTruth there, home_truth(home, truth));
  const geometry::RigidTransform world_from_truth = there.truth_from_world.inverse();
  for (evaluation::TrueObject& thing : there.things) {
    thing.box.world_from_box = world_from_truth * thing.box.world_from_box;
  }
  ROOMWISE_TRY(auto components, pipeline::observed_keyframes(home));
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  std::erase_if(components[0], [&](const auto& keyframe) {
    return keyframes.at(keyframe.keyframe_id).recording != there.walk;
  });
  if (components[0].empty()) return fail("{}: no finder looked at its key-frames", home.file());
  FittingCase result = fitting_case(std::filesystem::path(home.file()).stem().string(),
                                    !std::filesystem::is_directory(truth.truth),
                                    std::move(components.at(0)), std::move(there.things));
  ROOMWISE_TRY(result.source, place_of(truth.truth));
  return result;
}

Expected<objects::InstanceModel> fit_instances(std::span<const FittingCase* const> cases,
                                               const FittingOptions& options) {
  const Samples samples = samples_of(cases);
  const double things = samples.is_thing.sum();
  if (things == 0 || things == static_cast<double>(samples.is_thing.size())) {
    return fail("{} of {} candidates are things; a model needs both, things and what is none",
                things, samples.is_thing.size());
  }
  const VectorXd weights = regress(samples, options);
  objects::InstanceModel model;
  model.bias = weights[0];
  for (std::size_t e = 0; e < kEvidenceNames.size(); ++e) {
    const auto at = static_cast<Eigen::Index>(e);
    model.weights[e] = weights[at + 1] / samples.scale[at];
    model.bias -= model.weights[e] * samples.mean[at];
  }
  for (std::size_t k = 0; k < samples.kinds.size(); ++k) {
    model.bias_of_kind[samples.kinds[k]] =
        weights[static_cast<Eigen::Index>(kEvidenceNames.size() + 1 + k)];
  }
  model.min_probability = best_threshold(cases, model, options.max_distance_m);
  model.variance_weights = fit_variance(cases, options.degrees_of_freedom);
  return model;
}

Expected<objects::InstanceModel> fit_without(const std::string& source,
                                             std::span<const FittingCase> cases,
                                             const FittingOptions& options) {
  std::vector<const FittingCase*> others;
  for (const FittingCase& one : cases) {
    if (one.source != source) others.push_back(&one);
  }
  if (others.empty()) return fail("all cases are of the source {}; give others, too", source);
  return fit_instances(others, options);
}

CaseResult measure_case(const FittingCase& of, const objects::InstanceModel& model,
                        double max_distance_m) {
  CaseResult result;
  const auto told = believed_instances(of.weighed, of.keyframes, model, {});
  const Comparison of_told = compare(of, told, max_distance_m);
  result.counts = of_told.errors.all;
  for (const evaluation::ObjectMatch& match : of_told.errors.matches) {
    result.coverage.add(of_told.boxes_world[match.found].world_from_box.inverse() *
                            of.truth[match.truth].box.center(),
                        told[match.found].sigma_m);
  }
  const auto all = all_instances(of, model);
  std::vector<double> probabilities;
  for (const objects::Instance& one : all) probabilities.push_back(one.probability);
  result.forecasts =
      evaluation::forecasts_of(compare(of, all, max_distance_m).errors, of.truth, probabilities);
  return result;
}

objects::InstanceModel with_jackknife_alone(objects::InstanceModel model) {
  constexpr double kPoses_m2 = 0.02 * 0.02;
  for (std::size_t i = 0; i < objects::kVarianceNames.size(); ++i) {
    const std::string_view name = objects::kVarianceNames[i];
    model.variance_weights[i] = name == "jackknife" ? 1 : name == "constant" ? kPoses_m2 : 0;
  }
  return model;
}

evaluation::ObjectCounts naive_counts(const FittingCase& of, double max_distance_m) {
  return errors_of(of, naive_objects(of.keyframes), max_distance_m).all;
}

std::string to_json(const objects::InstanceModel& model, std::span<const FittingCase> fitted_on,
                    const FittingOptions& options) {
  using Json = nlohmann::ordered_json;
  constexpr double kVarianceParts = 1e6;
  Json cases = Json::array(), weights = Json::object(), of_kind = Json::object();
  Json variance = Json::object();
  for (const FittingCase& one : fitted_on) {
    cases.push_back({{"name", one.name},
                     {"source", one.source},
                     {"real", one.is_real},
                     {"candidates", one.candidate_truth.size()},
                     {"things", std::ranges::count(one.candidate_truth, CandidateTruth::kThing)},
                     {"middles", true_things(one)}});
  }
  for (std::size_t e = 0; e < kEvidenceNames.size(); ++e) {
    weights[std::string(kEvidenceNames[e])] = rounded(model.weights[e]);
  }
  for (const auto& [kind, bias] : model.bias_of_kind) of_kind[kind] = rounded(bias);
  for (std::size_t i = 0; i < objects::kVarianceNames.size(); ++i) {
    variance[std::string(objects::kVarianceNames[i])] =
        rounded(model.variance_weights[i], kVarianceParts);
  }
  return Json{
             {"about",
              "Logistic regression of whether a candidate is a thing and is called so, and of what "
              "the variance of its middle is a sum, written by roomwise-lab fit-instances; see "
              "docs/objects.md."},
             {"fitted_on", std::move(cases)},
             {"weight_penalty", options.weight_penalty},
             {"kind_penalty", options.kind_penalty},
             {"bias", rounded(model.bias)},
             {"min_probability", model.min_probability},
             {"weights", std::move(weights)},
             {"of_kind", std::move(of_kind)},
             {"degrees_of_freedom", options.degrees_of_freedom},
             {"variance", std::move(variance)}}
             .dump(1) +
         "\n";
}

}  // namespace roomwise::trials
