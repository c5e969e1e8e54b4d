#include <algorithm>
#include <filesystem>
#include <opencv2/core.hpp>

#include "camera_option.h"
#include "command_run.h"
#include "commands.h"
#include "home/command_line_author.h"
#include "networks.h"
#include "open_home.h"
#include "rooms/rooms_options.h"
#include "roomwise/image/codec.h"
#include "roomwise/pipeline/edits/edit_rooms.h"
#include "roomwise/pipeline/rooms/home_places.h"
#include "roomwise/pipeline/rooms/picture_features.h"
#include "roomwise/pipeline/rooms/room_learning.h"
#include "roomwise/pipeline/rooms/room_recognizer.h"
#include "roomwise/pipeline/rooms/turn_hint.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;

// ---- rooms name ----

struct NameOptions {
  fs::path home;
  std::string walk;
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
  std::map<std::string, int> stays;
  for (recording::RoomRange& range : ranges) range.stay = ++stays[range.room];
  return recording::RoomLabels::from_ranges(std::move(ranges));
}

Expected<void> set_types(home::Home& home, const std::vector<std::string>& types) {
  if (types.empty()) return {};
  ROOMWISE_TRY(const std::vector<rooms::Room> rooms, home.rooms());
  for (const std::string& text : types) {
    const std::size_t equals = text.find('=');
    const auto room = std::ranges::find(rooms, text.substr(0, equals), &rooms::Room::name);
    if (equals == std::string::npos || room == rooms.end()) {
      return fail("'{}' gives no room of this home a type; expected ROOM=TYPE", text);
    }
    const std::string type = text.substr(equals + 1);
    if (room->type == type) continue;
    ROOMWISE_RETURN_IF_ERROR(
        pipeline::set_room_type(home, command_line_author(), room->name, type));
  }
  return {};
}

Expected<Answer> name(const NameOptions& options, Context& context) {
  const bool has_ranges = !options.frames.empty() || !options.times.empty();
  if (has_ranges && !options.labels.empty())
    return fail("give either --labels or ranges, not both");
  if (!has_ranges && options.labels.empty() && options.types.empty()) {
    return fail("nothing to name: give --labels rooms.txt, --frames, --times or --types");
  }
  ROOMWISE_TRY(home::Home home, open_home(options.home, context));
  if (has_ranges || !options.labels.empty()) {
    ROOMWISE_TRY(const home::RecordingId recording, find_walk(home, options.walk));
    ROOMWISE_TRY(const auto frames, home.frames(recording));
    ROOMWISE_TRY(const recording::RoomLabels labels,
                 options.labels.empty() ? parse_ranges(options, frames)
                                        : recording::RoomLabels::read(options.labels));
    ROOMWISE_RETURN_IF_ERROR(pipeline::name_frames(home, command_line_author(), recording, labels));
  }
  ROOMWISE_RETURN_IF_ERROR(set_types(home, options.types));

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
  std::vector<std::string> walks;
  SelectionOptions selection;
  int augment = 2;
  NetworkOptions networks;
};

struct HomeOfPhotos {
  home::Home home;
  pipeline::Networks networks;
};

Expected<HomeOfPhotos> open_for_photos(const LearnOptions& options,
                                       std::span<const pipeline::RoomPhoto> photos,
                                       Context& context) {
  ROOMWISE_TRY(const home::OpenOptions open, open_options(context));
  ROOMWISE_TRY(home::Home home, fs::exists(options.home)
                                    ? home::Home::open(options.home, open)
                                    : pipeline::create_home(options.home, open));
  const auto photo = [&](std::size_t i) { return image::read_color(photos[i].path); };
  ROOMWISE_TRY(pipeline::Networks networks,
               load_networks_for_new(options.networks, home, photos.size(), photo, context));
  ROOMWISE_RETURN_IF_ERROR(pipeline::features_network(networks));
  return HomeOfPhotos{std::move(home), std::move(networks)};
}

Expected<rooms::LearningReport> learn_photos(const LearnOptions& options, Context& context) {
  ROOMWISE_TRY(const auto photos, pipeline::list_room_photos(options.photos));
  const bool is_new = !fs::exists(options.home);
  auto opened = open_for_photos(options, photos, context);
  if (!opened) {
    std::error_code ignored;
    if (is_new) fs::remove(options.home, ignored);  // it holds nothing yet
    return Unexpected(std::move(opened).error());
  }
  ROOMWISE_TRY(const network::Classifier* const network,
               pipeline::features_network(opened->networks));
  CommandRun run(context);
  return pipeline::learn_rooms_from_photos(opened->home, options.photos, *network,
                                           {.variants = options.augment}, run);
}

