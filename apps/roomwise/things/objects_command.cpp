#include <algorithm>
#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>

#include "command_run.h"
#include "commands.h"
#include "networks.h"
#include "open_home.h"
#include "pose_json.h"
#include "roomwise/base/shell_word.h"
#include "roomwise/home/home.h"
#include "roomwise/network/vision/open_vocabulary.h"
#include "roomwise/pipeline/objects/find_word.h"
#include "roomwise/pipeline/objects/home_things.h"
#include "roomwise/pipeline/objects/keyframe_observer.h"
#include "roomwise/pipeline/objects/proposal_detection.h"
#include "roomwise/pipeline/stored/map_settings.h"
#include "roomwise/pipeline/stored/stored_map.h"
#include "roomwise/pipeline/stored/stored_rooms.h"
#include "things/history_words.h"
#include "things/thing_places.h"

namespace roomwise::app {
namespace {

struct ObjectsOptions {
  std::filesystem::path home;
  std::string rule = "regions";
  bool past = false;
  NetworkOptions networks;
};

// What stands over the columns of things, as wide as their longest words.
struct Columns {
  std::size_t name = 4, room = 4;

  [[nodiscard]] std::string header() const {
    return fmt::format("{:<{}}  {:<{}}  sure   {:<24}  {:<9}  {:<20}  seen in key-frames; best\n",
                       "name", name, "room", room, "x, y, z in the map, m", "+-, m", "size, m");
  }
};

void add(Answer& answer, const objects::ConfirmedObject& object, const ThingPlaces& places) {
  const home::Keyframe& keyframe = places.keyframes.at(object.keyframe_id);
  const std::string room = places.room_of(object.keyframe_id);
  std::optional<Eigen::Vector3d> position;
  if (object.position_keyframe) {
    position = keyframe.pose.world_from_keyframe * *object.position_keyframe;
  }
  answer.text += fmt::format(
      "{:<16} {:.2f}  in {} key-frames, best {} (frame {})  {}{}\n", object.name, object.score,
      object.observations, object.keyframe_id, keyframe.frame_index,
      position
          ? fmt::format("at {:.2f} {:.2f} {:.2f} m", position->x(), position->y(), position->z())
          : "place not known",
      room.empty() ? "" : ", " + room);
  answer.json["objects"].push_back({{"name", object.name},
                                    {"score", object.score},
                                    {"sightings", object.observations},
                                    {"keyframe", object.keyframe_id},
                                    {"frame", keyframe.frame_index},
                                    {"piece", keyframe.pose.component},
                                    {"position_world_m", position ? xyz(*position) : Json(nullptr)},
                                    {"room", word_or_null(room)}});
}

// Of when a thing was seen, and by which walks; nothing of what none of them showed.
Json seen_json(const objects::Instance& instance, const HistoryWords& words) {
  const pipeline::ThingHistory* const history = words.history().of(instance);
  if (history == nullptr) {
    return {{"first_seen", nullptr}, {"last_seen", nullptr}, {"walks", Json::array()}};
  }
  return {{"first_seen", words.sighting_json(history->first_seen)},
          {"last_seen", words.sighting_json(history->last_seen)},
          {"walks", words.events_json(*history)}};
}

void add(Answer& answer, const pipeline::HomeThing& instance, const ThingPlaces& places,
         const HistoryWords& words, const Columns& columns) {
  const home::Keyframe& keyframe = places.keyframes.at(instance.keyframe_id);
  const std::string room = places.room_of(instance);
  const geometry::OrientedBox box = instance.box_world(keyframe.pose.world_from_keyframe);
  const Eigen::Vector3d& at = box.center();
  answer.text += fmt::format(
      "{:<{}}  {:<{}}  {:.2f}   {:<24}  {:<9}  {:<20}  {} of {}; {} (frame {}){}{}\n",
      instance.name, columns.name, room.empty() ? "-" : room, columns.room, instance.probability,
      fmt::format("{:.2f} {:.2f} {:.2f}", at.x(), at.y(), at.z()),
      fmt::format("{:.2f}", instance.sigma_m.maxCoeff()),
      fmt::format("{:.2f} x {:.2f} x {:.2f}", box.size_m.x(), box.size_m.y(), box.size_m.z()),
      instance.observations, instance.expected, instance.keyframe_id, keyframe.frame_index,
      instance.is_confirmed ? ", by hand" : "",
      instance.note.empty() ? "" : fmt::format(", note: {}", instance.note));
  const network::PixelBox& picture = instance.picture_box;
  answer.json["objects"].push_back(
      {{"name", instance.name},
       {"probability", instance.probability},
       {"names", instance.names},
       {"sightings", instance.observations},
       {"expected", instance.expected},
       {"keyframe", instance.keyframe_id},
       {"frame", keyframe.frame_index},
       {"picture_box_px", {picture.left, picture.top, picture.right, picture.bottom}},
       {"piece", keyframe.pose.component},
       {"position_world_m", xyz(at)},
       {"rotation_world_xyzw", xyzw(box.world_from_box.rotation)},
       {"size_m", xyz(box.size_m)},
       {"sigma_m", xyz(instance.sigma_m)},
       {"room", word_or_null(room)},
       {"by_hand", instance.is_confirmed},
       {"note", word_or_null(instance.note)}});
  answer.json["objects"].back().update(seen_json(instance, words));
}

Expected<Answer> list_found(const home::Home& home, const std::string& rule, Context& context) {
  ROOMWISE_TRY(ThingPlaces places, ThingPlaces::read(home));
  Answer answer;
  answer.json = {{"rule", rule}, {"objects", Json::array()}};
  if (rule == "paper") {
    ROOMWISE_TRY(const auto objects, home.confirmed_objects());
    for (const objects::ConfirmedObject& object : objects) add(answer, object, places);
  } else {
    ROOMWISE_TRY(const auto finders, home.region_finders());
    if (finders.empty()) {
      answer.text = fmt::format(
          "no detector has looked at this home; let one: roomwise objects find --home {}\n",
          shell_word(home.file()));
    }
    ROOMWISE_TRY(const pipeline::HomeThings things, pipeline::find_home_things(home));
    ROOMWISE_TRY(const HistoryWords words, HistoryWords::of(home));
    if (!things.things.empty()) ROOMWISE_RETURN_IF_ERROR(places.find_layout(home, context));
    Columns columns;
    for (const pipeline::HomeThing& one : things.things) {
      columns.name = std::max(columns.name, one.name.size());
      columns.room = std::max(columns.room, places.room_of(one).size());
    }
    if (!things.things.empty()) answer.text += columns.header();
    for (const pipeline::HomeThing& one : things.things) add(answer, one, places, words, columns);
  }
  if (answer.text.empty()) answer.text = "no objects were found in this home\n";
  return answer;
}

void add(Answer& answer, const home::PastInstance& past, const home::Visit& noticed_by,
         const ThingPlaces& places) {
  const objects::Instance& thing = past.instance;
  const home::Keyframe& keyframe = places.keyframes.at(thing.keyframe_id);
  const std::string room = places.room_of(thing.keyframe_id);
  const std::string became = past.reason == home::PastReason::kRemoved ? "gone" : "moved";
  const Eigen::Vector3d at = thing.box_world(keyframe.pose.world_from_keyframe).center();
  answer.text += fmt::format(
      "{:<16} {:<5}  stood at {:.2f} {:.2f} {:.2f} m{}; seen from {} to {} s; noticed by {}\n",
      thing.name, became, at.x(), at.y(), at.z(), room.empty() ? "" : ", " + room,
      format_timestamp(past.first_seen_ns), format_timestamp(past.last_seen_ns), noticed_by.name);
  answer.json["past"].push_back({{"name", thing.name},
                                 {"became", became},
                                 {"first_seen_s", seconds_between(0, past.first_seen_ns)},
                                 {"last_seen_s", seconds_between(0, past.last_seen_ns)},
                                 {"noticed_by", past.noticed_by},
                                 {"noticed_by_walk", nullptr},
                                 {"piece", keyframe.pose.component},
                                 {"position_world_m", xyz(at)},
                                 {"room", word_or_null(room)}});
}

// The same of what a walk that joined the map found gone.
void add(Answer& answer, const pipeline::ThingHistory& gone, const HistoryWords& words,
         const ThingPlaces& places) {
  const objects::Instance& thing = gone.thing;
  const home::Keyframe& keyframe = places.keyframes.at(thing.keyframe_id);
  const std::string room = words.room(gone);
  const std::string& noticed_by = words.walks().name(gone.events.back().walk);
  const Eigen::Vector3d at = thing.box_world(keyframe.pose.world_from_keyframe).center();
  answer.text += fmt::format(
      "{:<16} {:<5}  stood at {:.2f} {:.2f} {:.2f} m{}; seen from {} to {} s; noticed by {}\n",
      thing.name, "gone", at.x(), at.y(), at.z(), room.empty() ? "" : ", " + room,
      format_timestamp(gone.first_seen.time_ns), format_timestamp(gone.last_seen.time_ns),
      noticed_by);
  answer.json["past"].push_back({{"name", thing.name},
                                 {"became", "gone"},
                                 {"first_seen_s", seconds_between(0, gone.first_seen.time_ns)},
                                 {"last_seen_s", seconds_between(0, gone.last_seen.time_ns)},
                                 {"noticed_by", nullptr},
                                 {"noticed_by_walk", noticed_by},
                                 {"piece", keyframe.pose.component},
                                 {"position_world_m", xyz(at)},
                                 {"room", word_or_null(room)}});
}

// What stands there no more, in the order in which that was noticed, and the visits.
Expected<Answer> list_past(const home::Home& home, Context& context) {
  ROOMWISE_TRY(ThingPlaces places, ThingPlaces::read(home));
  ROOMWISE_TRY(const auto visits, home.visits());
  ROOMWISE_TRY(const auto past, home.past_instances());
  ROOMWISE_TRY(HistoryWords words, HistoryWords::of(home));
  if (std::ranges::any_of(words.history().things, &pipeline::ThingHistory::is_gone))
    ROOMWISE_RETURN_IF_ERROR(places.find_layout(home, context));
  words.place_by([&](const pipeline::HomeThing& thing) { return places.room_of(thing); });
  Answer answer;
  answer.json = {{"past", Json::array()}, {"visits", Json::array()}};
  for (const pipeline::ThingHistory& one : words.history().things) {
    if (one.is_gone) add(answer, one, words, places);
  }
  for (const home::PastInstance& one : past) add(answer, one, visits.at(one.noticed_by), places);
  for (const auto& [id, visit] : visits) {
    answer.json["visits"].push_back({{"visit", id},
                                     {"name", visit.name},
                                     {"folder", visit.folder},
                                     {"first_s", seconds_between(0, visit.first_timestamp_ns)},
                                     {"last_s", seconds_between(0, visit.last_timestamp_ns)},
                                     {"frames", visit.frames},
                                     {"placed", visit.placed}});
  }
  if (answer.text.empty()) {
    answer.text = fmt::format(
        "no later walk noticed that a thing moved or went; compare one with this home: roomwise "
        "update --home {} RECORDING\n",
        shell_word(home.file()));
  }
  return answer;
}

Expected<Answer> list(const ObjectsOptions& options, Context& context) {
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
  return options.past ? list_past(home, context) : list_found(home, options.rule, context);
}

// ---- objects history ----

struct ObjectHistoryOptions {
  std::filesystem::path home;
  std::string name;  // of things; empty: all
};

void add(Answer& answer, const pipeline::ThingHistory& one, const HistoryWords& words) {
  answer.text += words.line(one) + "\n";
  answer.json["things"].push_back({{"name", one.thing.name},
                                   {"room", word_or_null(words.room(one))},
                                   {"gone", one.is_gone},
                                   {"first_seen", words.sighting_json(one.first_seen)},
                                   {"last_seen", words.sighting_json(one.last_seen)},
                                   {"walks", words.events_json(one)},
                                   {"visit", nullptr}});
}

// One that a visit brought (update), or somebody by hand.
void add_without_history(Answer& answer, const pipeline::HomeThing& one,
                         const std::map<home::VisitId, home::Visit>& visits,
                         const ThingPlaces& places) {
  const std::string room = places.room_of(one);
  const std::string visit = one.visit != 0 ? visits.at(one.visit).name : "";
  answer.text += fmt::format("{}{}: {}\n", one.name, room.empty() ? "" : ", " + room,
                             one.added_by_edit != 0 ? "somebody added it by hand"
                             : visit.empty()        ? "no walk is known to have found it"
                                                    : "stands there since the visit " + visit);
  answer.json["things"].push_back({{"name", one.name},
                                   {"room", word_or_null(room)},
                                   {"gone", false},
                                   {"first_seen", nullptr},
                                   {"last_seen", nullptr},
                                   {"walks", Json::array()},
                                   {"visit", word_or_null(visit)}});
}

// What the newest walk changed, in words.
std::string newest_changes(const HistoryWords& words) {
  const auto& walks = words.history().walks;
  if (walks.size() < 2) return "one walk alone is on the map: nothing can have changed\n";
  const auto changes = words.changes(walks.back());
  std::string text = fmt::format("since {}, {} found {}\n", words.walks().name(walks.end()[-2]),
                                 words.walks().name(walks.back()),
                                 changes.empty() ? "nothing changed" : "changed:");
  for (const std::string& one : changes) text += "  " + one + "\n";
  return text;
}

Expected<Answer> tell_history(const ObjectHistoryOptions& options, Context& context) {
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
  ROOMWISE_TRY(HistoryWords words, HistoryWords::of(home));
  ROOMWISE_TRY(ThingPlaces places, ThingPlaces::read(home));
  ROOMWISE_RETURN_IF_ERROR(places.find_layout(home, context));
  words.place_by([&](const pipeline::HomeThing& thing) { return places.room_of(thing); });
  ROOMWISE_TRY(const auto visits, home.visits());
  ROOMWISE_TRY(const auto past, home.past_instances());
  const auto& walks = words.history().walks;
  const auto is_asked = [&](const std::string& name) {
    return options.name.empty() || name == options.name;
  };
  Answer answer;
  answer.json = {{"walks", Json::array()},
                 {"changed_by_newest", Json::array()},
                 {"things", Json::array()},
                 {"past", Json::array()}};
  for (const home::RecordingId walk : walks) {
    answer.json["walks"].push_back(words.walks().name(walk));
  }
  if (walks.size() > 1) answer.json["changed_by_newest"] = words.changes_json(walks.back());
  ROOMWISE_TRY(const pipeline::HomeThings things, pipeline::find_home_things(home));
  for (const pipeline::HomeThing& one : things.things) {
    if (!is_asked(one.name)) continue;
    if (const pipeline::ThingHistory* history = words.history().of(one)) {
      add(answer, *history, words);
    } else {
      add_without_history(answer, one, visits, places);
    }
  }
  for (const pipeline::ThingHistory& one : words.history().things) {
    if (one.is_gone && is_asked(one.thing.name)) add(answer, one, words);
  }
  for (const home::PastInstance& one : past) {
    if (is_asked(one.instance.name)) add(answer, one, visits.at(one.noticed_by), places);
  }
  if (answer.text.empty()) {
    return options.name.empty()
               ? fail("{}: nothing was found in this home; look: roomwise objects find --home {}",
                      home.file(), shell_word(home.file()))
               : fail(
                     "{}: no walk showed a thing called {}; see what there is: roomwise objects "
                     "list --home {}",
                     home.file(), options.name, shell_word(home.file()));
  }
  if (options.name.empty()) answer.text += newest_changes(words);
  return answer;
}

// ---- objects find-word ----

struct FindWordOptions {
  std::filesystem::path home;
  std::string word;
};

Expected<Answer> find_word(const FindWordOptions& options, Context& context) {
  if (options.word.find_first_not_of(" \t\n") == std::string::npos) {
    return fail("the word is empty; give what is looked for: roomwise objects find-word accordion");
  }
  ROOMWISE_TRY(const auto networks, load_open_vocabulary());
  ROOMWISE_TRY(const network::Embedding word, networks->embed(options.word));
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
  CommandRun run(context);
  bool was_said = false;
  const auto keep = [&](const pipeline::WordPlaces& so_far) {
    const auto kept = open_home(options.home, context).and_then([&](home::Home writer) {
      return pipeline::keep_word_places(writer, *networks, so_far);
    });
    if (kept || was_said) return;
    was_said = true;
    context.progress.note("what was seen is not kept for later words: " + kept.error().message);
  };
  ROOMWISE_TRY(const auto looked_at,
               pipeline::word_places(home, *networks, run,
                                     home.is_protected() ? pipeline::KeepWordPlaces() : keep));
  const pipeline::FoundWord found = pipeline::find_word(looked_at, word);
  ROOMWISE_TRY(const ThingPlaces places, ThingPlaces::read(home));
  const home::Keyframe& keyframe = places.keyframes.at(found.place.keyframe);
  const std::string room = places.room_of(keyframe.id);
  const network::PixelBox& box = found.place.box;
  const std::size_t pictures = std::min(places.keyframes.size(), pipeline::kWordPictures);
  Answer answer;
  answer.text = fmt::format(
      "{}: {} in {} of {} pictures; likeliest in key-frame {} (frame {}){}, at {:.0f} {:.0f} to "
      "{:.0f} {:.0f} px; of {} things that hardly any home has {:.0f} % look as likely\n",
      options.word, found.is_found ? "found" : "not found", pictures, places.keyframes.size(),
      keyframe.id, keyframe.frame_index, room.empty() ? "" : ", " + room, box.left, box.top,
      box.right, box.bottom, pipeline::absent_things().size(), 100 * found.false_alarms);
  answer.json = {{"word", options.word},
                 {"found", found.is_found},
                 {"keyframe", keyframe.id},
                 {"frame", keyframe.frame_index},
                 {"room", word_or_null(room)},
                 {"picture_box_px", {box.left, box.top, box.right, box.bottom}},
                 {"above_usual", found.above_usual},
                 {"false_alarms", found.false_alarms},
                 {"places", looked_at.places.size()},
                 {"pictures", pictures},
                 {"pictures_of_home", places.keyframes.size()}};
  return answer;
}

// Networks look at a home that was mapped without them, or with others; then all is joined anew.
Expected<Answer> find(const ObjectsOptions& options, Context& context) {
  cv::setNumThreads(1);  // the threads are ours
  ROOMWISE_TRY(home::Home home, open_home(options.home, context));
  ROOMWISE_TRY(const pipeline::Networks networks,
               load_networks_for_keyframes(options.networks, home, context));
  ROOMWISE_TRY(const objects::ObjectFinders finders, load_object_finders());
  if (networks.empty() && finders.in_pictures.empty()) {
    return fail("no network is here; give --network FILE or set ROOMWISE_MODELS");
  }
  ROOMWISE_TRY(const auto settings, pipeline::stored_map_settings(home));
  CommandRun run(context);
  ROOMWISE_TRY(auto observer,
               pipeline::KeyframeObserver::create(home, networks, finders.in_pictures, run));
  Expected<void> seen_all = observer.observe_missing();
  if (seen_all && finders.of_proposals) {
    seen_all = pipeline::redetect_on_proposals(home, *finders.of_proposals, run);
  }
  if (!seen_all && seen_all.error().code == ErrorCode::kInterrupted) {
    return fail_with(
        ErrorCode::kInterrupted,
        "interrupted; what was seen of whole key-frames is kept, the same command goes on from "
        "there");
  }
  ROOMWISE_RETURN_IF_ERROR(seen_all);
  {
    const auto timing = run.clock.measure("joining objects");
    const objects::ObjectRules rules = settings ? settings->objects : objects::ObjectRules{};
    ROOMWISE_RETURN_IF_ERROR(pipeline::update_objects(home, rules));
  }
  ROOMWISE_TRY(Answer answer,
               list_found(home, finders.in_pictures.empty() ? "paper" : options.rule, context));
  add_stages(answer, run.clock);
  ROOMWISE_RETURN_IF_ERROR(home.add_stage_timings(run.clock.stages()));
  return answer;
}

std::pair<CLI::App*, ObjectsOptions&> add_objects_command(
    CLI::App& group, Context& context, const std::string& name, const std::string& description,
    const std::string& more_example, Expected<Answer> (*body)(const ObjectsOptions&, Context&)) {
  const auto [command, options] = add_command<ObjectsOptions>(
      group, context, name, description,
      "roomwise objects " + name + " --home my.home" + more_example, body);
  command->add_option("--home", options.home, "Home file")->required();
  add_setting(*command, "--rule", options.rule,
              "regions: joined from what a detector finds in many key-frames; paper: its three "
              "rules and the middle of the picture",
              CLI::IsMember({"regions", "paper"}));
  return {command, options};
}

}  // namespace

void add_objects_commands(CLI::App& app, Context& context) {
  CLI::App* group = add_group(app, "objects", "The objects that were found in a home",
                              "roomwise objects list --home my.home");
  const auto [list_command, of_list] = add_objects_command(
      *group, context, "list",
      "List the objects: name, probability, place, size, how sure the place is, in how many "
      "key-frames they were seen, and the room they stand in",
      " --json", list);
  list_command
      ->add_flag("--past", of_list.past,
                 "Those that stand there no more instead: what became of them (moved, gone), when "
                 "they were first and last seen, and the visit that noticed")
      ->excludes("--rule");
  const auto [history_command, of_history] = add_command<ObjectHistoryOptions>(
      *group, context, "history",
      "What became of the objects from walk to walk: found, there, moved, shifted, gone, new or "
      "not "
      "looked at; and what the newest walk changed",
      "roomwise objects history --home my.home chair", tell_history);
  history_command->add_option("--home", of_history.home, "Home file")->required();
  history_command->add_option("NAME", of_history.name, "Things of that name; default: all");
  const auto [word_command, of_word] = add_command<FindWordOptions>(
      *group, context, "find-word",
      "Look in the pictures of a home for a thing whose word no label has, by a pair of networks "
      "that compares pictures with words",
      "roomwise objects find-word accordion --home my.home", find_word);
  word_command->add_option("WORD", of_word.word, "A word, or a few, in English")->required();
  word_command->add_option("--home", of_word.home, "Home file")->required();
  const auto [find_command, of_find] = add_objects_command(
      *group, context, "find",
      "Let the networks look at those key-frames that they have not seen, and find the objects "
      "anew",
      "", find);
  add_network_options(*find_command, of_find.networks);
}

}  // namespace roomwise::app
