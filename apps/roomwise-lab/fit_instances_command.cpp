#include <filesystem>
#include <numeric>

#include "commands.h"
#include "laboratory/trials/instance_fitting.h"
#include "open_home.h"
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
  const std::size_t comma = text.find(',');
  if (comma == std::string::npos) {
    return fail(
        "--case {}: expected HOME,TRUTH; TRUTH is the folder of a simulated recording or "
        "the file of what people labelled in a real one",
        text);
  }
  ROOMWISE_TRY(const home::Home home, open_home_read_only(text.substr(0, comma), context));
  return trials::fitting_case(home, {text.substr(comma + 1), {}});
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
  constexpr std::array kTruths{"thing", "unasked", "duplicate", "nothing"};
  std::string lines;
  for (const trials::FittingCase& one : cases) {
    for (std::size_t i = 0; i < one.candidate_truth.size(); ++i) {
      Json line{{"case", one.name},
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

Expected<Answer> fit(const FitInstancesOptions& options, Context& context) {
  std::vector<trials::FittingCase> cases;
  for (const std::string& text : options.cases) {
    ROOMWISE_TRY(cases.emplace_back(), read_case(text, context));
  }
  if (!options.evidence.empty()) ROOMWISE_CHECK_OK(write_evidence(options.evidence, cases));
  Answer answer;
  const char* columns = "found missed double false";
  answer.text = fmt::format("{:<32} | {:<25} | {}\n{:<32} | {} | {}\n", "", "fitted on the others",
                            "naive clustering", "left out", columns, columns);
  answer.json["left_out"] = Json::array();
  for (std::size_t held_out = 0; held_out < cases.size(); ++held_out) {
    std::vector<const trials::FittingCase*> others;
    for (std::size_t i = 0; i < cases.size(); ++i) {
      if (i != held_out) others.push_back(&cases[i]);
    }
    const trials::FittingCase& one = cases[held_out];
    ROOMWISE_TRY(const objects::InstanceModel model, fit_instances(others, options.fitting));
    const auto fitted = counts_of(one, model, options.fitting.max_distance_m);
    const auto naive = naive_counts(one, options.fitting.max_distance_m);
    answer.text += fmt::format("{:<32} | {} | {}\n", one.name, text_of(fitted), text_of(naive));
    answer.json["left_out"].push_back({{"case", one.name},
                                       {"real", one.is_real},
                                       {"min_probability", model.min_probability},
                                       {"fitted", json_of(fitted)},
                                       {"naive", json_of(naive)}});
  }
  std::vector<const trials::FittingCase*> all;
  for (const trials::FittingCase& one : cases) all.push_back(&one);
  ROOMWISE_TRY(const objects::InstanceModel model, fit_instances(all, options.fitting));
  if (!options.output.empty()) {
    ROOMWISE_CHECK_OK(write_file(options.output, trials::to_json(model, cases, options.fitting)));
    answer.text += fmt::format("fitted on all: {}\n", options.output.string());
  }
  return answer;
}

}  // namespace

void add_fit_instances_command(CLI::App& app, Context& context) {
  const auto [command, options] = add_command<FitInstancesOptions>(
      app, context, "fit-instances",
      "Fit the model that says which candidates are things, and measure it on each home left out",
      "roomwise-lab fit-instances --case office.home,tests/truth/office_walk.objects.json \\\n"
      "  --case flat.home,flat -o roomwise/objects/instances/instance_model.json\n"
      "Two homes or more; the file is compiled in by the next build.",
      fit);
  command->add_option("--case", options.cases, "HOME,TRUTH; once for each home")->required();
  command->add_option("-o,--output", options.output, "The model fitted on all; default: none");
  command->add_option("--evidence", options.evidence, "Write all candidates, a JSON object a line");
  add_setting(*command, "--weight-penalty", options.fitting.weight_penalty,
              "Ridge penalty of standardised evidence", positive());
  add_setting(*command, "--kind-penalty", options.fitting.kind_penalty,
              "Ridge penalty of the kinds' intercepts", positive());
}

}  // namespace roomwise::app
