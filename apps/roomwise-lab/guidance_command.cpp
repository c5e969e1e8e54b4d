#include <filesystem>
#include <map>

#include "commands.h"
#include "figures.h"
#include "laboratory/simulation/home/home_generator.h"
#include "laboratory/simulation/home/home_geometry.h"
#include "laboratory/simulation/home/scenario.h"
#include "laboratory/simulation/home/storeys.h"
#include "laboratory/trials/guidance/guidance_page.h"
#include "laboratory/trials/guidance/guidance_trial.h"
#include "laboratory/trials/guidance/hindrance.h"
#include "laboratory/trials/guidance/server_leader.h"
#include "laboratory/trials/truth_evaluation.h"
#include "networks.h"
#include "open_home.h"
#include "render_options.h"
#include "roomwise/base/file.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;
using trials::GuidedWalk;
using trials::TrialSummary;

struct GuidanceOptions {
  std::optional<std::uint64_t> home_seed;
  int storeys = 1;
  std::string scenario = "day";
  std::optional<std::uint64_t> scenario_seed;
  std::string guide = "session";
  std::optional<double> position_sigma_m, answered_share;
  bool has_depth = false;
  bool every_walk = false;
  fs::path furniture = kFurnitureFolder;
  // Of the walks whose pictures are drawn.
  fs::path home, recording;
  bool is_rendered = false;
  simulation::RenderOptions render{.samples_per_pixel = 1, .bake_effort = 0.4, .light_cache = {}};
  trials::ChestCameraOptions camera;
  trials::PictureTimes times;
  fs::path report;
  trials::TrialOptions trial;
};

double placed_share(const TrialSummary& summary) {
  if (summary.pictures == 0) return 0;
  return static_cast<double>(summary.placed) / static_cast<double>(summary.pictures);
}

Json contacts_of(const GuidedWalk& walk) {
  Json json = Json::array();
  for (const trials::Contact& contact : walk.contacts) {
    json.push_back({{"at_s", contact.at_s},
                    {"thing", contact.thing},
                    {"prompt", contact.prompt ? Json(walk.heard[*contact.prompt].text) : Json()},
                    {"by_prompt", contact.is_by_prompt}});
  }
  return json;
}

Json to_json(const GuidedWalk& walk) {
  return {{"goal", walk.goal.goal.noun.name},
          {"kind", trials::to_string(walk.goal.goal.kind)},
          {"offered", walk.is_offered},
          {"hindered", walk.goal.is_hindered},
          {"reachable", walk.goal.is_reachable},
          {"not_reachable", walk.is_told_not_reachable()},
          {"arrived", walk.arrived()},
          {"says_there", walk.says_there},
          {"gave_up", !walk.has_ended},
          {"to_goal_m", walk.to_goal_m},
          {"nearest_stand_m", walk.goal.nearest_stand_m},
          {"broken_off", walk.broken_off ? Json(*walk.broken_off) : Json()},
          {"pictures", walk.sightings.pictures},
          {"placed", walk.sightings.position_errors_m.size()},
          {"shortest_m", walk.goal.shortest_m},
          {"walked_m", walk.walked_m},
          {"seconds", walk.seconds},
          {"contacts", walk.contacts.size()},
          {"contacts_by_prompt", walk.contacts_by_prompt()},
          {"each_contact", contacts_of(walk)},
          {"prompts", walk.heard.size()},
          {"turns", walk.turns()},
          {"late", walk.late()},
          {"wrong", walk.wrong()},
          {"deviations", walk.deviations},
          {"lost", walk.lost},
          {"repeats", walk.repeats},
          {"blocked", walk.blocked}};
}

std::optional<double> degrees(const std::optional<double>& angle_rad) {
  return angle_rad ? std::optional(*angle_rad / guide::kDegree_rad) : std::nullopt;
}

Json by_kind(const TrialSummary& summary) {
  Json json = Json::object();
  for (const auto& [kind, of_kind] : summary.by_kind) {
    json[kind] = {{"goals", of_kind.goals}, {"arrived", of_kind.arrived}};
  }
  return json;
}

