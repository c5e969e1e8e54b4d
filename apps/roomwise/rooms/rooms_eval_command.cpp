// "rooms eval": how often rooms are named rightly, by Roomwise's way, the paper's and simple ones.

#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <opencv2/core.hpp>
#include <set>

#include "command_run.h"
#include "networks.h"
#include "open_home.h"
#include "rooms/rooms_options.h"
#include "roomwise/base/file.h"
#include "roomwise/evaluation/report/recognition_report.h"
#include "roomwise/pipeline/edits/walk_edits.h"
#include "roomwise/pipeline/rooms/room_baselines.h"
#include "roomwise/pipeline/rooms/room_evaluation.h"
#include "roomwise/pipeline/rooms/room_learning.h"
#include "roomwise/pipeline/stored/keyframe_images.h"
#include "skip_damaged.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;
using evaluation::RecognitionReportContent;
using pipeline::LabelledPicture;
using pipeline::RuleResult;

constexpr std::size_t kMaxMistakesShown = 60;

struct RoomsEvaluationOptions {
  fs::path home;
  std::vector<fs::path> recordings;
  std::vector<fs::path> labels;
  fs::path photos;
  std::vector<fs::path> unknown;
  fs::path report;
  SelectionOptions selection;
  std::uint64_t margin = 0;
  pipeline::RoomEvaluationOptions evaluation;
  bool with_baselines = false;
  bool without_places = false;
  bool skip_damaged = false;
  pipeline::BaselineOptions baselines;
  NetworkOptions networks;
};

// The pictures to evaluate, and what is left out.
struct Pictures {
  std::vector<LabelledPicture> pictures;
  std::vector<std::string> walks;         // their names
  std::vector<std::string> mapped_walks;  // whose places are not looked for
  std::vector<LabelledPicture> unknown;
  std::set<std::string> never_learned;
  std::vector<std::string> damage;  // of those that are left out, why
};

// Whether it is the recording of which the home's map was made: its frames find themselves there.
Expected<bool> is_mapped(const home::Home& home, const fs::path& folder) {
  ROOMWISE_TRY(const auto recordings, home.recordings());
  return std::ranges::any_of(recordings, [&](const home::StoredRecording& one) {
    std::error_code missing;
    return fs::equivalent(pipeline::folder_of_walk(home, one), folder, missing);
  });
}

// Which rooms the i-th recording shows.
Expected<recording::RoomLabels> labels_of(const RoomsEvaluationOptions& options, std::size_t i) {
  if (!options.labels.empty()) return recording::RoomLabels::read(options.labels[i]);
  const fs::path file = options.recordings[i] / "rooms.txt";
  if (!fs::exists(file)) {
    return fail("{}: has no rooms.txt that says which rooms it shows; give one by --labels",
                options.recordings[i].string());
  }
  return recording::RoomLabels::read(file);
}

Expected<void> add_recordings(const RoomsEvaluationOptions& options, const home::Home& home,
                              const std::vector<std::string>& learned, Context& context,
                              Pictures& all) {
  if (!options.labels.empty() && options.labels.size() != options.recordings.size()) {
    return fail(
        "{} --labels and {} --recording; give one for each, or none where each has its own "
        "rooms.txt",
        options.labels.size(), options.recordings.size());
  }
  ROOMWISE_TRY(const pipeline::RoomSelection rooms, parse(options.selection));
  for (std::size_t i = 0; i < options.recordings.size(); ++i) {
    const fs::path& folder = options.recordings[i];
    ROOMWISE_TRY(const recording::RoomLabels labels, labels_of(options, i));
    for (const recording::RoomRange& range : labels.ranges()) {
      if (rooms.contains(range)) all.never_learned.insert(range.room);
    }
    ROOMWISE_TRY(pipeline::RecordedPictures recorded, pipeline::RecordedPictures::open(folder));
    for (const recording::DamagedFrame& one : recorded.damaged) all.damage.push_back(one.why);
    if (recorded.with_depth) {
      for (const std::string& note : recorded.with_depth->notes()) context.progress.note(note);
    }
    all.walks.push_back(recording::recording_name(folder));
    ROOMWISE_TRY(const bool was_mapped, is_mapped(home, folder));
    if (was_mapped) {
      all.mapped_walks.push_back(all.walks.back());
      recorded.with_depth = nullptr;
    }
    ROOMWISE_RETURN_IF_ERROR(pipeline::add_frames(recorded, labels, {rooms, options.margin},
                                                  learned, all.walks.back(), all.pictures));
  }
  return {};
}

