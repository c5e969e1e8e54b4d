#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <set>

#include "commands.h"
#include "networks.h"
#include "roomwise/image/codec.h"
#include "roomwise/pipeline/picture_features.h"
#include "roomwise/pipeline/room_evaluation.h"
#include "roomwise/pipeline/room_learning.h"
#include "roomwise/pipeline/room_recognizer.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;

// Which parts of a recording, as the user says it.
struct SelectionOptions {
  std::string visits;
  std::vector<std::string> rooms;
};

void add_selection_options(CLI::App& command, SelectionOptions& options) {
  command.add_option("--visits", options.visits,
                     "Which visits of a room: 1, 2- or 1-3; default: all");
  command.add_option("--rooms", options.rooms, "Which rooms, separated by commas; default: all")
      ->delimiter(',');
}

Expected<pipeline::RoomSelection> parse(const SelectionOptions& options) {
  pipeline::RoomSelection selection;
  selection.rooms = options.rooms;
  if (!options.visits.empty()) {
    ROOMWISE_TRY(selection.visits, pipeline::parse_visits(options.visits));
  }
  return selection;
}

Expected<home::RecordingId> only_recording(const home::Home& home) {
  ROOMWISE_TRY(const auto recordings, home.recordings());
  if (recordings.empty())
    return fail("{}: holds no recording; use roomwise map first", home.file());
  return recordings.back().id;
}

// ---- rooms name ----

struct NameOptions {
  fs::path home;
  fs::path labels;
  std::vector<std::string> frames;  // "0-19=corridor"
  std::vector<std::string> times;   // "12.5-30=kitchen", seconds from the first frame
  std::vector<std::string> types;   // "Anna's room=bedroom"
};

struct NamedSpan {
  std::string first;
  std::string last;
  std::string room;
};

Expected<NamedSpan> parse_span(const std::string& text) {
  const std::size_t equals = text.find('=');
  const std::size_t dash = text.find('-');
  if (equals == std::string::npos || dash == std::string::npos || dash > equals ||
      equals + 1 == text.size()) {
    return fail("'{}' is no range with a name; expected FIRST-LAST=ROOM, for example 0-19=corridor",
                text);
  }
  return NamedSpan{text.substr(0, dash), text.substr(dash + 1, equals - dash - 1),
                   text.substr(equals + 1)};
}

Expected<std::uint64_t> parse_frame(const std::string& text) {
  if (text.empty() || text.size() > 18 ||
      !std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; })) {
    return fail("'{}' is no frame number", text);
  }
  return std::stoull(text);
}

// The ranges on the command line, in the order of frames, each room's visits counted.
Expected<recording::RoomLabels> parse_ranges(const NameOptions& options,
                                             const std::vector<home::Frame>& frames) {
  std::vector<recording::RoomRange> ranges;
  for (const std::string& text : options.frames) {
    ROOMWISE_TRY(const NamedSpan span, parse_span(text));
    ROOMWISE_TRY(const std::uint64_t first, parse_frame(span.first));
    ROOMWISE_TRY(const std::uint64_t last, parse_frame(span.last));
    if (!frames.empty() && last > frames.back().index) {
      return fail("'{}': the recording ends with frame {}", text, frames.back().index);
    }
    ranges.push_back({first, last, span.room, 1});
  }
  for (const std::string& text : options.times) {
    ROOMWISE_TRY(const NamedSpan span, parse_span(text));
    ROOMWISE_TRY(const TimestampNs first_ns, parse_timestamp(span.first));
    ROOMWISE_TRY(const TimestampNs last_ns, parse_timestamp(span.last));
    std::optional<recording::RoomRange> range;
    for (const home::Frame& frame : frames) {
      const TimestampNs since_start_ns = frame.timestamp_ns - frames.front().timestamp_ns;
      if (since_start_ns < first_ns || since_start_ns > last_ns) continue;
      if (!range) range = {frame.index, frame.index, span.room, 1};
      range->last_frame = frame.index;
    }
    if (!range) return fail("'{}': the recording has no frame in that time", text);
    ranges.push_back(*range);
  }
  std::ranges::sort(ranges, {}, &recording::RoomRange::first_frame);
  std::map<std::string, int> visits;
  for (recording::RoomRange& range : ranges) range.visit = ++visits[range.room];
  return recording::RoomLabels::from_ranges(std::move(ranges));
}

