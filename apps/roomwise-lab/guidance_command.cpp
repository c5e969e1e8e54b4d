#include <filesystem>
#include <map>

#include "commands.h"
#include "laboratory/simulation/home/home_generator.h"
#include "laboratory/simulation/home/home_geometry.h"
#include "laboratory/simulation/home/scenario.h"
#include "laboratory/trials/guidance/guidance_page.h"
#include "laboratory/trials/guidance/guidance_trial.h"
#include "render_options.h"
#include "roomwise/base/file.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;
using trials::GuidedWalk;
using trials::TrialSummary;

struct GuidanceOptions {
  std::uint64_t home_seed = 0;
  int storeys = 1;
  std::string scenario = "day";
  std::optional<std::uint64_t> scenario_seed;
  std::string guide = "session";
  std::optional<double> position_sigma_m, answered_share;
  bool every_walk = false;
  fs::path furniture = kFurnitureFolder;
  fs::path report;
  trials::TrialOptions trial;
};

Json to_json(const GuidedWalk& walk) {
  return {{"goal", walk.goal.goal.noun.name},
          {"offered", walk.is_offered},
          {"arrived", walk.arrived()},
          {"says_there", walk.says_there},
          {"gave_up", !walk.has_ended},
          {"to_goal_m", walk.to_goal_m},
          {"nearest_stand_m", walk.goal.nearest_stand_m},
          {"shortest_m", walk.goal.shortest_m},
          {"walked_m", walk.walked_m},
          {"seconds", walk.seconds},
          {"contacts", walk.contacts},
          {"prompts", walk.heard.size()},
          {"late", walk.late()},
          {"wrong", walk.wrong()},
          {"deviations", walk.deviations},
          {"lost", walk.lost},
          {"repeats", walk.repeats},
          {"blocked", walk.blocked}};
}

Json to_json(const TrialSummary& summary) {
  return {{"goals", summary.goals},
          {"offered", summary.offered},
          {"arrived", summary.arrived},
          {"says_there_wrongly", summary.says_there_wrongly},
          {"spl", summary.spl},
          {"path_over_shortest", summary.path_ratio},
          {"path_over_shortest_deviation", summary.path_ratio_deviation},
          {"over_stairs", summary.over_stairs},
          {"arrived_over_stairs", summary.arrived_over_stairs},
          {"seconds", summary.mean_s},
          {"walked_m", summary.walked_m},
          {"contacts_per_walk", summary.contacts_per_walk},
          {"prompts_per_m", summary.prompts_per_m},
          {"prompts", summary.prompts},
          {"late", summary.late},
          {"wrong", summary.wrong},
          {"expired", summary.expired},
          {"deviations_per_walk", summary.deviations_per_walk},
          {"lost_per_walk", summary.lost_per_walk},
          {"median_to_goal_m", summary.median_to_goal_m}};
}

Expected<trials::TrialOptions> complete(const GuidanceOptions& options,
                                        simulation::Scenario scenario, std::uint64_t seed) {
  trials::TrialOptions trial = options.trial;
  trial.seed = trial.goals.seed = seed;
  static const std::map<std::string, trials::Guide> guides{{"session", trials::Guide::kSession},
                                                           {"list", trials::Guide::kList},
                                                           {"list-once", trials::Guide::kListOnce}};
  const auto guide = guides.find(options.guide);
  if (guide == guides.end()) {
    return fail("'{}' is no guide; expected session, list or list-once", options.guide);
  }
  trial.guide = guide->second;
  trial.position = trials::PositionModel::of(scenario);
  trial.position.sigma_m = options.position_sigma_m.value_or(trial.position.sigma_m);
  trial.position.answered_share = options.answered_share.value_or(trial.position.answered_share);
  ROOMWISE_CHECK_OK(trial.validate());
  return trial;
}

std::string text_of(const TrialSummary& summary) {
  return fmt::format(
      "arrived         {} of {} (SPL {:.2f}); {} were told so and were not there\n"
      "path            {:.2f} of the shortest, standard deviation {:.2f}; {:.0f} s\n"
      "contacts        {:.2f} a walk\n"
      "prompts         {:.2f} a metre; of {} {} late, {} wrong, {} never begun\n"
      "off the way     {:.2f} a walk; lost {:.2f} a walk\n"
      "positions are modelled, the map is the home's truth by day\n",
      summary.arrived, summary.goals, summary.spl, summary.says_there_wrongly, summary.path_ratio,
      summary.path_ratio_deviation, summary.mean_s, summary.contacts_per_walk,
      summary.prompts_per_m, summary.prompts, summary.late, summary.wrong, summary.expired,
      summary.deviations_per_walk, summary.lost_per_walk);
}

