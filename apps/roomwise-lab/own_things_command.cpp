#include <algorithm>

#include "camera_option.h"
#include "commands.h"
#include "laboratory/trials/own_things/own_things_trial.h"
#include "networks.h"
#include "render_options.h"
#include "roomwise/base/file.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;

struct OwnThingsOptions {
  std::vector<std::string> recordings;
  fs::path photos, furniture = kFurnitureFolder, compared, output;
  std::size_t photo_things = 10, rendered_things = 20;
  trials::OwnThingsOptions trial;
};

// FOLDER[,LABELS[,SECONDS[,CAMERA]]]
Expected<trials::LabelledRecording> parse_recording(const std::string& text) {
  std::vector<std::string> parts{""};
  for (const char letter : text) {
    if (letter == ',') {
      parts.emplace_back();
    } else {
      parts.back() += letter;
    }
  }
  parts.resize(4);
  trials::LabelledRecording one{parts[0], parts[1], {}, {}};
  ROOMWISE_TRY(one.camera, given_camera(parts[3]));
  if (parts[2].empty()) return one;
  char* end = nullptr;
  one.duration_s = std::strtod(parts[2].c_str(), &end);
  if (*end != '\0' || !(*one.duration_s > 0)) {
    return fail("--recording {}: '{}' are no seconds of walking", text, parts[2]);
  }
  return one;
}

Expected<std::vector<trials::ComparedThing>> compare(const OwnThingsOptions& options,
                                                     Context& context) {
  std::error_code error;
  if (!options.compared.empty() && fs::exists(options.compared, error)) {
    return trials::read_compared_things(options.compared);
  }
  ThreadPool pool(context.threads);
  trials::TrialSet set;
  std::vector<trials::LabelledRecording> recordings;
  for (const std::string& text : options.recordings) {
    ROOMWISE_TRY(recordings.emplace_back(), parse_recording(text));
  }
  ROOMWISE_RETURN_IF_ERROR(trials::add_recorded_things(recordings, context.seed, set));
  if (!options.photos.empty()) {
    ROOMWISE_RETURN_IF_ERROR(
        trials::add_photo_things(options.photos, options.photo_things, context.seed, set));
  }
  if (options.rendered_things > 0) {
    trials::RenderedThingsOptions rendered;
    rendered.things = (options.rendered_things + 1) / rendered.homes.size();
    rendered.seed = context.seed;
    ROOMWISE_TRY(const auto catalogue, simulation::FurnitureCatalogue::open(options.furniture));
    ROOMWISE_RETURN_IF_ERROR(
        trials::add_rendered_things(rendered, catalogue, pool, context.progress, set));
  }
  ROOMWISE_TRY(const pipeline::Networks networks, load_networks({}, nullptr));
  ROOMWISE_TRY(const objects::ObjectFinders finders, load_object_finders());
  const auto names = std::ranges::find_if(
      networks, [](const auto& network) { return !network->labels().empty(); });
  if (names == networks.end()) return fail("no network here names things; see networks list");
  ROOMWISE_TRY(auto things, trials::compare_own_things(set, **names, finders.in_pictures,
                                                       options.trial, pool, context.progress));
  if (!options.compared.empty()) {
    std::string lines;
    for (const trials::ComparedThing& thing : things) lines += trials::to_json_line(thing);
    ROOMWISE_RETURN_IF_ERROR(write_file(options.compared, lines));
  }
  return things;
}

std::string_view name_of(trials::TrialGroup group) {
  constexpr std::array<std::string_view, 3> kNames{"recorded", "photo", "rendered"};
  return kNames.at(static_cast<std::size_t>(group));
}

Json json_of(const trials::FindingResult& result) {
  const auto interval = result.found.wilson_interval();
  return {{"pictures", result.found.n},
          {"found", result.found.successes},
          {"recall", result.found.value()},
          {"recall_low", interval.low},
          {"recall_high", interval.high},
          {"found_elsewhere", result.elsewhere},
          {"alarms", result.alarms},
          {"walked_h", result.walked_h},
          {"alarms_an_hour",
           result.walked_h > 0 ? static_cast<double>(result.alarms) / result.walked_h : 0}};
}

Json json_of(const objects::OwnThingModel& model, const trials::OwnThingsOptions& options,
             std::span<const trials::ComparedThing> things) {
  Json json{{"what", "what speaks for a place being a thing that was taught"},
            {"made_by", "roomwise-lab own-things"},
            {"weight_penalty", options.weight_penalty},
            {"false_an_hour", options.max_false_an_hour},
            {"bias", model.bias},
            {"margin", model.margin},
            {"weights", Json::object()}};
  for (std::size_t i = 0; i < objects::kMatchFeatures; ++i) {
    json["weights"][std::string(objects::kMatchFeatureNames[i])] = model.weights[i];
  }
  std::map<std::string, int> of_recording;
  for (const trials::ComparedThing& thing : things) {
    ++of_recording[fmt::format("{}, {}", thing.recording, name_of(thing.group))];
  }
  json["things"] = of_recording;
  return json;
}

