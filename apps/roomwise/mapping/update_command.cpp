#include <algorithm>
#include <filesystem>
#include <opencv2/core/utility.hpp>

#include "camera_option.h"
#include "command_run.h"
#include "commands.h"
#include "networks.h"
#include "open_home.h"
#include "pose_json.h"
#include "roomwise/pipeline/visits/update_home.h"
#include "roomwise/recording/damage_tolerant_source.h"
#include "roomwise/recording/open_recording.h"
#include "skip_damaged.h"

namespace roomwise::app {
namespace {

namespace fs = std::filesystem;
using objects::ChangeState;
using pipeline::ThingUpdate;

struct UpdateCommandOptions {
  fs::path home;
  fs::path recording;
  bool dry_run = false;
  std::string camera;
  bool without_rooms = false;
  bool skip_damaged = false;
  NetworkOptions networks;
  pipeline::UpdateOptions update;
};

std::string_view what_of(const ThingUpdate& thing) {
  return thing.is_new ? "new" : objects::to_string(thing.state);
}

std::string at(const geometry::OrientedBox& box, const std::string& room) {
  const Eigen::Vector3d& middle = box.center();
  return fmt::format("{:.2f} {:.2f} {:.2f} m{}", middle.x(), middle.y(), middle.z(),
                     room.empty() ? "" : " (" + room + ")");
}

std::string row_of(const ThingUpdate& thing) {
  std::string place;
  if (thing.before && thing.now && thing.state == ChangeState::kMoved) {
    const double distance_m = (thing.before->center() - thing.now->center()).norm();
    place = fmt::format("from {} to {}, {:.2f} m", at(*thing.before, thing.room_before),
                        at(*thing.now, thing.room_now), distance_m);
  } else if (thing.now) {
    place = "at " + at(*thing.now, thing.room_now);
  } else {
    place = "was at " + at(*thing.before, thing.room_before);
  }
  const objects::FreeSpaceEvidence& evidence = thing.is_new ? thing.evidence_now : thing.evidence;
  return fmt::format("{:<13} {:<16} {}; {:.0f} % of what {} pictures show of its place differs\n",
                     what_of(thing), thing.name, place, 100 * evidence.gone_share(),
                     evidence.views);
}

std::string row_of(const pipeline::UnnamedChange& change) {
  const Eigen::Vector3d& size = change.box_world.size_m;
  return fmt::format(
      "{:<13} {:<16} {} {}{}; what was seen of it is {:.2f} x {:.2f} m, {:.2f} m high{}\n",
      change.is_new ? "new" : "gone", "something", change.is_new ? "at" : "was at",
      at(change.box_world, change.room), change.beside.empty() ? "" : ", by the " + change.beside,
      std::max(size.x(), size.y()), std::min(size.x(), size.y()), size.z(),
      change.is_like_a_leaf ? ", like the leaf of a door that was turned" : "");
}

Json place_json(const std::optional<geometry::OrientedBox>& box, const std::string& room) {
  if (!box) return nullptr;
  return {{"position_world_m", xyz(box->center())},
          {"rotation_world_xyzw", xyzw(box->world_from_box.rotation)},
          {"size_m", xyz(box->size_m)},
          {"room", word_or_null(room)}};
}

Json to_json(const objects::FreeSpaceEvidence& evidence) {
  return {{"pictures", evidence.views},
          {"looked_at", evidence.decided_share()},
          {"differs", evidence.gone_share()}};
}

Json to_json(const ThingUpdate& thing) {
  return {{"what", what_of(thing)},
          {"name", thing.name},
          {"probability", thing.probability},
          {"before", place_json(thing.before, thing.room_before)},
          {"now", place_json(thing.now, thing.room_now)},
          {"place_before", to_json(thing.evidence)},
          {"place_now", to_json(thing.evidence_now)}};
}

Json to_json(const pipeline::UnnamedChange& change) {
  return {{"what", change.is_new ? "new" : "gone"},
          {"place", place_json(change.box_world, change.room)},
          {"like_a_leaf", change.is_like_a_leaf},
          {"beside", word_or_null(change.beside)},
          {"place_in_other_walk", to_json(change.evidence)}};
}

// What became of the pictures of the visit by which rooms may be known from now on.
std::string rows_of(const pipeline::RoomUpdate& update, bool dry_run) {
  if (!update.why_not.empty()) {
    return fmt::format("the rooms are known as before: {}\n", update.why_not);
  }
  if (update.was_learned) return "the rooms are known as before: by this walk already\n";
  std::size_t agreed = 0;
  for (const auto& room : update.rooms) agreed += room.agreed;
  std::string rows = fmt::format(
      "{} pictures show their room surely, by themselves and by their place; {} do not, {} "
      "contradict their place\n",
      agreed, update.unsure, update.contradictory);
  for (const auto& room : update.rooms) {
    if (room.learned > 0) {
      rows += fmt::format("{} pictures of the {} {}\n", room.learned, room.room,
                          dry_run ? "would be learned" : "are learned");
    }
    if (room.outdated > 0) {
      rows +=
          fmt::format("{} pictures of the {}, of earlier visits, {}\n", room.outdated, room.room,
                      dry_run ? "would be forgotten for them" : "are forgotten for them");
    }
  }
  if (!update.pictures)
    rows += "the rooms are known as before: the walk shows nothing new of them\n";
  return rows;
}

Json to_json(const pipeline::RoomUpdate& update) {
  Json json = {{"why_not", word_or_null(update.why_not)},
               {"was_learned", update.was_learned},
               {"unsure", update.unsure},
               {"contradictory", update.contradictory},
               {"rooms", Json::array()}};
  for (const auto& room : update.rooms) {
    json["rooms"].push_back({{"room", room.room},
                             {"agreed", room.agreed},
                             {"learned", room.learned},
                             {"outdated", room.outdated}});
  }
  return json;
}

// Whether things that people taught are looked for, and what became of it.
struct TaughtThings {
  std::size_t taught = 0;
  std::size_t noted = 0;                                 // where they were seen is new to the home
  std::shared_ptr<const pipeline::OwnThingWatch> watch;  // null: they are not looked for
  std::string why_not;                                   // then, where there are any
};

// A dry run learns nothing of what is usual in the home: it says where that is not known.
Expected<TaughtThings> watch_taught_things(home::Home& home, const pipeline::Networks& networks,
                                           const objects::ObjectFinders& finders, bool dry_run,
                                           CommandRun& run) {
  TaughtThings things;
  ROOMWISE_TRY(const auto taught, home.own_things());
  things.taught = taught.size();
  if (taught.empty()) return things;
  if (!dry_run) {
    const auto usual = pipeline::calibrate_own_things(home, networks, finders.in_pictures, run);
    if (!usual && usual.error().code == ErrorCode::kInterrupted) return Unexpected(usual.error());
    if (!usual) {
      things.why_not = usual.error().message;
      return things;
    }
  }
  auto watch = pipeline::watch_own_things(home, networks, finders.in_pictures);
  if (watch) {
    things.watch = *std::move(watch);
  } else {
    things.why_not = watch.error().message;
  }
  return things;
}

std::string rows_of(const TaughtThings& things, const pipeline::HomeUpdate& update) {
  if (things.taught == 0) return {};
  if (things.watch == nullptr) return things.why_not + "\n";
  return fmt::format("{} of {} things that were taught are on it\n", update.own_things.size(),
                     things.taught);
}

Json to_json(const TaughtThings& things, const pipeline::HomeUpdate& update) {
  return {{"taught", things.taught},
          {"seen", update.own_things.size()},
          {"why_not", word_or_null(things.why_not)}};
}

Answer describe(const pipeline::HomeUpdate& update, const TaughtThings& taught,
                const std::vector<std::string>& damage, const UpdateCommandOptions& options) {
  const home::Visit& visit = update.changes.visit;
  Answer answer{fmt::format("{} of {} pictures of the visit were found on the map\n", visit.placed,
                            visit.frames),
                {{"frames", visit.frames},
                 {"placed", visit.placed},
                 {"first_timestamp_s", 1e-9 * static_cast<double>(visit.first_timestamp_ns)},
                 {"last_timestamp_s", 1e-9 * static_cast<double>(visit.last_timestamp_ns)},
                 {"changed", !update.changes.empty() || !update.unnamed.empty()},
                 {"written", !options.dry_run && !(update.changes.empty() && taught.noted == 0)},
                 {"things", Json::array()},
                 {"unnamed", Json::array()},
                 {"rooms", update.rooms ? to_json(*update.rooms) : Json(nullptr)},
                 {"own_things", to_json(taught, update)}}};
  std::size_t there = 0, not_looked_at = 0;
  for (const ThingUpdate& thing : update.things) {
    answer.json["things"].push_back(to_json(thing));
    const bool changed = thing.is_changed();
    if (changed) answer.text += row_of(thing);
    if (!changed && thing.state == ChangeState::kThere) ++there;
    if (!changed && thing.state == ChangeState::kUnobserved) ++not_looked_at;
  }
  for (const pipeline::UnnamedChange& change : update.unnamed) {
    answer.json["unnamed"].push_back(to_json(change));
    answer.text += row_of(change);
  }
  answer.json["damaged"] = damage;
  answer.text += damage_text(damage, "frames that cannot be read");
  answer.text +=
      fmt::format("{} things are where they were, {} were not looked at\n", there, not_looked_at);
  if (update.rooms) answer.text += rows_of(*update.rooms, options.dry_run);
  answer.text += rows_of(taught, update);
  if (update.changes.empty() && taught.noted > 0) {
    answer.text += "nothing else changed; where these were seen is noted\n";
  } else if (update.changes.empty()) {
    answer.text += update.unnamed.empty()
                       ? "nothing changed; the home is as it was\n"
                       : "nothing that has a name changed; the home is as it was\n";
  } else if (options.dry_run) {
    answer.text += "--dry-run: the home is as it was\n";
  }
  return answer;
}

Expected<Answer> update(const UpdateCommandOptions& options, Context& context) {
  cv::setNumThreads(1);
  ROOMWISE_TRY(const auto camera, given_camera(options.camera));
  ROOMWISE_TRY(const auto recording,
               recording::open_recording(options.recording, {.camera = camera}));
  for (const std::string& note : recording->notes()) context.progress.note(note);
  warn_of_camera(recording->info().camera, context);
  ROOMWISE_TRY(const objects::ObjectFinders finders, load_object_finders());
  ROOMWISE_TRY(home::Home home, options.dry_run ? open_home_read_only(options.home, context)
                                                : open_home(options.home, context));
  ROOMWISE_TRY(const auto own_things, home.own_things());
  pipeline::Networks networks;
  TaughtThings taught;
  taught.taught = own_things.size();
  if (!options.without_rooms || !own_things.empty()) {
    auto loaded = load_networks(options.networks, &home, /*also_brought=*/true);
    if (!loaded && !options.without_rooms) return Unexpected(std::move(loaded).error());
    if (loaded) {
      networks = *std::move(loaded);
    } else {
      taught.why_not = loaded.error().message;  // the rest of the work does without
    }
  }
  CommandRun run(context);
  pipeline::UpdateOptions with = options.update;
  with.visit.localizer.seed = context.seed;
  if (options.without_rooms) with.visit.rooms.reset();
  if (taught.why_not.empty()) {
    ROOMWISE_TRY(taught, watch_taught_things(home, networks, finders, options.dry_run, run));
  }
  with.visit.own_things = taught.watch;
  recording::DamageTolerantSource frames(*recording, options.skip_damaged);
  auto compared =
      pipeline::compare_with_visit(home, {*recording, frames}, finders, networks, with, run);
  if (!compared) {
    Error why = std::move(compared).error();
    if (frames.is_stopped()) why.message += kNamingSkipDamaged;
    if (why.code == ErrorCode::kInterrupted) why.message += "; the home is as it was";
    return Unexpected(std::move(why));
  }
  pipeline::HomeUpdate& found = *compared;
  found.changes.visit.folder = options.recording.string();
  if (!options.dry_run && !found.changes.empty()) {
    ROOMWISE_RETURN_IF_ERROR(home.apply_changes(found.changes));
  }
  if (!options.dry_run) {
    ROOMWISE_TRY(taught.noted, pipeline::note_own_things(home, found.own_things));
  }
  return describe(found, taught, frames.damage(), options);
}

}  // namespace

void add_update_command(CLI::App& app, Context& context) {
  const auto [command, options] = add_command<UpdateCommandOptions>(
      app, context, "update",
      "Bring a home up to date with a later walk through it: which things are gone, new or moved "
      "(the old state is kept with its time), and what its rooms look like now",
      "roomwise update --home my.home LATER-RECORDING", update);
  command->add_option("--home", options.home, "Home with a map")->required();
  command
      ->add_option("recording", options.recording,
                   "Folder or file of any kind that is read (docs/recordings.md)")
      ->required();
  add_camera_option(*command, options.camera, "the recording's own");
  command->add_flag("--dry-run", options.dry_run, "Say what changed, but write nothing");
  command->add_flag("--without-rooms", options.without_rooms,
                    "Leave the learned rooms as they are; without this, pictures of the walk that "
                    "clearly show a room are learned too");
  command->add_flag(
      kSkipDamaged, options.skip_damaged,
      "Leave out frames that cannot be read, and name them; without it the first such "
      "ends the work");
  add_network_options(*command, options.networks);
  add_setting(*command, "--every", options.update.visit.every, "Look at every K-th picture",
              CLI::Range(std::uint64_t{1}, std::uint64_t{1000}));
}

}  // namespace roomwise::app
