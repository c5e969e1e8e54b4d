#include <array>
#include <filesystem>

#include "command_run.h"
#include "commands.h"
#include "laboratory/trials/room_fitting.h"
#include "networks.h"
#include "open_home.h"
#include "roomwise/base/file.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;

struct FitRoomsOptions {
  fs::path study, evidence, output;
  trials::RoomFittingOptions fitting;
  std::size_t max_elsewhere = 300;
  NetworkOptions networks;
};

// A line a case.
Expected<void> write_evidence(const fs::path& path, std::span<const trials::RoomCase> cases) {
  std::string lines;
  for (const trials::RoomCase& one : cases) lines += trials::evidence_json(one) + "\n";
  return write_file(path, lines);
}

Expected<std::vector<trials::RoomCase>> look(const FitRoomsOptions& options, Context& context) {
  ROOMWISE_TRY(const auto study, trials::read_room_study(options.study));
  std::vector<trials::RoomCase> cases;
  CommandRun run(context);
  for (const trials::RoomCaseFiles& files : study) {
    ROOMWISE_TRY(const home::Home home, open_home_read_only(files.home, context));
    ROOMWISE_TRY(const pipeline::Networks networks,
                 load_networks(options.networks, &home, /*also_brought=*/true));
    ROOMWISE_TRY(cases.emplace_back(),
                 trials::room_case(files, home, networks, options.max_elsewhere, run));
  }
  if (!options.evidence.empty()) ROOMWISE_RETURN_IF_ERROR(write_evidence(options.evidence, cases));
  return cases;
}

// On every case but those of a source.
Expected<rooms::RoomModel> fit_others(std::span<const trials::RoomCase> cases,
                                      const std::string& source, const std::string& network,
                                      const trials::RoomFittingOptions& options) {
  std::vector<const trials::RoomCase*> others;
  for (const trials::RoomCase& one : cases) {
    if (one.source != source) others.push_back(&one);
  }
  return fit_rooms(others, network, options);
}

double share(std::size_t part, std::size_t whole) {
  return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
}

// What each case makes of a model that was fitted without its source.
Expected<void> left_out(std::span<const trials::RoomCase> cases, const std::string& network,
                        const trials::RoomFittingOptions& options, Answer& answer) {
  answer.text += fmt::format(
      "{}, each source left out:\n{:18} {:>5} {:>23} {:>13} {:>13} {:>15}\n{:18} {:>5} {:>7} {:>6} "
      "{:>7} "
      "{:>5} {:>6} {:>6} {:>6} {:>6} {:>7}\n",
      network.empty() ? "any network" : network, "", "", "best room right", "named", "one of two",
      "elsewhere", "", "n", "default", "paper", "similar", "share", "right", "share", "right",
      "named", "of two");
  for (const trials::RoomCase& one : cases) {
    ROOMWISE_TRY(const rooms::RoomModel model, fit_others(cases, one.source, network, options));
    const trials::RoomCounts counts = counts_of(one, model);
    const std::array<std::pair<const char*, double>, 9> shares = {
        {{"best_right", share(counts.best_right, counts.known)},
         {"paper_right", share(counts.regression_right, counts.known)},
         {"similarity_right", share(counts.similarity_right, counts.known)},
         {"named", share(counts.named, counts.known)},
         {"named_right", share(counts.named_right, counts.named)},
         {"either", share(counts.either, counts.known)},
         {"either_right", share(counts.either_right, counts.either)},
         {"elsewhere_named", share(counts.elsewhere_named, counts.elsewhere)},
         {"elsewhere_either", share(counts.elsewhere_either, counts.elsewhere)}}};
    Json json{{"network", network},   {"case", one.name},
              {"source", one.source}, {"real", one.is_real},
              {"n", counts.known},    {"min_probability", model.min_probability}};
    answer.text += fmt::format("{:18} {:5}", one.name, counts.known);
    for (const auto& [name, value] : shares) {
      json[name] = value;
      answer.text += fmt::format(" {:6.3f}", value);
    }
    answer.text += "\n";
    answer.json["left_out"].push_back(std::move(json));
  }
  return {};
}

Expected<Answer> fit(const FitRoomsOptions& options, Context& context) {
  if (options.study.empty() && options.evidence.empty()) {
    return fail("give --study, or the --evidence that an earlier one wrote");
  }
  ROOMWISE_TRY(const auto cases, options.study.empty()
                                     ? trials::read_room_evidence(options.evidence)
                                     : look(options, context));
  if (cases.empty()) return fail("there is no case to fit to");
  Answer answer;
  std::vector<rooms::RoomModel> models;
  for (const std::string& network : {cases.front().network, std::string()}) {
    ROOMWISE_RETURN_IF_ERROR(left_out(cases, network, options.fitting, answer));
    ROOMWISE_TRY(models.emplace_back(), fit_others(cases, {}, network, options.fitting));
  }
  if (!options.output.empty()) {
    ROOMWISE_RETURN_IF_ERROR(
        write_file(options.output, trials::to_json(models, cases, options.fitting)));
    answer.text += fmt::format("fitted on all: {}\n", options.output.string());
  }
  return answer;
}

}  // namespace

void add_fit_rooms_command(CLI::App& app, Context& context) {
  const auto [command, options] = add_command<FitRoomsOptions>(
      app, context, "fit-rooms",
      "Fit what decides about rooms, and measure it on each home left out",
      "roomwise-lab fit-rooms --study rooms.json -o roomwise/rooms/recognition/room_model.json",
      fit);
  command->add_option("--study", options.study, "The homes and what they are tested on");
  command->add_option("--evidence", options.evidence,
                      "Write what was seen, a line of JSON a home; without --study it is read");
  command->add_option("-o,--output", options.output, "The model fitted on all; default: none");
  add_setting(*command, "--min-precision", options.fitting.min_precision,
              "Share of the named pictures that is to be right", CLI::Range(0.5, 1.0));
  add_setting(*command, "--max-elsewhere-named", options.fitting.max_elsewhere_named,
              "Share of the pictures of other places that may get a name", CLI::Range(0.0, 1.0));
  add_precision_option(*command, options.networks);
}

}  // namespace roomwise::app