Expected<Answer> run(const GuidanceOptions& options, Context& context) {
  ROOMWISE_TRY(const simulation::Scenario scenario, simulation::parse_scenario(options.scenario));
  ROOMWISE_TRY(const trials::TrialOptions trial, complete(options, scenario, context.seed));
  ROOMWISE_TRY(const auto catalogue, simulation::FurnitureCatalogue::open(options.furniture));
  ROOMWISE_TRY(const simulation::HomeModel by_day,
               simulation::generate_home({options.home_seed, {}, options.storeys}, catalogue));
  ROOMWISE_TRY(const trials::GuidedMap map,
               trials::map_truth(by_day, catalogue.models(), context.seed));
  const trials::WalkedHome home(simulation::apply_scenario(
      by_day, scenario, options.scenario_seed.value_or(context.seed), catalogue.models()));
  ROOMWISE_TRY(const auto goals, trials::choose_goals(map, home, trial.goals));
  std::vector<GuidedWalk> walks(goals.size());
  ThreadPool pool(context.threads);
  pool.parallel_for(goals.size(),
                    [&](std::size_t i) { walks[i] = trials::lead(map, home, goals[i], trial, i); });
  const TrialSummary summary = trials::summarise(walks);
  Answer answer{text_of(summary), to_json(summary)};
  Json& json = answer.json;
  json["position"] = "modelled";
  json["map"] = "truth";
  json["position_model"] = {{"answered_share", trial.position.answered_share},
                            {"sigma_m", trial.position.sigma_m},
                            {"wrong_share", trial.position.wrong_share},
                            {"latency_s", trial.position.latency_s},
                            {"pictures_per_s", trial.position.pictures_per_s}};
  json["home_seed"] = options.home_seed;
  json["scenario"] = options.scenario;
  json["guide"] = trials::to_string(trial.guide);
  json["faults"] = trial.faults.scale;
  if (options.every_walk) {
    for (const GuidedWalk& walk : walks) json["walks"].push_back(to_json(walk));
  }
  if (!options.report.empty()) {
    ROOMWISE_CHECK_OK(write_file(
        options.report,
        trials::guidance_page(home, walks, fmt::format("Guided through home {}", options.home_seed),
                              "Positions are modelled; the map is the home's truth by day.")));
    answer.text += fmt::format("wrote {}\n", options.report.string());
    json["report"] = options.report.string();
  }
  return answer;
}

}  // namespace

void add_guidance_command(CLI::App& app, Context& context) {
  const auto [command, options] = add_command<GuidanceOptions>(
      app, context, "guidance",
      "Lead simulated people who veer and miscount through a simulated home by what they hear",
      "roomwise-lab guidance --home-seed 221 --goals 20 --seed 1 --report walks.html", run);
  add_setting(*command, "--home-seed", options.home_seed, "Which home");
  add_setting(*command, "--storeys", options.storeys, "Of the home", CLI::Range(1, 2));
  add_setting(*command, "--goals", options.trial.goals.goals, "How many walks", positive());
  add_setting(*command, "--scenario", options.scenario,
              "How the home is when it is walked: day, evening, night, moved or moved-night; the "
              "map is made by day");
  command->add_option("--scenario-seed", options.scenario_seed, "What is moved; default: --seed")
      ->check(not_negative());
  add_setting(*command, "--faults", options.trial.faults.scale,
              "How much people err: 0 not at all, 1 as they do", CLI::Range(0.0, 3.0));
  add_setting(
      *command, "--guide", options.guide,
      "session; list: the list of legs of \"way to\", asked for again at its end; list-once");
  command
      ->add_option("--position-sigma", options.position_sigma_m,
                   "Standard deviation of positions, m; default: as measured")
      ->check(positive());
  command
      ->add_option("--answered", options.answered_share,
                   "Share of pictures that are placed; default: as measured by scenario")
      ->check(CLI::Range(0.01, 1.0));
  command->add_flag("--walks", options.every_walk, "With each walk in the JSON");
  command->add_option("--report", options.report, "Page to write that shows the walks (.html)");
  add_furniture_option(*command, options.furniture);
}

}  // namespace roomwise::app
