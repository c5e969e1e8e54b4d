#include "laboratory/studies/paper_study.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <limits>
#include <set>
#include <utility>

#include "laboratory/studies/paper_recordings.h"
#include "laboratory/studies/roomwise_runs.h"
#include "roomwise/base/file.h"

namespace roomwise::studies {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kFlat = "reference flat";
constexpr std::array kMethods{"paper", "combined"};
constexpr std::array kFeatures{"surf", "sift", "orb"};

// One run of the program. Its result is kept as NAME.json of the work folder.
struct Step {
  std::string name;   // "mapping/fr1-rpy-paper-surf-1"
  std::string after;  // the step that must have succeeded before; empty: none
  Words words;
  std::vector<fs::path> made;     // that must be there for its result to count
  std::vector<fs::path> cleared;  // what it begins without; `made` is cleared, too
  std::vector<fs::path> removed;  // no longer needed once it is done
};

// A home, with what SQLite and the program keep beside it.
std::vector<fs::path> home_files(const fs::path& home) {
  std::vector<fs::path> files;
  for (const char* suffix : {"", "-wal", "-shm", "-lock"}) {
    files.emplace_back(home.string() + suffix);
  }
  return files;
}

std::string digest_of(const json& result) {
  const std::string text = result.dump();
  return sha256_hex({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

// A recording to map: a real one, or a walk through the simulated flat.
struct Walk {
  MeasuredData data;
  std::string name;  // of its files
  fs::path folder;
  Words camera;      // --camera PRESET, or nothing
  fs::path objects;  // truth of objects; empty: none
  std::string after;
};

// The steps of a study in their order, and what came of them.
class Plan {
 public:
  explicit Plan(const PaperStudyOptions& options) : options_(options) {
    for (const PaperRecording& recording : paper_recordings()) {
      if (const auto walk = real_walk(recording)) {
        real_.push_back(*walk);
      } else {
        missing_.push_back(&recording);
      }
    }
  }

  [[nodiscard]] fs::path in_work(const std::string& name) const { return options_.work / name; }
  [[nodiscard]] bool has_networks() const { return !options_.networks.empty(); }
  [[nodiscard]] const std::vector<Walk>& real() const { return real_; }
  [[nodiscard]] const std::vector<const PaperRecording*>& missing() const { return missing_; }
  [[nodiscard]] const PaperStudyOptions& options() const { return options_; }

  // Absent where the recording is not there.
  [[nodiscard]] std::optional<Walk> real_walk(const PaperRecording& recording) const {
    const fs::path folder = options_.data / recording.folder;
    if (!fs::is_directory(folder)) return std::nullopt;
    Walk walk;
    walk.data.name = recording.title;
    walk.name = recording.folder;
    walk.folder = folder;
    if (!recording.camera.empty() && !fs::exists(folder / "camera.txt")) {
      walk.camera = {"--camera", recording.camera};
    }
    const fs::path truth = options_.truth / (recording.folder + ".objects.json");
    if (!options_.truth.empty() && fs::exists(truth)) walk.objects = truth;
    return walk;
  }

  // Walks of which maps and objects are measured: the real ones, else a simulated one.
  [[nodiscard]] std::vector<Walk> walks() {
    return real_.empty() ? std::vector{simulated_walk(kDayWalk)} : real_;
  }

  // Adds the step that makes it.
  Walk simulated_walk(const SimulatedWalk& of) {
    const std::string name = fmt::format("flat/{}", of.name);
    const fs::path folder = in_work(name);
    add({name, "", simulate_words({}, of, folder), {folder}, {}, {}});
    return {{kFlat, true}, fmt::format("flat-{}", of.name), folder, {}, folder, name};
  }

  // A step of that name may be there already; then it stays as it is.
  void add(Step step) {
    if (!names_.insert(step.name).second) return;
    steps_.push_back(std::move(step));
  }

  Expected<void> run(const RunProgram& program, Progress& progress) {
    progress.begin("making the paper's tables", steps_.size());
    for (std::size_t i = 0; i < steps_.size(); ++i) {
      progress.advance(i, steps_[i].name);
      ROOMWISE_RETURN_IF_ERROR(progress.check("making the paper's tables"));
      const auto heard = [&](const std::string& line) {
        progress.advance(i, fmt::format("{}: {}", steps_[i].name, line));
      };
      auto outcome = run_step(steps_[i], heard, program);
      if (!outcome && outcome.error().code == ErrorCode::kInterrupted) {
        return Unexpected(std::move(outcome).error());
      }
      outcomes_.emplace(steps_[i].name, std::move(outcome));
    }
    progress.advance(steps_.size(), "done");
    progress.end();
    return {};
  }

  [[nodiscard]] const Expected<json>& outcome(const std::string& step) const {
    return outcomes_.at(step);
  }

 private:
  Expected<json> run_step(const Step& step, const std::function<void(const std::string&)>& heard,
                          const RunProgram& program) {
    if (!step.after.empty() && !outcomes_.at(step.after)) {
      return Unexpected(outcomes_.at(step.after).error());
    }
    const fs::path file = in_work(step.name + ".json");
    ProgramRun run{step.words, options_.more, in_work(step.name + ".log"), heard};
    run.made_with = options_.version;
    if (!step.after.empty()) run.made_with += " after " + digest_of(*outcomes_.at(step.after));
    std::error_code ignored;
    const auto kept = kept_result(run, file);
    const bool is_made =
        std::ranges::all_of(step.made, [](const fs::path& made) { return fs::exists(made); });
    if (kept && *kept && is_made && !run_now_.contains(step.after)) return json(**kept);
    // What is there is of other words, of what is made anew, or half done.
    run_now_.insert(step.name);
    fs::remove(file, ignored);
    for (const auto* paths : {&step.made, &step.cleared}) {
      for (const fs::path& path : *paths) fs::remove_all(path, ignored);
    }
    auto made = run_kept(run, file, program);
    if (!made) return made;
    for (const fs::path& path : step.removed) fs::remove_all(path, ignored);
    return made;
  }

  const PaperStudyOptions& options_;
  std::vector<Walk> real_;
  std::vector<const PaperRecording*> missing_;
  std::vector<Step> steps_;
  std::set<std::string> names_;
  std::set<std::string> run_now_;  // steps that were not kept
  std::map<std::string, Expected<json>> outcomes_;
};

// A sentence a reason, each only once.
class Missing {
 public:
  Missing(PaperResults& results, PaperPart part) : sentences_(results.missing[part]) {}
  void add(const std::string& sentence) {
    if (std::ranges::find(sentences_, sentence) == sentences_.end()) {
      sentences_.push_back(sentence);
    }
  }
  // What a step made, or nothing, and why.
  const json* need(const Plan& plan, const std::string& step, const std::string& what) {
    const Expected<json>& outcome = plan.outcome(step);
    if (outcome) return &*outcome;
    add(fmt::format("{}: {}.", what, outcome.error().message));
    return nullptr;
  }

 private:
  std::vector<std::string>& sentences_;
};

constexpr const char* kNoNetwork =
    "No network is installed: nothing in pictures can be named. Set ROOMWISE_MODELS to a folder "
    "with networks (roomwise networks list).";

// ---- mapping ----

struct MappingCase {
  const char* method;
  const char* features;
  std::uint64_t seed;
};

std::string mapping_step(const Walk& walk, const MappingCase& of) {
  return fmt::format("mapping/{}-{}-{}-{}", walk.name, of.method, of.features, of.seed);
}

void plan_map(const Walk& walk, const MappingCase& of, Plan& plan) {
  const std::string name = mapping_step(walk, of);
  const fs::path home = plan.in_work(name + ".home");
  const fs::path trajectory = plan.in_work(name + ".trajectory.txt");
  // A map that was killed is begun anew: its time would be that of a part.
  Words words{
      "map",          walk.folder.string(), "--home",    home.string(), "--method",
      of.method,      "--features",         of.features, "--seed",      std::to_string(of.seed),
      "--no-networks"};
  words.insert(words.end(), {"--trajectory", trajectory.string()});
  words.insert(words.end(), walk.camera.begin(), walk.camera.end());
  plan.add({name, walk.after, words, {trajectory}, home_files(home), home_files(home)});
  plan.add(
      {name + ".error",
       name,
       {"eval", "trajectory", "--truth", walk.folder.string(), "--estimate", trajectory.string()},
       {},
       {},
       {}});
}

std::vector<std::uint64_t> seeds_of(const PaperStudyOptions& options) {
  std::vector<std::uint64_t> seeds;
  for (int i = 0; i < options.seeds; ++i) {
    seeds.push_back(options.first_seed + static_cast<std::uint64_t>(i));
  }
  return seeds;
}

void plan_mapping(const std::vector<Walk>& walks, Plan& plan) {
  for (const Walk& walk : walks) {
    for (const char* method : kMethods) {
      for (const char* features : kFeatures) {
        for (const std::uint64_t seed : seeds_of(plan.options())) {
          plan_map(walk, {method, features, seed}, plan);
        }
      }
    }
  }
}

MappingTrial trial_of(const json& map, const json& error) {
  MappingTrial trial;
  trial.frames = map.at("frames");
  trial.placed = map.at("placed");
  trial.ate_m = error.at("ate_rmse_m");
  if (!error.at("rpe").is_null()) trial.rpe_m = error.at("rpe").at("translation_m").at("rmse");
  const auto ms = [&](double seconds) { return 1000 * seconds / std::max(1.0, trial.frames); };
  const auto stage_ms = [&](const char* stage) {
    const json& stages = map.at("stages");
    return stages.contains(stage) ? ms(stages.at(stage).at("cpu_s")) : 0.0;
  };
  trial.features_ms = stage_ms("features");
  trial.views_ms = stage_ms("views");
  trial.tracking_ms = stage_ms("tracking and loops");
  trial.solving_ms = stage_ms("optimisation");
  trial.all_ms = ms(map.at("cpu_s"));
  trial.reading_ms = stage_ms("read");
  trial.floor_ms = stage_ms("surfaces") + stage_ms("floor");
  return trial;
}

void collect_mapping(const std::vector<Walk>& walks, const Plan& plan, PaperResults& results) {
  Missing missing(results, PaperPart::kMapping);
  for (const PaperRecording* recording : plan.missing()) missing.add(missing_text(*recording));
  for (const Walk& walk : walks) {
    for (const char* method : kMethods) {
      for (const char* features : kFeatures) {
        MappingRow row{walk.data, method, features, {}};
        for (const std::uint64_t seed : seeds_of(plan.options())) {
          const std::string step = mapping_step(walk, {method, features, seed});
          const std::string what = fmt::format("{}, {}, {}", walk.data.name, method, features);
          const json* map = missing.need(plan, step, what);
          const json* error = map == nullptr ? nullptr : missing.need(plan, step + ".error", what);
          if (error != nullptr) row.trials.push_back(trial_of(*map, *error));
        }
        if (!row.trials.empty()) results.mapping.push_back(std::move(row));
      }
    }
  }
}

// ---- a home with what networks see ----

std::string home_step(const Walk& walk) {
  return fmt::format("homes/{}", walk.name);
}
fs::path home_of(const Walk& walk, const Plan& plan) {
  return plan.in_work(home_step(walk) + ".home");
}

void plan_home(const Walk& walk, Plan& plan) {
  const fs::path home = home_of(walk, plan);
  Words words{"map",    walk.folder.string(),
              "--home", home.string(),
              "--seed", std::to_string(plan.options().first_seed)};
  words.insert(words.end(), walk.camera.begin(), walk.camera.end());
  plan.add({home_step(walk),
            walk.after,
            with_networks(std::move(words), plan.options().networks),
            {home},
            home_files(home),
            {}});
}

// ---- objects ----

std::string objects_step(const Walk& walk) {
  return fmt::format("objects/{}", walk.name);
}

void plan_objects(const std::vector<Walk>& walks, Plan& plan) {
  if (!plan.has_networks()) return;
  for (const Walk& walk : walks) {
    plan_home(walk, plan);
    const std::string home = home_of(walk, plan).string();
    plan.add({objects_step(walk) + ".rules",
              home_step(walk),
              {"objects", "list", "--home", home, "--rule", "paper"},
              {},
              {},
              {}});
    if (walk.objects.empty()) continue;
    Words words{"eval", "objects", "--home", home, "--truth", walk.objects.string()};
    if (!walk.data.is_simulated) {
      words.insert(words.end(), {"--recording", walk.folder.string()});
    }
    plan.add({objects_step(walk), home_step(walk), words, {}, {}, {}});
  }
}

ObjectsRow objects_row(const MeasuredData& data, const std::string& way, const json& of) {
  ObjectsRow row{
      data,           way, of.at("found"), of.at("missed"), of.at("beyond"), of.at("double"),
      of.at("false"), {}};
  if (!of.at("pairs").empty()) row.from_middle_m = of.at("from_middle_m").at("median");
  return row;
}

void collect_objects(const std::vector<Walk>& walks, const Plan& plan, PaperResults& results) {
  Missing missing(results, PaperPart::kObjects);
  for (const PaperRecording* recording : plan.missing()) missing.add(missing_text(*recording));
  if (!plan.has_networks()) return missing.add(kNoNetwork);
  for (const Walk& walk : walks) {
    const std::string& name = walk.data.name;
    if (const json* rules = missing.need(plan, objects_step(walk) + ".rules", name)) {
      for (const json& object : rules->value("objects", json::array())) {
        results.ruled_objects.push_back({walk.data, object.at("name"), object.at("score"),
                                         object.at("sightings"),
                                         !object.at("position_world_m").is_null()});
      }
    }
    if (walk.objects.empty()) {
      missing.add(fmt::format(
          "{}: nobody marked its things in a file {}.objects.json of the folder --truth.", name,
          walk.name));
    } else if (const json* errors = missing.need(plan, objects_step(walk), name)) {
      for (const auto& [key, way] :
           {std::pair("rules", "the paper's rules"), std::pair("instances", "Roomwise's default"),
            std::pair("naive", "naive clustering")}) {
        results.objects.push_back(objects_row(walk.data, way, errors->at(key)));
      }
    }
  }
}

// ---- rooms ----

// What is asked of a home whose rooms were learned.
struct RoomTrial {
  std::string step;
  std::string changed;
  MeasuredData data;
  std::optional<int> margin;  // room_trial_words(); absent of photos
};

Words joined(Words words, const Words& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

// Learns, then asks. `before`: the step that made the home.
void plan_room_trials(const fs::path& home, const std::string& before, const Words& learn_from,
                      const std::vector<std::pair<RoomTrial, Words>>& trials, Plan& plan) {
  const std::string learn = fmt::format("rooms/{}-learn", home.stem().string());
  // Of photos alone learning makes the home.
  const bool makes_home = before.empty();
  plan.add({learn,
            before,
            with_networks(joined({"rooms", "learn", "--home", home.string()}, learn_from),
                          plan.options().networks),
            makes_home ? std::vector{home} : std::vector<fs::path>(),
            makes_home ? home_files(home) : std::vector<fs::path>(),
            {}});
  for (const auto& [trial, asked] : trials) {
    // What was learned from photos has no simple methods to compare with.
    const Words asking = trial.margin ? room_trial_words(home, *trial.margin)
                                      : Words{"rooms", "eval", "--home", home.string()};
    plan.add({trial.step,
              learn,
              with_networks(joined(asking, asked), plan.options().networks),
              {},
              {},
              {}});
  }
}

// A walk by day, learned from; then one in other light and one with things moved.
std::vector<RoomTrial> plan_flat_rooms(Plan& plan) {
  const Walk day = plan.simulated_walk(kDayWalk);
  plan_home(day, plan);
  std::vector<std::pair<RoomTrial, Words>> trials;
  std::vector<RoomTrial> planned;
  for (const auto& [condition, changed] :
       {std::pair("light", "light"), std::pair("moved", "things moved")}) {
    const auto* visit = std::ranges::find(kVisits, condition, &SimulatedWalk::condition);
    const Walk walk = plan.simulated_walk(*visit);
    planned.push_back({fmt::format("rooms/{}", walk.name), changed, walk.data, 1});
    trials.push_back({planned.back(), {"--recording", walk.folder.string()}});
  }
  plan_room_trials(home_of(day, plan), home_step(day), {}, trials, plan);
  return planned;
}

// Three areas of an office, learned from the first stay in each and asked on later ones.
void plan_office_rooms(const Walk& office, std::vector<RoomTrial>& planned, Plan& plan) {
  plan_home(office, plan);
  const Words labels{"--labels", (office.folder / "rooms.txt").string(), "--rooms",
                     "corridor,lounge,dining"};
  const RoomTrial trial{"rooms/" + office.name, "nothing: later stays", office.data, 3};
  plan_room_trials(home_of(office, plan), home_step(office), joined(labels, {"--visits", "1"}),
                   {{trial, joined({"--recording", office.folder.string()},
                                   joined(labels, {"--visits", "2-"}))}},
                   plan);
  planned.push_back(trial);
}

// Types of rooms, learned in many homes and asked in others.
void plan_photo_rooms(const fs::path& photos, std::vector<RoomTrial>& planned, Plan& plan) {
  const RoomTrial trial{"rooms/photos", "the home: photos of others", {"room_photos", false}, {}};
  const fs::path home = plan.in_work("rooms/photos.home");
  plan_room_trials(home, "", {"--photos", (photos / "train").string()},
                   {{trial, {"--photos", (photos / "eval").string()}}}, plan);
  planned.push_back(trial);
}

std::vector<RoomTrial> plan_rooms(Plan& plan) {
  if (!plan.has_networks()) return {};
  std::vector<RoomTrial> planned = plan_flat_rooms(plan);
  if (const auto office = plan.real_walk(office_walk())) plan_office_rooms(*office, planned, plan);
  const fs::path photos = plan.options().data / room_photos().folder;
  if (fs::is_directory(photos)) plan_photo_rooms(photos, planned, plan);
  return planned;
}

void collect_rooms(const std::vector<RoomTrial>& trials, const Plan& plan, PaperResults& results) {
  Missing missing(results, PaperPart::kRooms);
  missing.add(
      "Real walks through one home with light changed, and with things moved: neither the paper's "
      "own recordings nor others are at hand; a simulated flat stands in for them.");
  if (!plan.real_walk(office_walk())) missing.add(missing_text(office_walk()));
  if (!fs::is_directory(plan.options().data / room_photos().folder)) {
    missing.add(missing_text(room_photos()));
  }
  if (!plan.has_networks()) return missing.add(kNoNetwork);
  for (const RoomTrial& trial : trials) {
    const json* result = missing.need(plan, trial.step, trial.data.name + ", " + trial.changed);
    if (result == nullptr) continue;
    for (const RoomWay& way : kRoomWays) {
      const bool is_shown = std::string_view(way.key).find("pair") != std::string_view::npos;
      if (!is_shown || !result->contains(way.key)) continue;
      const json& of = result->at(way.key);
      const json& named = of.at("named");
      results.rooms.push_back({trial.changed,
                               trial.data,
                               way.title,
                               of.at("n"),
                               {named.at("right"), named.at("of")},
                               {named.at("interval").at(0), named.at("interval").at(1)},
                               of.at("ms")});
    }
  }
}

// ---- training ----

constexpr const char* kTraining = "training/curve";

void plan_training(Plan& plan) {
  const fs::path photos = plan.options().data / room_photos().folder;
  if (!fs::is_directory(photos) || !plan.options().trained) return;
  const fs::path output = plan.in_work("training/trained");
  // As docs/experiments/training.md, with more looks at what is held out.
  plan.add({kTraining,
            "",
            {"train",
             (photos / "train").string(),
             "--held-out",
             (photos / "eval").string(),
             "--network",
             plan.options().trained->string(),
             "--from-block",
             "Conv_121",
             "--steps",
             "150",
             "--learning-rate",
             "0.02",
             "--warm-up",
             "20",
             "--evaluate-every",
             "25",
             "--seed",
             std::to_string(plan.options().first_seed),
             "--out",
             output.string()},
            {},
            {output},
            {}});
}

void collect_training(const Plan& plan, PaperResults& results) {
  Missing missing(results, PaperPart::kTraining);
  if (!fs::is_directory(plan.options().data / room_photos().folder)) {
    return missing.add(missing_text(room_photos()));
  }
  if (!plan.options().trained) {
    return missing.add(
        "mobilenet-v2-imagenet.onnx, the network that is trained further, is in no folder of "
        "networks; set ROOMWISE_MODELS (roomwise networks list).");
  }
  const json* result = missing.need(plan, kTraining, "The training");
  if (result == nullptr) return;
  evaluation::TrainingReportContent& content = results.training.emplace();
  content.network = plan.options().trained->stem().string();
  content.figures = {
      {"Network", content.network},
      {"Pictures", fmt::format("{}, held out {}", result->at("pictures").get<std::uint64_t>(),
                               result->at("held_out").get<std::uint64_t>())},
      {"Steps", fmt::format("{}", result->at("steps").get<std::uint64_t>())},
      {"Processor time, s", fmt::format("{:.0f}", result->at("cpu_s").get<double>())}};
  content.best_step = result->at("best_step");
  const auto number = [](const json& value) {
    return value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>();
  };
  for (const json& point : result->at("curve")) {
    content.points.push_back({point.at("step"), number(point.at("cross_entropy")),
                              number(point.at("held_out_cross_entropy")),
                              number(point.at("held_out_precision"))});
  }
}

// Two studies in one folder would take each other's files away. The lock goes with the process,
// however that ends.
class WorkLock {
 public:
  static Expected<WorkLock> take(const fs::path& work) {
    const fs::path file = work / "lock";
    WorkLock lock(open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644));
    if (lock.file_ < 0) return fail("{}: cannot be written to", file.string());
    if (flock(lock.file_, LOCK_EX | LOCK_NB) != 0) {
      return fail(
          "{}: another run works in this folder; wait for its end or give another by --work",
          work.string());
    }
    return lock;
  }
  ~WorkLock() {
    if (file_ >= 0) close(file_);
  }
  WorkLock(WorkLock&& other) noexcept : file_(std::exchange(other.file_, -1)) {}
  WorkLock& operator=(WorkLock&&) = delete;

 private:
  explicit WorkLock(int file) : file_(file) {}
  int file_;
};

Expected<void> make_folders(const fs::path& work) {
  for (const char* part : {"flat", "mapping", "homes", "objects", "rooms", "training"}) {
    std::error_code error;
    fs::create_directories(work / part, error);
    if (error) {
      return fail("{}: cannot be made: {}; give another folder by --work", (work / part).string(),
                  error.message());
    }
  }
  return {};
}

}  // namespace

Expected<void> PaperStudyOptions::validate() const {
  if (!fs::is_directory(data)) {
    return fail("{}: is no folder; --data is the folder that holds recordings such as {}",
                data.string(), paper_recordings().front().folder);
  }
  if (!truth.empty() && !fs::is_directory(truth)) {
    return fail(
        "{}: is no folder; --truth is the folder of what people marked, tests/truth of a "
        "checkout",
        truth.string());
  }
  if (work.empty()) return fail("the work folder has no name; give one by --work");
  if (parts.empty()) return fail("no table is asked for");
  if (seeds < 1) return fail("seeds: {} is too few; at least 1", seeds);
  return {};
}

Expected<PaperResults> study_paper(const PaperStudyOptions& options, const RunProgram& program,
                                   Progress& progress) {
  ROOMWISE_RETURN_IF_ERROR(options.validate());
  ROOMWISE_RETURN_IF_ERROR(make_folders(options.work));
  ROOMWISE_TRY(const WorkLock lock, WorkLock::take(options.work));
  const auto asks = [&](PaperPart part) {
    return std::ranges::find(options.parts, part) != options.parts.end();
  };
  Plan plan(options);
  const bool needs_walks = asks(PaperPart::kMapping) || asks(PaperPart::kObjects);
  const std::vector<Walk> walks = needs_walks ? plan.walks() : std::vector<Walk>();
  if (asks(PaperPart::kMapping)) plan_mapping(walks, plan);
  if (asks(PaperPart::kObjects)) plan_objects(walks, plan);
  std::vector<RoomTrial> rooms;
  if (asks(PaperPart::kRooms)) rooms = plan_rooms(plan);
  if (asks(PaperPart::kTraining)) plan_training(plan);
  ROOMWISE_RETURN_IF_ERROR(plan.run(program, progress));

  PaperResults results;
  results.seeds = options.seeds;
  for (const fs::path& network : options.networks) {
    results.networks.push_back(network.filename().string());
  }
  try {
    for (const auto& [part, name] : kPaperParts) {
      if (asks(part)) results.parts.push_back(part);
    }
    if (asks(PaperPart::kMapping)) collect_mapping(walks, plan, results);
    if (asks(PaperPart::kObjects)) collect_objects(walks, plan, results);
    if (asks(PaperPart::kRooms)) collect_rooms(rooms, plan, results);
    if (asks(PaperPart::kTraining)) collect_training(plan, results);
  } catch (const json::exception& error) {
    return fail(
        "{}: a result there was printed by another version of roomwise; remove the folder to have "
        "all made anew ({})",
        options.work.string(), error.what());
  }
  return results;
}

}  // namespace roomwise::studies