Json to_json(const TrialSummary& summary) {
  return {{"goals", summary.goals},
          {"offered", summary.offered},
          {"not_known", summary.goals - summary.offered},
          {"arrived", summary.arrived},
          {"by_kind", by_kind(summary)},
          {"says_there_wrongly", summary.says_there_wrongly},
          {"spl", summary.spl},
          {"path_over_shortest", json_or_null(summary.path_ratio)},
          {"path_over_shortest_deviation", json_or_null(summary.path_ratio_deviation)},
          {"hindered", summary.hindered},
          {"arrived_hindered", summary.arrived_hindered},
          {"without_way", summary.without_way},
          {"not_reachable", summary.not_reachable},
          {"over_stairs", summary.over_stairs},
          {"arrived_over_stairs", summary.arrived_over_stairs},
          {"seconds", json_or_null(summary.mean_s)},
          {"walked_m", summary.walked_m},
          {"contacts_per_walk", summary.contacts_per_walk},
          {"contacts", summary.contacts},
          {"contacts_by_prompt", summary.contacts_by_prompt},
          {"prompts_per_m", json_or_null(summary.prompts_per_m)},
          {"turns_per_walk", summary.turns_per_walk},
          {"prompts", summary.prompts},
          {"late", summary.late},
          {"wrong", summary.wrong},
          {"expired", summary.expired},
          {"deviations_per_walk", summary.deviations_per_walk},
          {"lost_per_walk", summary.lost_per_walk},
          {"median_to_goal_m", json_or_null(summary.median_to_goal_m)},
          {"broken_off", summary.broken_off},
          {"pictures", summary.pictures},
          {"placed_share", placed_share(summary)},
          {"position_error",
           {{"median_m", json_or_null(summary.median_position_error_m)},
            {"p95_m", json_or_null(summary.p95_position_error_m)},
            {"beyond_1m", summary.beyond_1m},
            {"median_heading_degrees", json_or_null(degrees(summary.median_heading_error_rad))},
            {"p95_heading_degrees", json_or_null(degrees(summary.p95_heading_error_rad))}}}};
}

// How a home is when it is walked.
struct Times {
  simulation::Scenario scenario = simulation::Scenario::kDay;
  trials::Hindrance hindrance = trials::Hindrance::kNone;
};

Expected<Times> parse_times(const std::string& name) {
  if (const auto hindrance = trials::parse_hindrance(name)) return Times{.hindrance = *hindrance};
  const auto scenario = simulation::parse_scenario(name);
  if (!scenario) return fail("{}, person, person-goes or closed-door", scenario.error().message);
  return Times{.scenario = *scenario};
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
  trial.goals.by_name = trial.goals.by_name || options.is_rendered;
  trial.position = trials::PositionModel::of(scenario);
  trial.position.has_depth = options.has_depth;
  trial.position.sigma_m = options.position_sigma_m.value_or(trial.position.sigma_m);
  trial.position.answered_share = options.answered_share.value_or(trial.position.answered_share);
  ROOMWISE_RETURN_IF_ERROR(trial.validate());
  return trial;
}

constexpr const char* kModelled = "positions are modelled, the map is the home's truth by day";
constexpr const char* kRendered =
    "pictures are drawn and sent to the home's computer, which has the map of a walk by day";

