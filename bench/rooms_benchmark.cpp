// How rightly rooms are named, things found and changes noticed in many simulated homes: each is
// walked through and learned by day, and looked at on other walks, in the evening, by night and
// with things moved; walks through other homes are the rooms that it never learned.
//   rooms_benchmark FOLDER --homes 101-120
// It runs the program `roomwise` beside it and keeps what each command printed: what was done is
// not done again. Prints a table over all homes. Intervals of 95 % resample whole walks (of what
// was never learned: homes).

#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>

#include "arguments.h"
#include "laboratory/studies/roomwise_runs.h"
#include "roomwise/base/file.h"
#include "roomwise/evaluation/statistics/resampling.h"

namespace roomwise::bench {
namespace {

namespace fs = std::filesystem;
using evaluation::BlockedProportion;
using nlohmann::json;
using studies::Words;

struct RoomsOptions {
  fs::path folder;
  std::string homes;
  std::vector<fs::path> networks;
  std::vector<fs::path> elsewhere;
  bool is_made_alone = false;
  bool is_thinned = false;
};

using Walk = studies::SimulatedWalk;
using studies::kVisits;

// The rooms of a home, by its seed.
constexpr std::array<std::string_view, 5> kRooms{
    "bedroom,bedroom,kitchen,toilet,hall",
    "bedroom,kitchen,toilet,hall",
    "bedroom,bedroom,kitchen,toilet,hall,living-room",
    "bedroom,kitchen,toilet,hall,living-room",
    "bedroom,bedroom,kitchen,toilet,hall,living-room,dining-room,study",
};

// Runs bin/roomwise and keeps what it prints in a file, with its command.
Expected<void> run_once(const Words& words, const fs::path& result) {
  static const Interruption never;
  const studies::RunProgram program = [](const studies::ProgramRun& run) {
    fmt::print(stderr, "roomwise {}\n", fmt::join(run.words, " "));
    return studies::roomwise_beside(never)(run);
  };
  auto made = studies::run_kept({words, {}, {}, {}}, result, program);
  if (!made) {
    return fail("{}; the same command goes on from there", std::move(made).error().message);
  }
  return {};
}

Words with_networks(Words words, const RoomsOptions& options) {
  return studies::with_networks(std::move(words), options.networks);
}

Expected<void> simulate(const std::string& seed, const fs::path& folder, const Walk& walk) {
  const std::size_t kind = std::stoull(seed) % kRooms.size();
  return run_once(
      studies::simulate_words({"--home-seed", seed, "--rooms", std::string(kRooms[kind])}, walk,
                              folder / walk.name),
      folder / fmt::format("{}.json", walk.name));
}

fs::path changes_file(const fs::path& folder, const Walk& walk) {
  return folder / fmt::format("changes-{}.json", walk.name);
}

// The home's walks and its map, with the things in it and what changed.
Expected<void> make_home(const std::string& seed, const RoomsOptions& options) {
  const fs::path folder = options.folder / seed;
  fs::create_directories(folder);
  const fs::path home = folder / "day.home";
  const fs::path mapped = folder / "mapped.json";
  ROOMWISE_RETURN_IF_ERROR(simulate(seed, folder, studies::kDayWalk));
  if (!fs::exists(mapped)) {
    for (const char* suffix : {"", "-wal", "-shm", "-lock"}) fs::remove(home.string() + suffix);
  }
  ROOMWISE_RETURN_IF_ERROR(run_once(
      with_networks({"map", (folder / "day").string(), "--home", home.string()}, options), mapped));
  for (const Walk& walk : kVisits) {
    ROOMWISE_RETURN_IF_ERROR(simulate(seed, folder, walk));
  }
  const Words of_day{"--home", home.string(), "--truth", (folder / "day").string()};
  Words objects{"eval", "objects"};
  std::ranges::copy(of_day, std::back_inserter(objects));
  ROOMWISE_RETURN_IF_ERROR(run_once(std::move(objects), folder / "objects.json"));
  for (const Walk& walk : kVisits) {
    if (walk.condition != "moved") continue;
    Words changes{"eval", "changes", "--visit", (folder / walk.name).string()};
    std::ranges::copy(of_day, std::back_inserter(changes));
    ROOMWISE_RETURN_IF_ERROR(run_once(std::move(changes), changes_file(folder, walk)));
  }
  if (options.is_thinned) fs::remove_all(folder / "day");
  return {};
}

// Rooms that the home never learned: of the two homes after it in the list, one walk each, and what
// is given.
Expected<json> evaluate_home(std::size_t i, const Words& seeds, const RoomsOptions& options) {
  const fs::path folder = options.folder / seeds[i];
  const std::string home = (folder / "day.home").string();
  ROOMWISE_RETURN_IF_ERROR(run_once(with_networks({"rooms", "learn", "--home", home}, options),
                                    folder / "learned.json"));
  Words words = studies::room_trial_words(home, 1);
  for (const Walk& walk : kVisits) {
    words.insert(words.end(), {"--recording", (folder / walk.name).string()});
  }
  for (std::size_t k = 1; k <= 2; ++k) {
    const std::string& other = seeds[(i + k) % seeds.size()];
    const std::string_view walk = kVisits[2 * (k - 1)].name;
    if (other != seeds[i]) {
      words.insert(words.end(), {"--unknown", (options.folder / other / walk).string()});
    }
  }
  for (const fs::path& elsewhere : options.elsewhere) {
    words.insert(words.end(), {"--unknown", elsewhere.string()});
  }
  const fs::path result = folder / "rooms.json";
  ROOMWISE_RETURN_IF_ERROR(run_once(with_networks(std::move(words), options), result));
  ROOMWISE_TRY(const std::string text, read_text_file(result));
  return json::parse(text);
}

// ---- the table ----

// `part` of `whole` trials of a block succeeded.
void add(BlockedProportion& to, std::uint64_t block, std::uint64_t part, std::uint64_t whole) {
  for (std::uint64_t i = 0; i < whole; ++i) to.add(block, i < part);
}

std::string cell(const BlockedProportion& share) {
  const evaluation::Interval interval = share.resampled_interval();
  return fmt::format("{:.3f} ({:.3f} to {:.3f})", share.total().value(), interval.low,
                     interval.high);
}

void print_ways(const std::vector<json>& homes) {
  fmt::print(
      "| way | what changed | walks | decisions | named | of these right | best room right |\n"
      "| --- | --- | --- | --- | --- | --- | --- |\n");
  for (const auto& [key, title] : studies::kRoomWays) {
    for (const auto& [condition, changed] :
         {std::pair("light", "light"), std::pair("moved", "things moved")}) {
      BlockedProportion named, right, best;
      std::uint64_t block = 0;
      for (const json& home : homes) {
        if (!home.contains(key)) continue;
        for (const json& walk : home.at(key).at("walks")) {
          const auto of_visit = std::ranges::find(kVisits, walk.at("walk"), &Walk::name);
          if (of_visit == kVisits.end() || of_visit->condition != condition) continue;
          ++block;
          add(named, block, walk.at("named"), walk.at("n"));
          add(right, block, walk.at("right"), walk.at("named"));
          add(best, block, walk.at("correct"), walk.at("n"));
        }
      }
      if (block == 0) continue;
      fmt::print("| {} | {} | {} | {} | {} | {} | {} |\n", title, changed, block, best.total().n,
                 cell(named), cell(right), cell(best));
    }
  }
}

// Of each home the share of a kind that got a name, and how well the kind is told from its rooms.
void print_unknown_row(const std::vector<json>& homes, const char* key, const char* title,
                       const std::string& kind,
                       const std::function<bool(const std::string& folder)>& is_of_kind) {
  BlockedProportion named;
  double sum = 0, least = 1;
  std::uint64_t block = 0, folders = 0;
  for (const json& home : homes) {
    if (!home.contains(key)) continue;
    ++block;
    for (const auto& [folder, one] : home.at(key).at("folders").items()) {
      if (!is_of_kind(folder)) continue;
      const std::uint64_t n = one.at("n");
      const double area = one.at("auroc");
      add(named, block,
          static_cast<std::uint64_t>(
              std::lround(one.at("named").get<double>() * static_cast<double>(n))),
          n);
      sum += area;
      least = std::min(least, area);
      ++folders;
    }
  }
  if (folders == 0) return;
  fmt::print("| {} | {} | {} | {} | {:.3f}, {:.3f} |\n", kind, title, named.total().n, cell(named),
             sum / static_cast<double>(folders), least);
}

void print_unknown(const std::vector<json>& homes, const RoomsOptions& options) {
  fmt::print(
      "\n| never learned | asked with | decisions | got a name | AUROC: mean of the folders, least "
      "|\n| --- | --- | --- | --- | --- |\n");
  const auto is_elsewhere = [&](const std::string& folder) {
    return std::ranges::find(options.elsewhere, fs::path(folder)) != options.elsewhere.end();
  };
  for (const auto& [key, title] :
       {std::pair("unknown", "one picture"), std::pair("unknown_place", "one, with its place"),
        std::pair("unknown_pair", "two pictures"),
        std::pair("unknown_pair_place", "two, with their place"),
        std::pair("unknown_stream", "every picture of a walk"),
        std::pair("unknown_stream_place", "every picture of a walk, with its place")}) {
    print_unknown_row(homes, key, title, "all", [](const std::string&) { return true; });
    print_unknown_row(homes, key, title, "other simulated homes",
                      [&](const std::string& folder) { return !is_elsewhere(folder); });
    for (const fs::path& elsewhere : options.elsewhere) {
      print_unknown_row(homes, key, title,
                        (elsewhere.parent_path().filename() / elsewhere.filename()).string(),
                        [&](const std::string& folder) { return folder == elsewhere.string(); });
    }
  }
}

// Of all homes: `way` is "instances", "naive" or "rules".
void print_objects_row(const std::vector<json>& homes, const char* way, const char* title) {
  std::uint64_t found = 0, missed = 0, beyond = 0, twice = 0, wrong = 0;
  std::vector<double> errors_m;
  for (const json& home : homes) {
    const json& of_way = home.at(way);
    found += of_way.at("found").get<std::uint64_t>();
    missed += of_way.at("missed").get<std::uint64_t>();
    beyond += of_way.at("beyond").get<std::uint64_t>();
    twice += of_way.at("double").get<std::uint64_t>();
    wrong += of_way.at("false").get<std::uint64_t>();
    for (const json& pair : of_way.at("pairs")) errors_m.push_back(pair.at("from_middle_m"));
  }
  std::ranges::sort(errors_m);
  const auto error_at = [&](double share) {
    return errors_m.empty() ? 0
                            : errors_m[static_cast<std::size_t>(
                                  share * static_cast<double>(errors_m.size() - 1))];
  };
  const auto share = [](std::uint64_t part, std::uint64_t of) {
    return fmt::format(
        "{} of {} ({:.0f} %)", part, of,
        100.0 * static_cast<double>(part) / static_cast<double>(std::max<std::uint64_t>(1, of)));
  };
  const std::uint64_t all = found + beyond + twice + wrong;
  fmt::print("| {} | {} | {} | {} | {} | {:.3f} m ({:.2f}) |\n", title,
             share(found, found + missed), beyond, share(twice, all), share(wrong, all),
             error_at(0.5), error_at(0.9));
}

Expected<void> print_things(const Words& seeds, const fs::path& folder) {
  std::vector<json> homes;
  std::uint64_t expected = 0, noticed = 0, known = 0, known_noticed = 0, right = 0, wrong = 0,
                visits = 0, noticed_at_all = 0, unnamed_right = 0, doors = 0, unnamed_wrong = 0;
  for (const std::string& seed : seeds) {
    ROOMWISE_TRY(const std::string objects, read_text_file(folder / seed / "objects.json"));
    homes.push_back(json::parse(objects));
    for (const Walk& walk : kVisits) {
      if (walk.condition != "moved") continue;
      ROOMWISE_TRY(const std::string text, read_text_file(changes_file(folder / seed, walk)));
      const json changes = json::parse(text);
      ++visits;
      expected += changes.at("expected").get<std::uint64_t>();
      noticed += changes.at("noticed").get<std::uint64_t>();
      known += changes.at("known").get<std::uint64_t>();
      known_noticed += changes.at("known_noticed").get<std::uint64_t>();
      right += changes.at("right_alarms").get<std::uint64_t>();
      wrong += changes.at("wrong_alarms").size();
      noticed_at_all += changes.at("noticed_with_unnamed").get<std::uint64_t>();
      unnamed_right += changes.at("unnamed_right").get<std::uint64_t>();
      doors += changes.at("unnamed_doors").get<std::uint64_t>();
      unnamed_wrong += changes.at("unnamed_wrong").size();
    }
  }
  fmt::print(
      "\n| things | found of expected | beyond | found twice | false | from the box's middle, "
      "median (90 %) |\n| --- | --- | --- | --- | --- | --- |\n");
  print_objects_row(homes, "instances", "joined from regions");
  print_objects_row(homes, "naive", "naive clustering");
  print_objects_row(homes, "rules", "the paper's rules");
  fmt::print(
      "\n| visits with things moved | changed: noticed | of those that the home had found | alarms "
      "right, wrong | noticed with what has no name | of that right, doors, wrong |\n"
      "| --- | --- | --- | --- | --- | --- |\n"
      "| {} | {} of {} | {} of {} | {}, {} | {} of {} | {}, {}, {} |\n",
      visits, noticed, expected, known_noticed, known, right, wrong, noticed_at_all, expected,
      unnamed_right, doors, unnamed_wrong);
  return {};
}

// "101-103,7": 101, 102, 103, 7.
Expected<Words> parse_seeds(const std::string& text) {
  constexpr const char* kUsage = "rooms_benchmark FOLDER --homes 101-120";
  Words seeds;
  for (const std::string& part : CLI::detail::split(text, ',')) {
    const std::size_t dash = part.find('-');
    ROOMWISE_TRY(const int first, parse_count(part.substr(0, dash), kUsage));
    ROOMWISE_TRY(const int last,
                 dash == std::string::npos ? first : parse_count(part.substr(dash + 1), kUsage));
    for (int seed = first; seed <= last; ++seed) seeds.push_back(std::to_string(seed));
  }
  return seeds;
}

Expected<void> run(const RoomsOptions& options) {
  ROOMWISE_TRY(const Words seeds, parse_seeds(options.homes));
  for (const std::string& seed : seeds) ROOMWISE_RETURN_IF_ERROR(make_home(seed, options));
  if (options.is_made_alone) return {};
  std::vector<json> homes;
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    ROOMWISE_TRY(homes.emplace_back(), evaluate_home(i, seeds, options));
  }
  print_ways(homes);
  print_unknown(homes, options);
  return print_things(seeds, options.folder);
}

}  // namespace
}  // namespace roomwise::bench

