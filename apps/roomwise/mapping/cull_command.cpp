#include <algorithm>
#include <filesystem>
#include <map>

#include "command_run.h"
#include "commands.h"
#include "open_home.h"
#include "roomwise/base/random.h"
#include "roomwise/pipeline/mapping/culling.h"
#include "roomwise/pipeline/mapping/home_floor.h"

namespace roomwise::app {
namespace {

struct CullOptions {
  std::filesystem::path home;
  std::vector<std::string> walks;
  bool dry_run = false;
  std::string choice = "judged";
  pipeline::CullingOptions culling;
};

// Those named or, where none is, all but the first, by which the others are judged, and the last,
// by which it is known what stands where now.
Expected<std::vector<home::StoredRecording>> walks_to_judge(
    const home::Home& home, const CullOptions& options,
    const std::vector<home::StoredRecording>& recordings) {
  std::vector<home::StoredRecording> walks;
  std::vector<home::RecordingId> named;
  for (const std::string& name : options.walks) {
    ROOMWISE_TRY(const home::RecordingId walk, find_walk(home, name));
    named.push_back(walk);
  }
  for (const home::StoredRecording& one : recordings) {
    const bool is_between = one.id != recordings.front().id && one.id != recordings.back().id;
    if (named.empty() ? is_between : std::ranges::count(named, one.id) > 0) walks.push_back(one);
  }
  return walks;
}

// Those that go; the naive ways, to compare with, take as many as are judged to add nothing, or
// every second, of all that nothing hangs on.
std::vector<home::KeyframeId> chosen(const pipeline::CullingVerdicts& verdicts,
                                     const CullOptions& options, std::uint64_t seed) {
  std::vector<home::KeyframeId> judged = pipeline::redundant_of(verdicts);
  if (options.choice == "judged") return judged;
  std::vector<home::KeyframeId> free;
  for (const auto& [id, verdict] : verdicts) {
    if (verdict != pipeline::CullingVerdict::kReferenced) free.push_back(id);
  }
  std::vector<home::KeyframeId> ids;
  if (options.choice == "every-second") {
    for (std::size_t i = 0; i < free.size(); i += 2) ids.push_back(free[i]);
    return ids;
  }
  RandomStream random(seed, {free.size()});
  while (ids.size() < judged.size()) {
    const auto at = static_cast<std::ptrdiff_t>(random.index(free.size()));
    ids.push_back(free[static_cast<std::size_t>(at)]);
    free.erase(free.begin() + at);
  }
  std::ranges::sort(ids);
  return ids;
}

Expected<Answer> cull(const CullOptions& options, Context& context) {
  ROOMWISE_TRY(home::Home home, open_home(options.home, context));
  ROOMWISE_TRY(const auto settings, pipeline::stored_map_settings(home));
  ROOMWISE_TRY(const auto recordings, home.recordings());
  if (!settings || recordings.empty()) {
    return fail("{}: has no map; make one with roomwise map", options.home.string());
  }
  if (!recordings.back().finished) {
    return fail("{}: its recording {} is not finished; go on with roomwise map --resume first",
                options.home.string(), recordings.back().recording.name);
  }
  ROOMWISE_TRY(const auto walks, walks_to_judge(home, options, recordings));
  CommandRun run(context);
  Answer answer;
  answer.json["walks"] = Json::array();
  std::size_t culled = 0;
  for (const home::StoredRecording& walk : walks) {
    ROOMWISE_TRY(const pipeline::CullingVerdicts verdicts,
                 pipeline::judge_keyframes(home, walk.id, options.culling, run));
    std::map<std::string, std::size_t> counts;
    for (const auto& [id, verdict] : verdicts) ++counts[std::string(to_string(verdict))];
    const auto redundant = chosen(verdicts, options, context.seed);
    culled += redundant.size();
    answer.text += fmt::format("{}: {} of {} key-frames go\n", walk.recording.name,
                               redundant.size(), verdicts.size());
    for (const auto& [why, count] : counts) answer.text += fmt::format("  {:4} {}\n", count, why);
    answer.json["walks"].push_back({{"name", walk.recording.name},
                                    {"keyframes", verdicts.size()},
                                    {"verdicts", counts},
                                    {"redundant", redundant}});
    // The next walk is judged by what is left of this one.
    if (!options.dry_run)
      ROOMWISE_RETURN_IF_ERROR(pipeline::cull_keyframes(home, redundant, *settings));
  }
  if (!options.dry_run && culled > 0) {
    ROOMWISE_RETURN_IF_ERROR(pipeline::keep_home_floor(home, run));
    ROOMWISE_RETURN_IF_ERROR(home.erase_removed());
  }
  ROOMWISE_TRY(const auto left, home.keyframes());
  if (walks.empty()) {
    answer.text +=
        "nothing to judge: all but the first walk and the last are, by what the walks "
        "before them show; name a walk to have the last judged\n";
  }
  answer.text += options.dry_run
                     ? fmt::format("{} key-frames would go; nothing was changed\n", culled)
                     : fmt::format("{} key-frames are gone, {} are left\n", culled, left.size());
  answer.json["home"] = home.file();
  answer.json["culled"] = culled;
  answer.json["dry_run"] = options.dry_run;
  answer.json["keyframes"] = left.size();
  answer.json["cpu_s"] = process_cpu_time_s();
  return answer;
}

}  // namespace

void add_cull_command(CLI::App& app, Context& context) {
  const auto [command, options] = add_command<CullOptions>(
      app, context, "cull",
      "Take key-frames out of a home that add nothing to what the walks before theirs show, in the "
      "same light; map does so by itself as walks are added",
      "roomwise cull --home my.home --dry-run", cull);
  command->add_option("--home", options.home, "Home file")->required();
  command->add_option("--walk", options.walks,
                      "Walk to judge, as roomwise info lists it; may be given more than once "
                      "[default: all but the first and the last]");
  add_setting(*command, "--covers", options.culling.covers,
              "So often the walks before must say where a key-frame was taken, each time without "
              "what the answer before rested on");
  add_setting(*command, "--choice", options.choice,
              "judged; or, to compare with, the naive ways: as many at random, or every second",
              CLI::IsMember({"judged", "random", "every-second"}));
  command->add_flag("--dry-run", options.dry_run, "Say what would go, and change nothing");
}

}  // namespace roomwise::app
