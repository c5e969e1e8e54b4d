#include <filesystem>
#include <numeric>

#include "case_words.h"
#include "commands.h"
#include "laboratory/trials/instance_fitting.h"
#include "open_home.h"
#include "reliability_json.h"
#include "roomwise/base/file.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;

struct FitInstancesOptions {
  std::vector<std::string> cases;
  fs::path output, evidence;
  trials::FittingOptions fitting;
};

Expected<trials::FittingCase> read_case(const std::string& text, const Context& context) {
  const CaseWords words = split_case(text);
  if (words.positional.size() != 2 || words.sources.size() > 1) {
    return fail(
        "--case {}: expected HOME,TRUTH or HOME,TRUTH,source=NAME; TRUTH is the folder of a "
        "simulated recording or the file of what people labelled in a real one",
        text);
  }
  ROOMWISE_TRY(const home::Home home, open_home_read_only(words.positional[0], context));
  ROOMWISE_TRY(auto one, trials::fitting_case(home, {words.positional[1], {}}));
  if (!words.sources.empty()) one.source = *words.sources.begin();
  return one;
}

std::string text_of(const evaluation::ObjectCounts& counts) {
  return fmt::format("{:>5} {:>6} {:>6} {:>5}", counts.matched, counts.missed, counts.duplicates,
                     counts.wrong);
}
Json json_of(const evaluation::ObjectCounts& counts) {
  return {{"found", counts.matched},
          {"missed", counts.missed},
          {"double", counts.duplicates},
          {"false", counts.wrong}};
}

// A line a candidate: its case, its class, what it was and its evidence.
Expected<void> write_evidence(const fs::path& path, std::span<const trials::FittingCase> cases) {
  // In the order of trials::CandidateTruth; unasked: a thing that need not be found.
  constexpr std::array kTruths{"thing", "unasked", "duplicate", "nothing"};
  std::string lines;
  for (const trials::FittingCase& one : cases) {
    for (std::size_t i = 0; i < one.candidate_truth.size(); ++i) {
      Json line{{"case", one.name},
                {"source", one.source},
                {"real", one.is_real},
                {"class", one.weighed.candidates[i].class_name},
                {"truth", kTruths.at(static_cast<std::size_t>(one.candidate_truth[i]))}};
      for (std::size_t e = 0; e < objects::kEvidenceNames.size(); ++e) {
        line[std::string(objects::kEvidenceNames[e])] = one.weighed.evidence[i][e];
      }
      lines += line.dump() + "\n";
    }
  }
  return write_file(path, lines);
}

// What a model finds in a case whose source was left out of its fit.
struct LeftOut {
  const trials::FittingCase* of = nullptr;
  double min_probability = 0;
  trials::CaseResult fitted;
  evaluation::Coverage by_jackknife;
  evaluation::ObjectCounts naive;
};
Expected<LeftOut> leave_out(std::size_t held_out, std::span<const trials::FittingCase> cases,
                            const trials::FittingOptions& options) {
  const trials::FittingCase& one = cases[held_out];
  ROOMWISE_TRY(const objects::InstanceModel model, fit_without(one.source, cases, options));
  const double max_distance_m = options.max_distance_m;
  const auto jackknife = trials::with_jackknife_alone(model);
  return LeftOut{&one, model.min_probability, measure_case(one, model, max_distance_m),
                 measure_case(one, jackknife, max_distance_m).coverage,
                 naive_counts(one, max_distance_m)};
}

std::string text_of(const evaluation::Coverage& coverage) {
  return fmt::format("{:>9.2f} {:>10.2f}", coverage.one_sigma.value(), coverage.two_sigma.value());
}
Json json_of(const evaluation::Coverage& coverage) {
  return {{"axes", coverage.two_sigma.n},
          {"one_sigma", coverage.one_sigma.value()},
          {"two_sigma", coverage.two_sigma.value()}};
}

std::string counts_table(std::span<const LeftOut> all) {
  const char* columns = "found missed double false";
  std::string text =
      fmt::format("{:<34} | {:<25} | {}\n{:<34} | {} | {}\n", "", "fitted on the others",
                  "naive clustering", "left out", columns, columns);
  for (const LeftOut& one : all) {
    text += fmt::format("{:<34} | {} | {}\n", one.of->name, text_of(one.fitted.counts),
                        text_of(one.naive));
  }
  return text;
}

std::string coverage_table(std::span<const LeftOut> all) {
  const char* columns = "one sigma two sigmas";
  std::string text =
      fmt::format("\n{:<34} | {:<20} | {}\n{:<34} | {} | {}\n", "middles within",
                  "fitted on the others", "jackknife alone", "left out", columns, columns);
  for (const LeftOut& one : all) {
    text += fmt::format("{:<34} | {} | {}\n", one.of->name, text_of(one.fitted.coverage),
                        text_of(one.by_jackknife));
  }
  for (const bool is_real : {true, false}) {
    evaluation::Coverage fitted, by_jackknife;
    for (const LeftOut& one : all) {
      if (one.of->is_real != is_real) continue;
      fitted += one.fitted.coverage;
      by_jackknife += one.by_jackknife;
    }
    text += fmt::format("{:<34} | {} | {}\n", is_real ? "all real" : "all simulated",
                        text_of(fitted), text_of(by_jackknife));
  }
  return text;
}

