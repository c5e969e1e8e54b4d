#include <filesystem>

#include "command_run.h"
#include "commands.h"
#include "home/walk_words.h"
#include "open_home.h"
#include "pose_json.h"
#include "roomwise/base/shell_word.h"
#include "roomwise/pipeline/rooms/room_coverage.h"

namespace roomwise::app {
namespace {

using pipeline::CoverageItem;
using pipeline::Missing;
using pipeline::RoomCoverage;
using pipeline::RoomOnWalk;
using pipeline::RoomSeen;

struct CoverageCommandOptions {
  std::filesystem::path home;
};

// "day_walk, 3 May 2026 at 10 o'clock: 41 pictures, brightness 0.42".
std::string in_words(const RoomOnWalk& one, const WalkWords& walks) {
  std::string words = walks.name(one.walk);
  if (const auto when = walks.date(one.first_ns)) words += ", " + *when;
  words += fmt::format(": {} pictures", one.pictures);
  if (one.light) {
    words += fmt::format(", brightness {:.2f}, red over blue {:.2f}", one.light->brightness,
                         one.light->red_over_blue);
  }
  return words;
}

std::string at_place(const pipeline::FloorGap& gap) {
  return fmt::format("{}at {:.1f} {:.1f} m",
                     gap.beside.empty() ? "" : "by the " + gap.beside + ", ", gap.middle_plan.x(),
                     gap.middle_plan.y());
}

// What is missing, and what to do.
struct ItemWords {
  std::string say, mend;
};
ItemWords words_of(const CoverageItem& item, const pipeline::CoverageOptions& options,
                   const WalkWords& walks) {
  switch (item.what) {
    case Missing::kJoin:
      return {fmt::format("the walk {} has not joined the map", walks.name(*item.walk)),
              "walk once more from a room that the map knows to where that walk was, with the "
              "lights on"};
    case Missing::kNames:
      return {fmt::format("{} pictures of the walk {} belong to no room", item.pictures,
                          walks.name(*item.walk)),
              fmt::format("name them: roomwise rooms name --walk {}",
                          shell_word(walks.name(*item.walk)))};
    case Missing::kPictures:
      return {fmt::format("{}: {} pictures, too few to learn it", item.room, item.pictures),
              fmt::format("walk through it and turn once in its middle; at least {} are needed",
                          options.learning.min_pictures)};
    case Missing::kMorePictures:
      return {fmt::format("{}: {} pictures, few to know it well", item.room, item.pictures),
              fmt::format("walk through it and turn once in its middle; {} are comfortable",
                          options.learning.comfortable_pictures)};
    case Missing::kSecondWalk:
      return {fmt::format("{}: only one walk saw it, {}", item.room, walks.name(*item.walk)),
              "walk through it by the other light: by day with the lamps off, or after dark with "
              "the lamps on"};
    case Missing::kOtherLight:
      return {fmt::format("{}: all walks saw it by much the same light", item.room),
              "walk through it by the other light: by day with the lamps off, or after dark with "
              "the lamps on"};
    case Missing::kFloor:
      break;
  }
  return {
      item.gap->is_unseen
          ? fmt::format("{}: the floor goes on where no walk saw it, over {:.1f} m, {}", item.room,
                        item.gap->length_m, at_place(*item.gap))
          : fmt::format("{}: floor was seen from afar only, over {:.1f} m, {}", item.room,
                        item.gap->length_m, at_place(*item.gap)),
      "go there with the camera, tilted down a little, or leave it if it is no room of the home"};
}

Json light_json(const std::optional<pipeline::RoomLight>& light) {
  if (!light) return nullptr;
  return {{"brightness", light->brightness},
          {"brightness_quartiles", {light->brightness_low, light->brightness_high}},
          {"red_over_blue", light->red_over_blue},
          {"red_over_blue_quartiles", {light->red_over_blue_low, light->red_over_blue_high}}};
}

Json room_json(const RoomSeen& room, const WalkWords& walks) {
  const auto several = room.by_several_lights();
  Json json{{"room", room.room},
            {"pictures", room.pictures()},
            {"several_lights", several ? Json(*several) : Json(nullptr)},
            {"walks", Json::array()}};
  for (const RoomOnWalk& one : room.walks) {
    json["walks"].push_back({{"walk", walks.name(one.walk)},
                             {"pictures", one.pictures},
                             {"first_s", seconds_between(0, one.first_ns)},
                             {"last_s", seconds_between(0, one.last_ns)},
                             {"date", date_json(one.first_ns)},
                             {"light", light_json(one.light)}});
  }
  return json;
}

Json gap_json(const std::optional<pipeline::FloorGap>& gap) {
  if (!gap) return nullptr;
  return {{"length_m", gap->length_m},
          {"middle_m", {gap->middle_plan.x(), gap->middle_plan.y()}},
          {"unseen", gap->is_unseen},
          {"beside", word_or_null(gap->beside)}};
}

Answer answer_of(const RoomCoverage& coverage, const pipeline::CoverageOptions& options,
                 const WalkWords& walks, bool is_locked) {
  Answer answer;
  answer.json = {{"rooms", Json::array()}, {"missing", Json::array()}};
  for (const RoomSeen& room : coverage.rooms) {
    answer.json["rooms"].push_back(room_json(room, walks));
    answer.text += fmt::format("{}\n", room.room);
    for (const RoomOnWalk& one : room.walks) answer.text += "  " + in_words(one, walks) + "\n";
    if (room.walks.empty()) answer.text += "  no walk saw it\n";
  }
  const auto items = pipeline::missing_items(coverage, options);
  answer.text += items.empty() ? "nothing is missing\n" : "what is missing:\n";
  for (const CoverageItem& item : items) {
    const ItemWords words = words_of(item, options, walks);
    answer.text += fmt::format("  {}: {}\n", words.say, words.mend);
    answer.json["missing"].push_back(
        {{"what", pipeline::to_string(item.what)},
         {"room", word_or_null(item.room)},
         {"walk", item.walk ? Json(walks.name(*item.walk)) : Json(nullptr)},
         {"pictures", item.pictures},
         {"floor", gap_json(item.gap)},
         {"say", words.say},
         {"do", words.mend}});
  }
  if (is_locked) {
    answer.text +=
        "the home's pictures are sealed: how they are lit is not known; give --passphrase-file\n";
  }
  if (!coverage.knows_floor) {
    answer.text += "where the rooms lie on the floor is not known: no map, or no named rooms\n";
  }
  answer.json["light_known"] = !is_locked;
  answer.json["floor_known"] = coverage.knows_floor;
  return answer;
}

Expected<Answer> cover(const CoverageCommandOptions& options, Context& context) {
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
  ROOMWISE_TRY(const auto keyframes, home.keyframes());
  if (keyframes.empty()) return fail("{}: has no map yet; map a walk first", home.file());
  CommandRun run(context);
  const pipeline::CoverageOptions how;
  ROOMWISE_TRY(const RoomCoverage coverage, pipeline::find_room_coverage(home, how, run));
  ROOMWISE_TRY(const WalkWords walks, WalkWords::of(home));
  Answer answer = answer_of(coverage, how, walks, home.is_locked());
  ROOMWISE_TRY(const auto recordings, home.recordings());
  answer.json["unfinished"] = Json::array();
  for (const home::StoredRecording& one : recordings) {
    if (one.finished) continue;
    answer.json["unfinished"].push_back(walks.name(one.id));
    answer.text =
        fmt::format(
            "the walk {} was not mapped to its end: go on with roomwise map {} --home {} "
            "--resume\n",
            walks.name(one.id), shell_word(one.recording.folder), shell_word(home.file())) +
        answer.text;
  }
  return answer;
}

}  // namespace

void add_coverage_command(CLI::App& group, Context& context) {
  const auto [command, options] = add_command<CoverageCommandOptions>(
      group, context, "coverage",
      "What the walks have not shown yet: rooms that one walk alone saw, or all by one light, with "
      "too few pictures, floor that no picture shows from near; and what to do",
      "roomwise rooms coverage --home my.home", cover);
  command->add_option("--home", options.home, "Home file with named rooms")->required();
}

}  // namespace roomwise::app