Expected<void> add_pictures(const RoomsEvaluationOptions& options, const home::Home& home,
                            const std::vector<std::string>& learned, Context& context,
                            Pictures& all) {
  if (options.photos.empty()) {
    ROOMWISE_RETURN_IF_ERROR(add_recordings(options, home, learned, context, all));
  } else {
    ROOMWISE_TRY(const auto photos, pipeline::list_room_photos(options.photos));
    for (const pipeline::RoomPhoto& photo : photos) all.never_learned.insert(photo.room);
    ROOMWISE_TRY(all.pictures, pipeline::select_photos(options.photos, learned));
  }
  for (const std::string& room : learned) all.never_learned.erase(room);
  for (const fs::path& folder : options.unknown) {
    ROOMWISE_TRY(const auto damage, pipeline::add_unknown_pictures(folder, all.unknown));
    std::ranges::copy(damage, std::back_inserter(all.damage));
  }
  return {};
}

RecognitionReportContent::DecisionRule row_of(const RuleResult& result, const Pictures& all,
                                              bool by_walks) {
  RecognitionReportContent::DecisionRule row;
  row.name = result.rule;
  row.decisions = result.judgements.size();
  const auto precision = precision_of(result, all.pictures, by_walks);
  const auto best = top1_accuracy_of(result, all.pictures, by_walks);
  row.named_correct = precision.total();
  row.precision_interval = precision.resampled_interval();
  row.top1_correct = best.total();
  row.top1_interval = best.resampled_interval();
  row.median_ms = result.median_ms;
  row.confusion = confusion_of(result, all.pictures);
  row.curve = curve_of(result, all.pictures);
  return row;
}

Json to_json(const evaluation::Proportion& proportion, const evaluation::Interval& interval) {
  return {{"of", proportion.n},
          {"right", proportion.successes},
          {"share", proportion.value()},
          {"interval", {interval.low, interval.high}}};
}

// What was said on each walk.
Json walks_json(const RuleResult& result, const Pictures& all) {
  struct Counts {
    std::uint64_t n = 0, correct = 0, named = 0, right = 0;
  };
  std::vector<Counts> counts(all.walks.size());
  for (const pipeline::Judgement& judgement : result.judgements) {
    const LabelledPicture& picture = all.pictures[judgement.picture];
    Counts& walk = counts[picture.walk];
    const bool is_right = judgement.best == picture.room;
    ++walk.n;
    if (is_right) ++walk.correct;
    if (judgement.named) ++walk.named;
    if (judgement.named && is_right) ++walk.right;
  }
  Json json = Json::array();
  for (std::size_t i = 0; i < counts.size(); ++i) {
    json.push_back({{"walk", all.walks[i]},
                    {"n", counts[i].n},
                    {"correct", counts[i].correct},
                    {"named", counts[i].named},
                    {"right", counts[i].right}});
  }
  return json;
}

// "correct", "precision" and "interval" are of all decisions: the best room, named or not.
Json to_json(const RecognitionReportContent::DecisionRule& row, const RuleResult& result) {
  Json json = {{"rule", row.name},
               {"n", row.decisions},
               {"correct", row.top1_correct.successes},
               {"precision", row.top1_correct.value()},
               {"interval", {row.top1_interval.low, row.top1_interval.high}},
               {"named", to_json(row.named_correct, row.precision_interval)},
               {"ms", row.median_ms}};
  if (!result.reasons.empty()) json["how"] = result.reasons;
  for (const std::string& truth : row.confusion.rooms()) {
    for (const std::string& answer : row.confusion.rooms()) {
      if (const auto count = row.confusion.count(truth, answer); count > 0)
        json["confusion"][truth][answer] = count;
    }
  }
  for (const evaluation::CoveragePoint& point : row.curve) {
    json["curve"].push_back({point.threshold, point.coverage, point.precision});
  }
  return json;
}