Expected<void> set_types(home::Home& home, const std::vector<std::string>& types) {
  if (types.empty()) return {};
  ROOMWISE_TRY(std::vector<rooms::Room> rooms, home.rooms());
  for (const std::string& text : types) {
    const std::size_t equals = text.find('=');
    const auto room = std::ranges::find(rooms, text.substr(0, equals), &rooms::Room::name);
    if (equals == std::string::npos || room == rooms.end()) {
      return fail("'{}' gives no room of this home a type; expected ROOM=TYPE", text);
    }
    room->type = text.substr(equals + 1);
  }
  return home.replace_rooms(rooms);
}

Expected<Answer> name(const NameOptions& options) {
  const bool has_ranges = !options.frames.empty() || !options.times.empty();
  if (has_ranges && !options.labels.empty())
    return fail("give either --labels or ranges, not both");
  if (!has_ranges && options.labels.empty() && options.types.empty()) {
    return fail("nothing to name: give --labels rooms.txt, --frames, --times or --types");
  }
  ROOMWISE_TRY(home::Home home, home::Home::open(options.home));
  if (has_ranges || !options.labels.empty()) {
    ROOMWISE_TRY(const home::RecordingId recording, only_recording(home));
    ROOMWISE_TRY(const auto frames, home.frames(recording));
    ROOMWISE_TRY(const recording::RoomLabels labels,
                 options.labels.empty() ? parse_ranges(options, frames)
                                        : recording::RoomLabels::read(options.labels));
    ROOMWISE_CHECK_OK(pipeline::name_rooms(home, recording, labels));
  }
  ROOMWISE_CHECK_OK(set_types(home, options.types));

  Answer answer;
  answer.json["rooms"] = Json::array();
  ROOMWISE_TRY(const auto rooms, home.rooms());
  for (const rooms::Room& room : rooms) {
    answer.text += fmt::format("{} ({})\n", room.name, room.type);
    answer.json["rooms"].push_back({{"name", room.name}, {"type", room.type}});
  }
  return answer;
}

// ---- rooms learn ----

struct LearnOptions {
  fs::path home;
  fs::path labels;
  fs::path photos;
  SelectionOptions selection;
  int augment = 0;
  NetworkOptions networks;
};

Expected<rooms::LearningReport> learn_photos(const LearnOptions& options, Context& context) {
  ROOMWISE_TRY(const pipeline::Networks networks, load_networks(options.networks));
  ROOMWISE_TRY(const network::Classifier* const network, pipeline::features_network(networks));
  ROOMWISE_CHECK_OK(pipeline::list_room_photos(options.photos));  // before a home is made
  ROOMWISE_TRY(home::Home home, fs::exists(options.home) ? home::Home::open(options.home)
                                                         : pipeline::create_home(options.home));
  ThreadPool pool(context.threads);
  StageClock clock;
  pipeline::RunContext run{pool, context.progress, clock};
  return pipeline::learn_rooms_from_photos(home, options.photos, *network, {{}, options.augment},
                                           run);
}

Expected<rooms::LearningReport> learn_keyframes(const LearnOptions& options, Context& context) {
  ROOMWISE_TRY(home::Home home, home::Home::open(options.home));
  ROOMWISE_TRY(const home::RecordingId recording, only_recording(home));
  if (!options.labels.empty()) {
    ROOMWISE_TRY(const recording::RoomLabels labels, recording::RoomLabels::read(options.labels));
    ROOMWISE_CHECK_OK(pipeline::name_rooms(home, recording, labels));
  }
  ROOMWISE_TRY(const pipeline::RoomSelection selection, parse(options.selection));
  pipeline::Networks networks;  // what they saw in the key-frames themselves is stored
  if (options.augment > 0) {
    ROOMWISE_TRY(networks, load_networks(options.networks));
  }
  ThreadPool pool(context.threads);
  StageClock clock;
  pipeline::RunContext run{pool, context.progress, clock};
  return pipeline::learn_rooms_from_keyframes(home, recording, selection, {{}, options.augment},
                                              networks, run);
}