Expected<Answer> run(const OwnThingsOptions& options, Context& context) {
  ROOMWISE_TRY(const auto things, compare(options, context));
  const trials::OwnThingsResult result = trials::measure_own_things(things, options.trial);
  Answer answer;
  answer.text = fmt::format("{:<9} {:<7} {:>9} {:>7} {:>13} {:>10} {:>7} {:>9}\n", "things", "way",
                            "pictures", "recall", "95 %", "elsewhere", "alarms", "an hour");
  for (const auto& [key, one] : result.by_group) {
    const auto interval = one.found.wilson_interval();
    answer.text += fmt::format(
        "{:<9} {:<7} {:>9} {:>7.3f} {:>6.3f}-{:<6.3f} {:>10} {:>7} {:>9.1f}\n", name_of(key.first),
        key.second, one.found.n, one.found.value(), interval.low, interval.high, one.elsewhere,
        one.alarms, one.walked_h > 0 ? static_cast<double>(one.alarms) / one.walked_h : 0.0);
    Json json = json_of(one);
    json["things"] = name_of(key.first);
    json["way"] = key.second;
    answer.json["results"].push_back(std::move(json));
  }
  for (const trials::ComparedThing& thing : things) {
    const auto& one = result.by_thing.at(thing.recording + ": " + thing.name);
    Json json = json_of(one);
    json["name"] = thing.name;
    json["recording"] = thing.recording;
    json["group"] = name_of(thing.group);
    json["label"] = thing.label;
    json["shown"] = thing.shown;
    json["refused"] = thing.refused;
    answer.json["of_things"].push_back(std::move(json));
    answer.text +=
        fmt::format("  {:<28} {:<26} {:>2} of {:>2}, {} alarms, {} of {} shown refused, {}\n",
                    thing.recording, thing.name, one.found.successes, one.found.n, one.alarms,
                    thing.refused, thing.shown, thing.label.empty() ? "no label" : thing.label);
  }
  answer.json["reachable"] = result.reachable.value();
  answer.text +=
      fmt::format("tests with a place that was compared: {:.3f}\n", result.reachable.value());
  const objects::OwnThingModel model = trials::fit_own_things(things, "", options.trial);
  const Json json = json_of(model, options.trial, things);
  answer.json["model"] = json;
  if (!options.output.empty()) {
    ROOMWISE_RETURN_IF_ERROR(write_file(options.output, json.dump(1) + "\n"));
    answer.text += fmt::format("fitted on all: {}\n", options.output.string());
  }
  return answer;
}

}  // namespace

void add_own_things_command(CLI::App& app, Context& context) {
  const auto [command, options] = add_command<OwnThingsOptions>(
      app, context, "own-things",
      "Fit what speaks for a place being a taught thing, and measure how things are found again",
      "roomwise-lab own-things --recording "
      "office_walk,tests/truth/labels/office_walk.reader-b.json,61 \\\n"
      "  --photos object_photos -o roomwise/objects/own_things/own_thing_model.json\n"
      "Each recording is left out in its turn; the file is compiled in by the next build.",
      run);
  command->add_option(
      "--recording", options.recordings,
      "FOLDER[,LABELS[,SECONDS[,CAMERA]]]: a walk, what a reader marked, how long it "
      "took where its stamps do not tell, and its camera");
  command->add_option("--photos", options.photos, "Folder of photos, a thing each");
  add_setting(*command, "--photo-things", options.photo_things, "Of the photos, so many");
  add_setting(*command, "--rendered-things", options.rendered_things, "Things of simulated homes");
  add_setting(*command, "--false-an-hour", options.trial.max_false_an_hour,
              "False alarms an hour of walking that are allowed for each thing", positive());
  add_setting(*command, "--views", options.trial.views, "By which a thing is known, at most",
              positive());
  add_setting(*command, "--weight-penalty", options.trial.weight_penalty,
              "Ridge penalty of standardised likenesses", positive());
  command->add_option("--compared", options.compared,
                      "Where comparisons are kept: read if it is there, else written");
  command->add_option("-o,--output", options.output, "The model fitted on all; default: none");
  add_furniture_option(*command, options.furniture);
}

}  // namespace roomwise::app