std::string to_text(const RecognitionReportContent::DecisionRule& row) {
  return fmt::format(
      "{:44} {:5} {:7.3f} ({:.3f} to {:.3f}) {:7.3f} {:7.3f} ({:.3f} to {:.3f}) {:8.1f}\n",
      row.name, row.decisions, row.top1_correct.value(), row.top1_interval.low,
      row.top1_interval.high,
      row.decisions == 0
          ? 0
          : static_cast<double>(row.named_correct.n) / static_cast<double>(row.decisions),
      row.named_correct.value(), row.precision_interval.low, row.precision_interval.high,
      row.median_ms);
}

std::string confusion_text(const RecognitionReportContent::DecisionRule& row) {
  std::string text = row.name + ":\n";
  for (const std::string& room : row.confusion.rooms()) {
    const evaluation::Proportion recall = row.confusion.recall(room);
    if (recall.n == 0) continue;
    text += fmt::format("  {:16} {:.3f} of {}", room, recall.value(), recall.n);
    for (const std::string& answer : row.confusion.rooms()) {
      const auto count = row.confusion.count(room, answer);
      if (answer != room && count > 0) text += fmt::format(", {} {}", count, answer);
    }
    text += "\n";
  }
  return text;
}

Expected<void> add_mistakes(const RuleResult& result, const Pictures& all,
                            RecognitionReportContent& content) {
  for (const pipeline::Judgement& judgement : result.judgements) {
    const LabelledPicture& picture = all.pictures[judgement.picture];
    if (!judgement.named || judgement.best == picture.room) continue;
    if (content.mistakes.size() == kMaxMistakesShown) return {};
    ROOMWISE_TRY(image::ColorImage color, picture.read());
    content.mistakes.push_back({std::move(color), picture.name, result.rule, picture.room,
                                judgement.answer, judgement.why});
  }
  return {};
}

std::vector<std::string> notes_of(const pipeline::RoomEvaluation& evaluation, const Pictures& all) {
  std::vector<std::string> notes = {
      "A room is named where its probability and how well the picture is known reach the "
      "thresholds that were found while learning; the paper's way always names one. The best room "
      "is the most probable one, named or not.",
      evaluation.by_walks ? "Intervals of 95 % resample whole walks."
                          : "Intervals of 95 % resample visits of rooms, not frames: with fewer "
                            "than five walks they do not tell how walks differ."};
  if (!all.never_learned.empty()) {
    notes.push_back(
        fmt::format("Left out, never learned: {}.", fmt::join(all.never_learned, ", ")));
  }
  if (!all.mapped_walks.empty()) {
    notes.push_back(fmt::format("Places were not looked for of what the map was made of: {}.",
                                fmt::join(all.mapped_walks, ", ")));
  }
  return notes;
}

Json to_json(const pipeline::UnknownResult::Share& share) {
  return {{"n", share.decisions},
          {"named", static_cast<double>(share.named) / static_cast<double>(share.decisions)},
          {"auroc", share.area_under_roc}};
}

// What was said of places that were never learned: of all, and of each folder of them.
void add_unknown(const pipeline::UnknownResult& unknown, const std::vector<fs::path>& folders,
                 RecognitionReportContent& content, Answer& answer) {
  const auto say = [&](const std::string& what, const pipeline::UnknownResult::Share& share) {
    const double named = static_cast<double>(share.named) / static_cast<double>(share.decisions);
    answer.text += fmt::format("{:44} {:>5}, {:.3f} got a name; AUROC {:.3f}\n", what,
                               share.decisions, named, share.area_under_roc);
    content.figures.push_back(
        {fmt::format("Decisions, {}", what), std::to_string(share.decisions)});
    content.figures.push_back(
        {fmt::format("Got the name of a room, {}", what), fmt::format("{:.1f} %", 100 * named)});
    content.figures.push_back({fmt::format("AUROC of how well they are known, {}", what),
                               fmt::format("{:.3f}", share.area_under_roc)});
  };
  Json& json = answer.json[unknown.key];
  json = to_json(unknown.all);
  json["answers"] = unknown.answers;
  json["folders"] = Json::object();
  say("never learned, " + unknown.rule, unknown.all);
  for (std::size_t i = 0; i < unknown.walks.size(); ++i) {
    if (unknown.walks[i].decisions == 0) continue;
    json["folders"][folders[i].string()] = to_json(unknown.walks[i]);
    if (folders.size() == 1) continue;  // it is all
    const fs::path name = folders[i].parent_path().filename() / folders[i].filename();
    say(fmt::format("  {}, {}", name.string(), unknown.rule), unknown.walks[i]);
  }
}