Expected<Answer> learn(const LearnOptions& options, Context& context) {
  cv::setNumThreads(1);
  if (!options.networks.files.empty() && options.photos.empty() && options.augment == 0) {
    return fail(
        "--network needs --augment or --photos: without them rooms are learned from what the "
        "home keeps of its key-frames, and no network is run");
  }
  ROOMWISE_TRY(const rooms::LearningReport report, options.photos.empty()
                                                       ? learn_keyframes(options, context)
                                                       : learn_photos(options, context));
  Answer answer;
  answer.json["rooms"] = Json::array();
  for (const auto& room : report.rooms) {
    answer.text += fmt::format("{:16} {:5} pictures, {:5} named rightly while held out\n",
                               room.room, room.pictures, room.held_out_correct);
    answer.json["rooms"].push_back({{"room", room.room},
                                    {"pictures", room.pictures},
                                    {"held_out_correct", room.held_out_correct}});
  }
  answer.text += fmt::format("held out: {:.3f} of {} (weight decay {:g})\n",
                             report.held_out_precision, report.held_out, report.weight_decay);
  for (const std::string& warning : report.warnings) answer.text += "warning: " + warning + "\n";
  answer.json["held_out"] = report.held_out;
  answer.json["held_out_precision"] = report.held_out_precision;
  answer.json["weight_decay"] = report.weight_decay;
  answer.json["warnings"] = report.warnings;
  return answer;
}

// ---- rooms recognize ----

struct RecognizeOptions {
  fs::path home;
  fs::path first;
  std::optional<fs::path> second;
  NetworkOptions networks;
};

Expected<Answer> recognize(const RecognizeOptions& options) {
  cv::setNumThreads(1);
  ROOMWISE_TRY(const home::Home home, home::Home::open_read_only(options.home));
  ROOMWISE_TRY(const pipeline::Networks networks, load_networks(options.networks));
  ROOMWISE_TRY(const auto recognizer, pipeline::RoomRecognizer::create(home, networks));
  ROOMWISE_TRY(const image::ColorImage first, image::read_color(options.first));
  std::optional<image::ColorImage> second;
  if (options.second) {
    ROOMWISE_TRY(second, image::read_color(*options.second));
  }
  ROOMWISE_TRY(const rooms::RoomAnswer answer, recognizer.recognize(first, second));
  const std::string how = std::string(to_string(answer.reason)) +
                          (answer.object.empty() ? "" : fmt::format(" ({})", answer.object));
  return Answer{fmt::format("{} ({:.2f}): {}\n", answer.room, answer.score, how),
                {{"room", answer.room}, {"score", answer.score}, {"how", how}}};
}

// ---- rooms eval ----

struct EvalOptions {
  fs::path home;
  fs::path recording;
  fs::path labels;
  fs::path photos;
  SelectionOptions selection;
  std::uint64_t margin = 0;
  std::size_t pair_step = 1;
  NetworkOptions networks;
};

Json to_json(const pipeline::RuleResult& result) {
  const evaluation::Proportion precision = result.confusion.accuracy();
  const evaluation::Interval interval = precision.wilson_interval();
  Json json = {{"n", precision.n},
               {"correct", precision.successes},
               {"precision", precision.value()},
               {"interval", {interval.low, interval.high}},
               {"ms", result.median_ms},
               {"how", result.reasons}};
  for (const std::string& truth : result.confusion.rooms()) {
    for (const std::string& answer : result.confusion.rooms()) {
      if (const auto count = result.confusion.count(truth, answer); count > 0)
        json["confusion"][truth][answer] = count;
    }
  }
  return json;
}