Expected<rooms::LearningReport> learn_keyframes(const LearnOptions& options, Context& context) {
  ROOMWISE_TRY(home::Home home, open_home(options.home, context));
  pipeline::RoomLearning learning{.variants = options.augment};
  for (const std::string& name : options.walks) {
    ROOMWISE_TRY(learning.walks.emplace_back(), find_walk(home, name));
  }
  if (!options.labels.empty()) {
    if (options.walks.size() > 1)
      return fail("--labels names the rooms of one walk; --walks gives {}", options.walks.size());
    ROOMWISE_TRY(const home::RecordingId walk,
                 find_walk(home, options.walks.empty() ? "" : options.walks.front()));
    ROOMWISE_TRY(const recording::RoomLabels labels, recording::RoomLabels::read(options.labels));
    ROOMWISE_RETURN_IF_ERROR(pipeline::name_frames(home, command_line_author(), walk, labels));
  }
  ROOMWISE_TRY(const pipeline::RoomSelection selection, parse(options.selection));
  pipeline::Networks networks;  // what they saw in the key-frames themselves is stored
  if (options.augment > 0) {
    ROOMWISE_TRY(networks, load_networks(options.networks, &home, /*also_brought=*/true));
  }
  CommandRun run(context);
  return pipeline::learn_rooms_from_keyframes(home, selection, learning, networks, run);
}

Answer to_answer(const rooms::LearningReport& report) {
  Answer answer;
  answer.json["rooms"] = Json::array();
  for (const auto& room : report.rooms) {
    answer.text += fmt::format(
        "{:16} {:5} pictures, {:5} named rightly while held out ({} by the "
        "paper's regression)\n",
        room.room, room.pictures, room.held_out_correct, room.paper_held_out_correct);
    answer.json["rooms"].push_back({{"room", room.room},
                                    {"pictures", room.pictures},
                                    {"held_out_correct", room.held_out_correct},
                                    {"paper_held_out_correct", room.paper_held_out_correct}});
  }
  answer.text += fmt::format(
      "held out: {:.3f} of {} ({:.3f} by the paper's regression, weight decay {:g})\n"
      "a room is named from a probability of {:.2f} on\n",
      report.held_out_precision(), report.held_out, report.paper_held_out_precision,
      report.weight_decay, report.min_probability);
  for (const std::string& warning : report.warnings) answer.text += "warning: " + warning + "\n";
  answer.json["held_out"] = report.held_out;
  answer.json["held_out_precision"] = report.held_out_precision();
  answer.json["paper_held_out_precision"] = report.paper_held_out_precision;
  answer.json["weight_decay"] = report.weight_decay;
  answer.json["sure_from"] = report.min_probability;
  answer.json["warnings"] = report.warnings;
  return answer;
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
  return to_answer(report);
}

// ---- rooms recognize ----

struct RecognizeOptions {
  fs::path home;
  std::vector<fs::path> pictures;
  std::vector<fs::path> depths;
  std::string camera;
  std::string rule = "default";
  std::optional<double> interval_s;
  NetworkOptions networks;
};

Json to_json(const std::vector<rooms::RoomScore>& scores) {
  Json json = Json::array();
  for (const rooms::RoomScore& score : scores) {
    json.push_back({{"room", score.room}, {"probability", score.score}});
  }
  return json;
}

std::string said_of(const rooms::RoomDecision& decision) {
  if (decision.verdict == rooms::Verdict::kEither) {
    return fmt::format("{} or {}", decision.rooms[0].room, decision.rooms[1].room);
  }
  return decision.room().value_or(std::string(to_string(decision.verdict)));
}

Answer to_answer(const rooms::RoomDecision& decision, const std::string& hint) {
  const std::string said = said_of(decision);
  Answer answer{fmt::format("{}: {}\n", said, decision.why),
                {{"verdict", to_string(decision.verdict)},
                 {"room", decision.room() ? Json(*decision.room()) : Json(nullptr)},
                 {"score", decision.rooms.front().score},
                 {"known", decision.familiarity},
                 {"how", decision.why},
                 {"rooms", to_json(decision.rooms)}}};
  if (!decision.object.empty()) answer.json["object"] = decision.object;
  if (!hint.empty()) {
    answer.text += hint + "\n";
    answer.json["hint"] = hint;
  }
  return answer;
}