std::string text_of(const TrialSummary& summary, const char* what) {
  std::string kinds;
  for (const auto& [kind, of_kind] : summary.by_kind) {
    kinds += fmt::format("{}{} {} of {}", kinds.empty() ? "" : ", ", kind, of_kind.arrived,
                         of_kind.goals);
  }
  const std::string hindered =
      summary.hindered == 0
          ? ""
          : fmt::format(
                "in the way      something on {} of {} walks; {} of {} arrived; {} had no other "
                "way, of which {} were told so\n",
                summary.hindered, summary.goals, summary.arrived_hindered,
                summary.hindered - summary.without_way, summary.without_way, summary.not_reachable);
  return fmt::format(
      "arrived         {} of {} (SPL {:.2f}); {} were told so and were not there\n"
      "{}"
      "by goal         {}\n"
      "known           {} of the {} goals that the guide knows were arrived at; {} it does not "
      "know\n"
      "path            {} of the shortest, standard deviation {}; {} s\n"
      "contacts        {:.2f} a walk; {} of {} by prompts\n"
      "prompts         {} a metre; of {} {} late, {} wrong, {} never begun\n"
      "off the way     {:.2f} a walk; lost {:.2f} a walk\n"
      "places          {:.2f} of {} pictures; off by {} m (median), {} m (95 %), a metre "
      "or "
      "more {} times\n"
      "{}\n",
      summary.arrived, summary.goals, summary.spl, summary.says_there_wrongly, hindered, kinds,
      summary.arrived, summary.offered, summary.goals - summary.offered,
      text_or_none(summary.path_ratio), text_or_none(summary.path_ratio_deviation),
      text_or_none(summary.mean_s, 0), summary.contacts_per_walk, summary.contacts_by_prompt,
      summary.contacts, text_or_none(summary.prompts_per_m), summary.prompts, summary.late,
      summary.wrong, summary.expired, summary.deviations_per_walk, summary.lost_per_walk,
      placed_share(summary), summary.pictures, text_or_none(summary.median_position_error_m),
      text_or_none(summary.p95_position_error_m), summary.beyond_1m, what);
}

// What is led through, and over what map.
struct Ground {
  simulation::HomeModel by_day;
  std::uint64_t home_seed = 0;
};

Expected<Ground> ground_of(const GuidanceOptions& options,
                           const simulation::FurnitureCatalogue& catalogue) {
  if (options.recording.empty()) {
    const std::uint64_t seed = options.home_seed.value_or(0);
    ROOMWISE_TRY(simulation::HomeModel home,
                 simulation::generate_home({seed, {}, options.storeys}, catalogue));
    return Ground{std::move(home), seed};
  }
  ROOMWISE_TRY(trials::RecordedHome recorded, trials::recorded_home(options.recording, catalogue));
  return Ground{std::move(recorded.model), recorded.made_of.home ? recorded.made_of.home->seed : 0};
}

Expected<void> check_rendered(const GuidanceOptions& options, const simulation::HomeModel& home) {
  if (options.home.empty() || options.recording.empty()) {
    return fail("--rendered needs --home, and with --recording the simulated walk it was made of");
  }
  if (options.guide != "session") {
    return fail("--guide {} has no pictures; leave out --rendered", options.guide);
  }
  if (options.scenario == "person-goes") {
    return fail("--scenario person-goes has no pictures; leave out --rendered");
  }
  if (home.storeys.size() > 1) {
    return fail("{}: has {} storeys; --rendered leads over one", options.recording.string(),
                home.storeys.size());
  }
  return {};
}

std::string outcome_of(const GuidedWalk& walk) {
  return fmt::format("to the {}: {} after {:.0f} s, {} of {} pictures placed", walk.goal.word,
                     walk.arrived()                 ? "arrived"
                     : walk.broken_off              ? "broken off"
                     : walk.is_told_not_reachable() ? "not reachable, and told so"
                     : walk.says_there              ? "told so wrongly"
                     : !walk.is_offered             ? "not known"
                     : walk.has_ended               ? "not led there"
                                                    : "gave up",
                     walk.seconds, walk.sightings.position_errors_m.size(),
                     walk.sightings.pictures);
}