Expected<Answer> answer_of(const RoomsEvaluationOptions& options,
                           const pipeline::RoomEvaluation& evaluation, const Pictures& all) {
  RecognitionReportContent content;
  content.title = options.home.stem().string();
  content.notes = notes_of(evaluation, all);
  Answer answer;
  answer.text = fmt::format("{:44} {:>5} {:>26} {:>7} {:>26} {:>8}\n", "", "n",
                            "best room right (95 %)", "named", "of these right (95 %)", "ms");
  for (const RuleResult& result : evaluation.rules) {
    content.rules.push_back(row_of(result, all, evaluation.by_walks));
    answer.text += to_text(content.rules.back());
    answer.json[result.key] = to_json(content.rules.back(), result);
    if (!all.walks.empty()) answer.json[result.key]["walks"] = walks_json(result, all);
  }
  for (const pipeline::UnknownResult& unknown : evaluation.unknown) {
    add_unknown(unknown, options.unknown, content, answer);
  }
  answer.text += confusion_text(content.rules.front());
  for (const std::string& note : content.notes) answer.text += note + "\n";
  answer.text += damage_text(all.damage, "pictures that cannot be read");
  if (options.skip_damaged) answer.json["damaged"] = all.damage;
  answer.json["resampled"] = evaluation.by_walks ? "walks" : "visits";
  answer.json["left_out"] = all.never_learned;
  if (!options.report.empty()) {
    for (const RuleResult& result : evaluation.rules) {
      if (result.key.starts_with("baseline")) continue;
      ROOMWISE_RETURN_IF_ERROR(add_mistakes(result, all, content));
    }
    ROOMWISE_RETURN_IF_ERROR(write_file(options.report, render_recognition_report(content)));
  }
  return answer;
}

// Where the home has a map and a picture has depth.
Expected<std::optional<pipeline::HomePlaces>> places_of(const home::Home& home,
                                                        const RoomsEvaluationOptions& options,
                                                        const Pictures& all,
                                                        pipeline::RunContext& run) {
  ROOMWISE_TRY(const auto placed, pipeline::map_keyframes(home));
  const bool have_depth = std::ranges::any_of(
      all.pictures, [](const LabelledPicture& one) { return one.read_to_locate != nullptr; });
  if (options.without_places || placed.empty() || !have_depth) {
    return std::optional<pipeline::HomePlaces>();
  }
  return pipeline::HomePlaces::create(home, {}, run);
}

// Takes out what cannot be read. A picture that is not there would pass for one that nobody asked
// for, so it must be told to.
Expected<void> leave_out_damaged(bool skip_damaged, Pictures& all, pipeline::RunContext& run) {
  if (!skip_damaged && !all.damage.empty()) {
    return fail("{}{}", all.damage.front(), kNamingSkipDamaged);
  }
  if (!skip_damaged) return {};
  for (auto* const pictures : {&all.pictures, &all.unknown}) {
    ROOMWISE_TRY(const auto damage, pipeline::leave_out_damaged(*pictures, run));
    std::ranges::copy(damage, std::back_inserter(all.damage));
  }
  if (all.pictures.empty()) {
    return fail("none of the pictures can be read; the first: {}", all.damage.front());
  }
  return {};
}

// Tells of each picture that cannot be read how to go on without it.
void name_the_mend(std::vector<LabelledPicture>& pictures) {
  const auto naming = [](auto read) {
    return [read] {
      auto picture = read();
      if (!picture) picture.error().message += kNamingSkipDamaged;
      return picture;
    };
  };
  for (LabelledPicture& picture : pictures) {
    picture.read = naming(picture.read);
    if (picture.read_to_locate) picture.read_to_locate = naming(picture.read_to_locate);
  }
}