std::string to_text(std::string_view rule, const pipeline::RuleResult& result) {
  const evaluation::Proportion precision = result.confusion.accuracy();
  const evaluation::Interval interval = precision.wilson_interval();
  std::string text =
      fmt::format("{:12} {:.3f} right ({} of {}; 95 % interval {:.3f} to {:.3f}), {:.0f} ms\n",
                  rule, precision.value(), precision.successes, precision.n, interval.low,
                  interval.high, result.median_ms);
  for (const std::string& room : result.confusion.rooms()) {
    const evaluation::Proportion recall = result.confusion.recall(room);
    if (recall.n == 0) continue;
    text += fmt::format("  {:16} {:.3f} of {}", room, recall.value(), recall.n);
    for (const std::string& answer : result.confusion.rooms()) {
      const auto count = result.confusion.count(room, answer);
      if (answer != room && count > 0) text += fmt::format(", {} taken for {}", count, answer);
    }
    text += "\n";
  }
  return text;
}

Expected<Answer> evaluate(const EvalOptions& options, Context& context) {
  cv::setNumThreads(1);
  if (options.photos.empty() == options.recording.empty()) {
    return fail("give what to evaluate: either --recording with --labels, or --photos");
  }
  ROOMWISE_TRY(const home::Home home, home::Home::open_read_only(options.home));
  ROOMWISE_TRY(const pipeline::Networks networks, load_networks(options.networks));
  ROOMWISE_TRY(const auto recognizer, pipeline::RoomRecognizer::create(home, networks));
  std::optional<recording::ImageList> colors;
  std::vector<pipeline::LabelledPicture> pictures;
  std::set<std::string> rooms_there;
  if (!options.photos.empty()) {
    ROOMWISE_TRY(const auto photos, pipeline::list_room_photos(options.photos));
    for (const pipeline::RoomPhoto& photo : photos) rooms_there.insert(photo.room);
    ROOMWISE_TRY(pictures, pipeline::select_photos(options.photos, recognizer.rooms()));
  } else {
    const fs::path file = options.labels.empty() ? options.recording / "rooms.txt" : options.labels;
    ROOMWISE_TRY(const recording::RoomLabels labels, recording::RoomLabels::read(file));
    ROOMWISE_TRY(const pipeline::RoomSelection rooms, parse(options.selection));
    for (const recording::RoomRange& range : labels.ranges()) {
      if (rooms.contains(range)) rooms_there.insert(range.room);
    }
    ROOMWISE_TRY(colors, recording::ImageList::open(options.recording, "rgb.txt"));
    ROOMWISE_TRY(pictures, pipeline::select_frames(*colors, labels, {rooms, options.margin},
                                                   recognizer.rooms()));
  }
  ThreadPool pool(context.threads);
  StageClock clock;
  pipeline::RunContext run{pool, context.progress, clock};
  ROOMWISE_TRY(const pipeline::RoomEvaluation result,
               pipeline::evaluate_rooms(pictures, recognizer, options.pair_step, run));
  for (const std::string& room : recognizer.rooms()) rooms_there.erase(room);
  const std::string left_out = rooms_there.empty() ? ""
                                                   : fmt::format("left out, never learned: {}\n",
                                                                 fmt::join(rooms_there, ", "));
  return Answer{
      to_text("one picture", result.single) + to_text("two pictures", result.pair) + left_out,
      {{"single", to_json(result.single)},
       {"pair", to_json(result.pair)},
       {"left_out", rooms_there}}};
}

void add_home_option(CLI::App& command, fs::path& home) {
  command.add_option("--home", home, "Home file")->required();
}

}  // namespace