int main(int argc, char** argv) {
  roomwise::bench::RoomsOptions options;
  CLI::App app("How rightly rooms are named in many simulated homes");
  app.add_option("FOLDER", options.folder, "Where homes are made and kept")->required();
  app.add_option("--homes", options.homes, "Their seeds: 101-120, or 11,12")->required();
  app.add_option("--network", options.networks,
                 "ONNX networks to learn on and to name things with; default: as for map");
  app.add_option("--elsewhere", options.elsewhere,
                 "Folders of pictures, or recordings, of places that no home has, to be asked for "
                 "beside other homes; may be given several times");
  app.add_flag("--only-make", options.is_made_alone, "Simulate and map, and evaluate nothing yet");
  app.add_flag("--thin", options.is_thinned,
               "Delete each home's walk by day, which is the largest, once it is mapped");
  CLI11_PARSE(app, argc, argv);
  try {
    const auto done = roomwise::bench::run(options);
    if (done) return 0;
    fmt::print(stderr, "rooms_benchmark: {}\n", done.error().message);
  } catch (const nlohmann::json::exception& error) {
    fmt::print(stderr,
               "rooms_benchmark: a result was printed by another version of roomwise; remove the "
               "JSON files of the homes to have them made anew ({})\n",
               error.what());
  }
  return 1;
}