std::vector<evaluation::Forecast> forecasts_of(std::span<const LeftOut> all, bool is_real) {
  std::vector<evaluation::Forecast> forecasts;
  for (const LeftOut& one : all) {
    if (one.of->is_real != is_real) continue;
    forecasts.insert(forecasts.end(), one.fitted.forecasts.begin(), one.fitted.forecasts.end());
  }
  return forecasts;
}

std::string reliability_text(std::span<const LeftOut> all) {
  std::string text = "\n";
  for (const bool is_real : {true, false}) {
    const auto curve = evaluation::reliability_curve(forecasts_of(all, is_real));
    text += fmt::format("probability, left out, {}: off by {:.3f} in the mean\n",
                        is_real ? "real" : "simulated", evaluation::calibration_error(curve));
    for (const evaluation::ReliabilityBin& bin : curve) {
      if (bin.right.n == 0) continue;
      text += fmt::format("  {:.1f} to {:.1f}: said {:.2f}, right {:.2f} ({} of {})\n", bin.low,
                          bin.high, bin.mean, bin.right.value(), bin.right.successes, bin.right.n);
    }
  }
  return text;
}

Expected<Answer> fit(const FitInstancesOptions& options, Context& context) {
  std::vector<trials::FittingCase> cases;
  for (const std::string& text : options.cases) {
    ROOMWISE_TRY(cases.emplace_back(), read_case(text, context));
  }
  if (!options.evidence.empty()) ROOMWISE_RETURN_IF_ERROR(write_evidence(options.evidence, cases));
  std::vector<LeftOut> left_out;
  Answer answer;
  answer.json["left_out"] = Json::array();
  for (std::size_t i = 0; i < cases.size(); ++i) {
    ROOMWISE_TRY(left_out.emplace_back(), leave_out(i, cases, options.fitting));
    const LeftOut& one = left_out.back();
    answer.json["left_out"].push_back({{"case", one.of->name},
                                       {"source", one.of->source},
                                       {"real", one.of->is_real},
                                       {"min_probability", one.min_probability},
                                       {"fitted", json_of(one.fitted.counts)},
                                       {"naive", json_of(one.naive)},
                                       {"coverage", json_of(one.fitted.coverage)},
                                       {"coverage_by_jackknife", json_of(one.by_jackknife)}});
  }
  answer.text = counts_table(left_out) + coverage_table(left_out) + reliability_text(left_out);
  answer.json["reliability"] = {{"real", reliability_json(forecasts_of(left_out, true))},
                                {"simulated", reliability_json(forecasts_of(left_out, false))}};
  std::vector<const trials::FittingCase*> all;
  for (const trials::FittingCase& one : cases) all.push_back(&one);
  ROOMWISE_TRY(const objects::InstanceModel model, fit_instances(all, options.fitting));
  if (!options.output.empty()) {
    ROOMWISE_RETURN_IF_ERROR(
        write_file(options.output, trials::to_json(model, cases, options.fitting)));
    answer.text += fmt::format("fitted on all: {}\n", options.output.string());
  }
  return answer;
}

}  // namespace

void add_fit_instances_command(CLI::App& app, Context& context) {
  const auto [command, options] = add_command<FitInstancesOptions>(
      app, context, "fit-instances",
      "Fit the model that says which candidates are things and how surely their middles are known, "
      "and measure it on each source left out",
      "roomwise-lab fit-instances --case office.home,tests/truth/office_walk.objects.json \\\n"
      "  --case flat.home,flat -o roomwise/objects/instances/instance_model.json\n"
      "Two places or more; the file is compiled in by the next build.",
      fit);
  command
      ->add_option("--case", options.cases,
                   "HOME,TRUTH or HOME,TRUTH,source=NAME; once for each home. Cases of one source "
                   "share pictures and are left out together; default: the home of a simulated "
                   "recording, the name of a real one")
      ->required();
  command->add_option("-o,--output", options.output, "The model fitted on all; default: none");
  command->add_option("--evidence", options.evidence, "Write all candidates, a JSON object a line");
  add_setting(*command, "--weight-penalty", options.fitting.weight_penalty,
              "Ridge penalty of standardised evidence", positive());
  add_setting(*command, "--degrees-of-freedom", options.fitting.degrees_of_freedom,
              "Of the Student's t that the error of a middle is taken for, more than 2",
              CLI::Range(2.01, 1e6));
  add_setting(*command, "--kind-penalty", options.fitting.kind_penalty,
              "Ridge penalty of the kinds' intercepts", positive());
}

}  // namespace roomwise::app