Expected<Answer> recognize_by_paper(const pipeline::RoomRecognizer& recognizer,
                                    std::span<const image::ColorImage> pictures) {
  if (pictures.size() > 2) return fail("the paper's rule takes one or two pictures");
  std::optional<image::ColorImage> second;
  if (pictures.size() == 2) second = pictures[1];
  ROOMWISE_TRY(const rooms::RoomAnswer answer, recognizer.paper_recognize(pictures[0], second));
  const std::string how = std::string(to_string(answer.reason)) +
                          (answer.object.empty() ? "" : fmt::format(" ({})", answer.object));
  return Answer{fmt::format("{} ({:.2f}): {}\n", answer.room, answer.score, how),
                {{"room", answer.room}, {"score", answer.score}, {"how", how}}};
}

// The pictures with their depth, to be looked for on the home's map; none where no depth is given.
Expected<std::vector<pipeline::PictureToLocate>> read_to_locate(
    const RecognizeOptions& options, std::span<const image::ColorImage> pictures,
    const home::Home& home) {
  std::vector<pipeline::PictureToLocate> to_locate;
  if (options.depths.empty()) return to_locate;
  if (options.depths.size() != pictures.size()) {
    return fail("{} pictures and {} depth images; give a depth image for every picture or none",
                pictures.size(), options.depths.size());
  }
  ROOMWISE_TRY(const auto recordings, home.recordings());
  if (recordings.empty()) return fail("{}: has no map on which --depth could help", home.file());
  ROOMWISE_TRY(const auto given, given_camera(options.camera));
  const geometry::PinholeCamera camera = given.value_or(recordings.front().recording.camera);
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    ROOMWISE_TRY(image::DepthImage depth, image::read_depth(options.depths[i]));
    to_locate.push_back({pictures[i], std::move(depth), camera});
  }
  return to_locate;
}

// Pictures of a walk, `interval_s` apart; the answer is that after the last one. `to_locate`: the
// same with depth, or empty.
Expected<rooms::RoomDecision> recognize_walk(const pipeline::RoomRecognizer& recognizer,
                                             std::span<const image::ColorImage> pictures,
                                             double interval_s, const pipeline::HomePlaces* places,
                                             std::span<const pipeline::PictureToLocate> to_locate) {
  rooms::RoomStream stream = recognizer.stream();
  rooms::RoomDecision decision;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    ROOMWISE_TRY(const network::Prediction seen, recognizer.features().predict(pictures[i]));
    ROOMWISE_TRY(const rooms::PictureEvidence evidence, recognizer.evidence(seen));
    pipeline::RoomRecognizer::Localize localize;
    if (places != nullptr) {
      localize = [&] { return places->look(to_locate.subspan(i, 1), recognizer.rooms()); };
    }
    ROOMWISE_TRY(decision, recognizer.update(stream, evidence, interval_s, localize));
  }
  return decision;
}

// Of two pictures or more the place of the last one, by it and the one before.
Expected<rooms::RoomDecision> recognize_at_once(
    const pipeline::RoomRecognizer& recognizer, std::span<const image::ColorImage> pictures,
    const pipeline::HomePlaces* places, std::span<const pipeline::PictureToLocate> to_locate) {
  if (places == nullptr) return recognizer.recognize(pictures);
  return recognizer.recognize(pictures, [&] {
    return places->look(to_locate.last(std::min<std::size_t>(2, to_locate.size())),
                        recognizer.rooms());
  });
}

Expected<Answer> recognize(const RecognizeOptions& options, Context& context) {
  cv::setNumThreads(1);
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
  ROOMWISE_TRY(const pipeline::Networks networks,
               load_networks(options.networks, &home, /*also_brought=*/true));
  ROOMWISE_TRY(const auto recognizer, pipeline::RoomRecognizer::create(home, networks));
  std::vector<image::ColorImage> pictures;
  for (const fs::path& file : options.pictures) {
    ROOMWISE_TRY(pictures.emplace_back(), image::read_color(file));
  }
  if (options.rule == "paper" && (options.interval_s || !options.depths.empty())) {
    return fail(
        "--walk and --depth go with the default rule; the paper's looks at one picture, or at two");
  }
  if (options.rule == "paper") return recognize_by_paper(recognizer, pictures);
  ROOMWISE_TRY(const auto to_locate, read_to_locate(options, pictures, home));
  std::optional<pipeline::HomePlaces> places;
  if (!to_locate.empty()) {
    CommandRun run(context);
    ROOMWISE_TRY(places, pipeline::HomePlaces::create(home, {}, run));
  }
  const pipeline::HomePlaces* const asked = places ? &*places : nullptr;
  ROOMWISE_TRY(const rooms::RoomDecision decision,
               options.interval_s
                   ? recognize_walk(recognizer, pictures, *options.interval_s, asked, to_locate)
                   : recognize_at_once(recognizer, pictures, asked, to_locate));
  const bool asks =
      decision.verdict == rooms::Verdict::kNotSure || decision.verdict == rooms::Verdict::kEither;
  return to_answer(decision, asks ? pipeline::turn_hint(pictures.back()) : "");
}