Expected<Answer> evaluate(const RoomsEvaluationOptions& options, Context& context) {
  cv::setNumThreads(1);
  if (options.photos.empty() == options.recordings.empty()) {
    return fail("give what to evaluate: either --recording with --labels, or --photos");
  }
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
  ROOMWISE_TRY(const pipeline::Networks networks,
               load_networks(options.networks, &home, /*also_brought=*/true));
  ROOMWISE_TRY(const auto recognizer, pipeline::RoomRecognizer::create(home, networks));
  Pictures all;
  ROOMWISE_RETURN_IF_ERROR(add_pictures(options, home, recognizer.rooms(), context, all));
  CommandRun run(context);
  ROOMWISE_RETURN_IF_ERROR(leave_out_damaged(options.skip_damaged, all, run));
  name_the_mend(all.pictures);
  name_the_mend(all.unknown);
  ROOMWISE_TRY(const auto places, places_of(home, options, all, run));
  ROOMWISE_TRY(pipeline::RoomEvaluation evaluation,
               pipeline::evaluate_rooms(all.pictures, all.unknown, recognizer,
                                        places ? &*places : nullptr, options.evaluation, run));
  if (options.with_baselines) {
    ROOMWISE_TRY(auto baselines, pipeline::baseline_rules(home, all.pictures, evaluation.features,
                                                          recognizer, options.baselines, run));
    std::ranges::move(baselines, std::back_inserter(evaluation.rules));
  }
  return answer_of(options, evaluation, all);
}

void add_measuring_options(CLI::App& command, RoomsEvaluationOptions& options) {
  command.add_flag(kSkipDamaged, options.skip_damaged,
                   "Leave out pictures that cannot be read, and name them; without it the first "
                   "such ends the work");
  add_setting(command, "--margin", options.margin,
              "Leave out frames that are fewer than this from a boundary of their room's range");
  add_setting(command, "--pair-step", options.evaluation.pair_step,
              "Frames between the two pictures of a pair");
  command
      .add_option("--interval", options.evaluation.interval_s,
                  "Seconds between the frames of a walk; default: by their time stamps")
      ->check(positive());
  command.add_option("--unknown", options.unknown,
                     "Folder of pictures of places that were never learned, or a recording of "
                     "another home; may be given several times");
  command.add_flag("--without-places", options.without_places,
                   "Do not search the home's map for pictures that have depth");
  command.add_flag("--baselines", options.with_baselines,
                   "Also measure simple methods on the same frames: colours, nearest features, a "
                   "vote of SIFT features");
  add_setting(
      command, "--max-voted", options.baselines.max_voted_pictures,
      "Maximum number of frames that the vote of SIFT features looks at, spread evenly; 0: none");
  command.add_option("--report", options.report,
                     "Write a page of HTML with all tables and the frames that were wrong");
}

}  // namespace

void add_rooms_eval_command(CLI::App& group, Context& context) {
  const auto [command, options] = add_command<RoomsEvaluationOptions>(
      group, context, "eval",
      "Measure how often rooms are named rightly, beside the paper's way and simple ones",
      "roomwise rooms eval --home my.home --recording evening --recording moved --baselines "
      "--unknown OTHER --report rooms.html",
      evaluate);
  command->add_option("--home", options.home, "Home file")->required();
  command->add_option("--recording", options.recordings,
                      "Folder or file of any kind that is read (docs/recordings.md); may be given "
                      "several times");
  command->add_option("--labels", options.labels,
                      "Its rooms.txt, one for each recording; default: the one in the folder");
  CLI::Option* photos = command->add_option("--photos", options.photos,
                                            "Or: a folder with one folder of photos a room");
  add_selection_options(*command, options.selection);
  add_measuring_options(*command, options);
  for (const char* of_recording : {"--recording", "--labels", "--visits", "--rooms", "--margin"}) {
    photos->excludes(command->get_option(of_recording));
  }
  command->add_option("--network", options.networks.files, "ONNX networks; default: as for map");
  add_precision_option(*command, options.networks);
}

}  // namespace roomwise::app