// One after the other: the pictures of each are drawn by all threads. Interrupted it returns those
// that were walked.
Expected<std::vector<GuidedWalk>> walk_rendered(const GuidanceOptions& options,
                                                std::span<const trials::WalkGround> grounds,
                                                const simulation::FurnitureCatalogue& catalogue,
                                                const trials::TrialOptions& trial,
                                                Context& context) {
  ROOMWISE_RETURN_IF_ERROR(check_rendered(options, grounds.front().home->model));
  ROOMWISE_TRY(const home::OpenOptions open, open_options(context));
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
  ROOMWISE_TRY(const geometry::RigidTransform truth_from_world,
               trials::truth_from_map(home, options.recording));
  ROOMWISE_TRY(const pipeline::Networks networks, load_networks({}, &home, /*also_brought=*/true));
  ROOMWISE_TRY(const objects::ObjectFinders finders, load_object_finders());
  ROOMWISE_TRY(const auto server,
               trials::GuidingServer::start(options.home, networks, finders, open));
  ThreadPool pool(context.threads);
  const auto load =
      trials::with_people([&](const std::string& model) { return catalogue.load(model); });
  const auto& frame = server->view()->map->frame;
  const auto draw = [&](const trials::WalkGround& ground, Progress& progress) {
    return simulation::Renderer::create(simulation::in_world(ground.home->model), load,
                                        options.render, pool, progress);
  };
  ROOMWISE_TRY(auto renderer, draw(grounds.front(), context.progress));
  std::vector<GuidedWalk> led;
  context.progress.begin("walking", grounds.size());
  for (std::size_t i = 0; i < grounds.size() && !context.progress.interrupted(); ++i) {
    const trials::WalkedHome& walked = *grounds[i].home;
    if (i > 0 && grounds[i - 1].home != grounds[i].home) {
      SilentProgress silent;
      ROOMWISE_TRY(renderer, draw(grounds[i], silent));
    }
    const trials::DrawnWalks walks{
        *server,        *renderer,    pool, {truth_from_world * frame.gravity_from_world.inverse()},
        options.camera, options.times};
    led.push_back(trials::lead_by_server(walks, walked, grounds[i].goal, trial, i));
    context.progress.advance(i + 1, outcome_of(led.back()));
  }
  context.progress.end();
  // What was walked counts; nothing does where nobody came to an end.
  if (led.empty()) ROOMWISE_RETURN_IF_ERROR(context.progress.check("walking"));
  return led;
}

void add_setting_of_positions(const GuidanceOptions& options, const trials::TrialOptions& trial,
                              Json& json) {
  json["position"] = options.is_rendered ? "rendered" : "modelled";
  json["map"] = options.is_rendered ? "mapped" : "truth";
  if (options.is_rendered) {
    json["camera"] = options.camera.is_phone ? "phone" : "depth";
    json["latency_s"] = options.times.latency_s;
    json["pictures_per_s"] = options.times.pictures_per_s;
    return;
  }
  json["position_model"] = {{"answered_share", trial.position.answered_share},
                            {"sigma_m", trial.position.sigma_m},
                            {"wrong_share", trial.position.wrong_share},
                            {"has_depth", trial.position.has_depth},
                            {"latency_s", trial.position.latency_s},
                            {"pictures_per_s", trial.position.pictures_per_s}};
}