void add_home_option(CLI::App& command, fs::path& home) {
  command.add_option("--home", home, "Home file")->required();
}

}  // namespace

void add_rooms_commands(CLI::App& app, Context& context) {
  CLI::App* group = add_group(app, "rooms", "Name, learn and recognise rooms",
                              "roomwise rooms learn --home my.home --labels rooms.txt");
  add_layout_command(*group, context);
  add_coverage_command(*group, context);
  add_room_objects_commands(*group, context);
  {
    const auto [command, options] = add_command<NameOptions>(
        *group, context, "name", "Name the rooms of a recording, and their types",
        "roomwise rooms name --home my.home --times 0-12.5=hall --times 12.6-40=kitchen", name);
    add_home_option(*command, options.home);
    command->add_option("--walk", options.walk, "Name of the walk; default: the newest");
    command->add_option("--labels", options.labels,
                        "rooms.txt: a line a range, \"first_frame last_frame room visit\"");
    command->add_option("--frames", options.frames,
                        "FIRST-LAST=ROOM, frame numbers; may be given several times");
    command->add_option(
        "--times", options.times,
        "FIRST-LAST=ROOM, seconds from the first frame; may be given several times");
    command->add_option("--types", options.types, "ROOM=TYPE, for example \"Anna's room=bedroom\"");
  }
  {
    const auto [command, options] = add_command<LearnOptions>(
        *group, context, "learn",
        "Learn the rooms from a mapped recording, or from photos (one folder a room)",
        "roomwise rooms learn --home my.home --labels rooms.txt --visits 1", learn);
    add_home_option(*command, options.home);
    CLI::Option* labels = command->add_option("--labels", options.labels,
                                              "rooms.txt of the walk; default: as named before");
    CLI::Option* walks =
        command
            ->add_option("--walks", options.walks,
                         "Names of the walks to learn from, separated by commas; default: all "
                         "whose rooms are named")
            ->delimiter(',');
    CLI::Option* photos =
        command->add_option("--photos", options.photos, "Folder with one folder of photos a room");
    add_selection_options(*command, options.selection);
    photos->excludes(labels)
        ->excludes(walks)
        ->excludes(command->get_option("--visits"))
        ->excludes(command->get_option("--rooms"));
    add_setting(*command, "--augment", options.augment,
                "Also learn from this many varied copies of each picture: other light, held "
                "differently. What a network makes of them is kept in the home; with 0 no "
                "network is run for key-frames",
                CLI::Range(0, pipeline::kMaxVariants));
    // --labels is the rooms' here, so the networks' own labels come from their cards.
    command->add_option("--network", options.networks.files,
                        "ONNX network to learn on, with --photos; with --augment the one that has "
                        "looked at the key-frames. Default: as for map");
    add_precision_option(*command, options.networks);
  }
  {
    const auto [command, options] = add_command<RecognizeOptions>(
        *group, context, "recognize", "Say the room that pictures show, or that it is not sure",
        "roomwise rooms recognize --home my.home a.jpg b.jpg", recognize);
    add_home_option(*command, options.home);
    command->add_option("PICTURES", options.pictures, "Pictures of one place, one or more")
        ->required();
    CLI::Option* const depth = command->add_option(
        "--depth", options.depths,
        "A picture's depth image (16-bit PNG, registered to it); given once for "
        "each picture: where they were taken on the home's map counts too. Making the map "
        "ready takes up to a minute");
    add_camera_option(*command, options.camera, "that of the home's recording")->needs(depth);
    add_setting(*command, "--rule", options.rule,
                "\"paper\": the paper's rule of one or two frames, which always names a room",
                CLI::IsMember({"default", "paper"}));
    command
        ->add_option("--walk", options.interval_s,
                     "The pictures were taken on a walk, this many seconds apart; the answer is "
                     "the one after the last picture")
        ->check(positive());
    add_network_options(*command, options.networks);
  }
  add_rooms_eval_command(*group, context);
}

}  // namespace roomwise::app