void add_rooms_commands(CLI::App& app, Context& context) {
  CLI::App* group = add_group(app, "rooms", "Name, learn and recognise rooms",
                              "roomwise rooms learn --home my.home --labels rooms.txt");
  add_layout_command(*group, context);
  {
    auto options = std::make_shared<NameOptions>();
    CLI::App* command = add_command(
        *group, context, "name", "Name the rooms of a recording, and their types",
        "roomwise rooms name --home my.home --times 0-12.5=hall --times 12.6-40=kitchen",
        [options] { return name(*options); });
    add_home_option(*command, options->home);
    command->add_option("--labels", options->labels,
                        "rooms.txt: a line a range, \"first_frame last_frame room visit\"");
    command->add_option("--frames", options->frames,
                        "FIRST-LAST=ROOM, frame numbers; may be given several times");
    command->add_option(
        "--times", options->times,
        "FIRST-LAST=ROOM, seconds from the first frame; may be given several times");
    command->add_option("--types", options->types,
                        "ROOM=TYPE, for example \"Anna's room=bedroom\"");
  }
  {
    auto options = std::make_shared<LearnOptions>();
    CLI::App* command =
        add_command(*group, context, "learn",
                    "Learn the rooms from a mapped recording, or from photos (one folder a room)",
                    "roomwise rooms learn --home my.home --labels rooms.txt --visits 1",
                    [options, &context] { return learn(*options, context); });
    add_home_option(*command, options->home);
    CLI::Option* labels = command->add_option(
        "--labels", options->labels, "rooms.txt of the recording; default: as named before");
    CLI::Option* photos =
        command->add_option("--photos", options->photos, "Folder with one folder of photos a room");
    add_selection_options(*command, options->selection);
    photos->excludes(labels)
        ->excludes(command->get_option("--visits"))
        ->excludes(command->get_option("--rooms"));
    command
        ->add_option("--augment", options->augment,
                     "Learn from so many varied pictures beside each one: other light, held "
                     "differently. What a network makes of them is kept in the home")
        ->check(CLI::Range(0, pipeline::kMostVariants))
        ->capture_default_str();
    // --labels is the rooms' here, so the networks' own labels come from their cards.
    command->add_option("--network", options->networks.files,
                        "ONNX network to learn on, with --photos; with --augment the one that has "
                        "looked at the key-frames. Default: as for map");
  }
  {
    auto options = std::make_shared<RecognizeOptions>();
    CLI::App* command =
        add_command(*group, context, "recognize", "Say the room that one or two pictures show",
                    "roomwise rooms recognize --home my.home a.jpg b.jpg",
                    [options] { return recognize(*options); });
    add_home_option(*command, options->home);
    command->add_option("A", options->first, "First picture")->required();
    command->add_option("B", options->second, "Second picture");
    add_network_options(*command, options->networks);
  }
  {
    auto options = std::make_shared<EvalOptions>();
    CLI::App* command = add_command(*group, context, "eval",
                                    "Measure how often one picture, and two, name the right room",
                                    "roomwise rooms eval --home my.home --recording walk --labels "
                                    "rooms.txt --visits 2- --margin 3",
                                    [options, &context] { return evaluate(*options, context); });
    add_home_option(*command, options->home);
    command->add_option("--recording", options->recording, "Folder in TUM's format");
    command->add_option("--labels", options->labels,
                        "Its rooms.txt; default: the one in the folder");
    CLI::Option* photos = command->add_option("--photos", options->photos,
                                              "Or: a folder with one folder of photos a room");
    add_selection_options(*command, options->selection);
    command
        ->add_option(
            "--margin", options->margin,
            "Leave out frames that are fewer than this from a boundary of their room's range")
        ->capture_default_str();
    command
        ->add_option("--pair-step", options->pair_step, "Frames between the two pictures of a pair")
        ->capture_default_str();
    for (const char* of_recording :
         {"--recording", "--labels", "--visits", "--rooms", "--margin"}) {
      photos->excludes(command->get_option(of_recording));
    }
    command->add_option("--network", options->networks.files, "ONNX networks; default: as for map");
  }
}

}  // namespace roomwise::app