Expected<Answer> run(const GuidanceOptions& options, Context& context) {
  ROOMWISE_TRY(const Times times, parse_times(options.scenario));
  ROOMWISE_TRY(trials::TrialOptions trial, complete(options, times.scenario, context.seed));
  ROOMWISE_TRY(const auto catalogue, simulation::FurnitureCatalogue::open(options.furniture));
  ROOMWISE_TRY(const Ground ground, ground_of(options, catalogue));
  trial.home_seed = ground.home_seed;
  ROOMWISE_TRY(const trials::GuidedMap map,
               trials::map_truth(ground.by_day, catalogue.models(), context.seed));
  const auto home = std::make_shared<const trials::WalkedHome>(
      simulation::apply_scenario(ground.by_day, times.scenario,
                                 options.scenario_seed.value_or(context.seed), catalogue.models()));
  ROOMWISE_TRY(const auto goals, trials::choose_goals(map, *home, trial.goals));
  const auto grounds = trials::hinder(map, home, goals, times.hindrance, trial);
  std::vector<GuidedWalk> walks(goals.size());
  if (options.is_rendered) {
    ROOMWISE_TRY(walks, walk_rendered(options, grounds, catalogue, trial, context));
  } else {
    ThreadPool pool(context.threads);
    pool.parallel_for(goals.size(), [&](std::size_t i) {
      walks[i] = trials::lead(map, *grounds[i].home, grounds[i].goal, trial, i, grounds[i].leaving);
    });
  }
  const TrialSummary summary = trials::summarise(walks);
  const char* const what = options.is_rendered ? kRendered : kModelled;
  Answer answer{text_of(summary, what), to_json(summary)};
  for (const GuidedWalk& walk : walks) {
    if (walk.broken_off) answer.text += fmt::format("broken off: {}\n", *walk.broken_off);
  }
  answer.is_good = summary.broken_off == 0;
  Json& json = answer.json;
  add_setting_of_positions(options, trial, json);
  json["home_seed"] = ground.home_seed;
  json["scenario"] = options.scenario;
  json["guide"] = trials::to_string(trial.guide);
  json["faults"] = trial.faults.scale;
  if (options.every_walk) {
    for (const GuidedWalk& walk : walks) json["walks"].push_back(to_json(walk));
  }
  if (!options.report.empty()) {
    ROOMWISE_RETURN_IF_ERROR(write_file(
        options.report,
        trials::guidance_page(
            walks, [&](std::size_t i) -> const trials::WalkedHome& { return *grounds[i].home; },
            fmt::format("Guided through home {}", ground.home_seed),
            fmt::format("In these walks {}.", what))));
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
      "roomwise-lab guidance --home-seed 221 --goals 20 --seed 1 --report walks.html\n"
      "roomwise-lab simulate --home-seed 206 --samples 1 --no-fast-turns -o walk\n"
      "roomwise map walk --home walk.home\n"
      "roomwise rooms learn --home walk.home\n"
      "roomwise-lab guidance --rendered --home walk.home --recording walk --goals 6",
      run);
  const auto seed = command->add_option("--home-seed", options.home_seed, "Which home; default: 0")
                        ->check(not_negative());
  add_setting(*command, "--storeys", options.storeys, "Of the home", CLI::Range(1, 2));
  command
      ->add_option("--recording", options.recording,
                   "Instead: the home of this simulated walk, a folder that simulate wrote")
      ->excludes(seed);
  command->add_flag("--by-name", options.trial.goals.by_name,
                    "Only goals that are asked for by name: rooms, and things that a home has a "
                    "word for and of which a room has one");
  const auto rendered = command->add_flag(
      "--rendered", options.is_rendered,
      "Draw what the walker's camera sees and send it to the home's computer, which "
      "leads them over the map that it has; with --home and --recording, by name");
  command->add_option("--home", options.home, "Home that was mapped from the recording")
      ->needs(rendered);
  command
      ->add_flag("--phone", options.camera.is_phone,
                 "Of --rendered: pictures of a phone, in colour alone, of an unknown lens; "
                 "else of a calibrated camera with depth")
      ->needs(rendered);
  add_setting(*command, "--pictures-per-second", options.times.pictures_per_s, "Of --rendered",
              positive())
      ->needs(rendered);
  add_setting(*command, "--latency", options.times.latency_s,
              "Of --rendered: from a picture until its answer is heard, s", CLI::Range(0.0, 10.0))
      ->needs(rendered);
  add_setting(*command, "--goals", options.trial.goals.goals, "How many walks", positive());
  add_setting(*command, "--scenario", options.scenario,
              "How the home is when it is walked: day, evening, night, moved or moved-night; by "
              "day, and on each way person: somebody stands there, person-goes: and goes after a "
              "while, or closed-door: a door is shut and does not open. The map is made by day");
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
      ->check(positive())
      ->excludes(rendered);
  command
      ->add_option("--answered", options.answered_share,
                   "Share of pictures that are placed; default: as measured by scenario")
      ->check(CLI::Range(0.01, 1.0))
      ->excludes(rendered);
  command
      ->add_flag("--depth", options.has_depth,
                 "The walker's camera measures depth and sees what stands in the way; else it is a "
                 "phone's. Of modelled positions")
      ->excludes(rendered);
  command->add_flag("--walks", options.every_walk, "With each walk in the JSON");
  command->add_option("--report", options.report, "Page to write that shows the walks (.html)");
  add_render_options(*command, options.render, options.furniture);
}

}  // namespace roomwise::app
