#include <algorithm>
#include <filesystem>

#include "command_run.h"
#include "commands.h"
#include "networks.h"
#include "open_home.h"
#include "roomwise/base/calendar_time.h"
#include "roomwise/base/timestamp.h"
#include "roomwise/image/codec.h"
#include "roomwise/pipeline/objects/own_things.h"

namespace roomwise::app {
namespace {

struct ThingsOptions {
  std::filesystem::path home;
  std::string name, owner;
  bool is_private = false;
  std::vector<std::filesystem::path> pictures;
  NetworkOptions networks;
};

Expected<home::OwnThing> find_thing(const home::Home& home, const std::string& name) {
  ROOMWISE_TRY(const auto things, home.own_things());
  const auto found = std::ranges::find(things, name, &home::OwnThing::name);
  if (found != things.end()) return *found;
  return fail("{}: nobody taught it a thing called {}; roomwise things list says what there is",
              home.file(), name);
}

// What is wrong with a picture, and what to do.
std::string_view mend_of(objects::ShowFault fault) {
  switch (fault) {
    case objects::ShowFault::kDark:
      return "it is too dark; turn on a light";
    case objects::ShowFault::kGlaring:
      return "it is washed out; turn away from the window or the lamp";
    case objects::ShowFault::kBlurred:
      return "it is blurred; hold the thing and the camera still";
    case objects::ShowFault::kEmpty:
      return "nothing is in its middle; hold the thing there";
    case objects::ShowFault::kFar:
      return "the thing is too far; bring it nearer";
  }
  return "";
}

Json json_of(const home::OwnThing& thing) {
  return {{"id", thing.id},
          {"name", thing.name},
          {"owner", thing.owner},
          {"shared", thing.is_shared},
          {"taught_s", thing.taught_s},
          {"seen_s", thing.last_seen.seen_s ? Json(*thing.last_seen.seen_s) : Json(nullptr)},
          {"room", thing.last_seen.room ? Json(*thing.last_seen.room) : Json(nullptr)},
          {"keyframe", thing.last_seen.keyframe ? Json(*thing.last_seen.keyframe) : Json(nullptr)}};
}

std::string date_of(std::int64_t seconds) {
  const auto date = calendar_time(seconds * 1'000'000'000);
  return date ? fmt::format("{:04}-{:02}-{:02}", date->year, date->month, date->day)
              : std::string("at an unknown time");
}

std::string line_of(const home::OwnThing& thing) {
  const home::OwnThingSighting& seen = thing.last_seen;
  std::string where = seen.is_known() ? "seen" : "not seen yet";
  if (seen.seen_s) where += " " + date_of(*seen.seen_s);
  if (seen.room) where += " in " + *seen.room;
  if (seen.keyframe) where += fmt::format(" by key-frame {}", *seen.keyframe);
  const std::string owner = thing.owner.empty() ? "this computer" : "device " + thing.owner;
  return fmt::format("{}: thing {}, taught by {}, {}; {}\n", thing.name, thing.id, owner,
                     thing.is_shared ? "shared" : "private", where);
}

Expected<Answer> teach(const ThingsOptions& options, Context& context) {
  ROOMWISE_TRY(home::Home home, open_home(options.home, context));
  if (home.is_locked()) return Unexpected(home.locked_error());
  ROOMWISE_RETURN_IF_ERROR(pipeline::check_own_thing_name(home, options.name));
  Answer answer;
  std::vector<objects::ShownThing> shown;
  for (const std::filesystem::path& file : options.pictures) {
    ROOMWISE_TRY(const image::ColorImage picture, image::read_color(file));
    auto found = objects::find_shown(picture);
    if (found) {
      shown.push_back(*std::move(found));
      continue;
    }
    answer.text += fmt::format("{}: not taken: {}\n", file.string(), mend_of(found.error()));
    answer.json["refused"].push_back(
        {{"picture", file.string()}, {"why", objects::name_of(found.error())}});
  }
  ROOMWISE_TRY(const pipeline::Networks networks, load_networks(options.networks, &home));
  ROOMWISE_TRY(const objects::ObjectFinders finders, load_object_finders());
  ROOMWISE_TRY(const auto id, pipeline::teach_own_thing(home,
                                                        {.name = options.name,
                                                         .owner = options.owner,
                                                         .is_shared = !options.is_private,
                                                         .taught_s = unix_now_ns() / 1'000'000'000},
                                                        shown, networks));
  CommandRun run(context);
  ROOMWISE_TRY(const pipeline::OwnThingLook look,
               pipeline::look_for_own_things(home, networks, finders.in_pictures, run));
  ROOMWISE_TRY(const home::OwnThing thing, find_thing(home, options.name));
  answer.text += line_of(thing) + (look.why.empty() ? "" : look.why + "\n");
  answer.json["thing"] = json_of(thing);
  answer.json["id"] = id;
  answer.json["looked_for"] = look.is_looked_for;
  return answer;
}

Expected<Answer> list(const ThingsOptions& options, Context& context) {
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
  ROOMWISE_TRY(const auto things, home.own_things());
  Answer answer{things.empty() ? "nobody taught this home a thing yet\n" : "",
                {{"things", Json::array()}}};
  for (const home::OwnThing& thing : things) {
    answer.text += line_of(thing);
    answer.json["things"].push_back(json_of(thing));
  }
  return answer;
}

Expected<Answer> forget_thing(const ThingsOptions& options, Context& context) {
  ROOMWISE_TRY(home::Home home, open_home(options.home, context));
  ROOMWISE_TRY(const home::OwnThing thing, find_thing(home, options.name));
  ROOMWISE_RETURN_IF_ERROR(home.remove_own_thing(thing.id));
  ROOMWISE_RETURN_IF_ERROR(home.erase_removed());
  return Answer{
      fmt::format("{}: {} is forgotten, its pictures are erased\n", home.file(), thing.name),
      {{"home", home.file()}, {"forgotten", thing.name}}};
}

Expected<Answer> share(const ThingsOptions& options, Context& context) {
  ROOMWISE_TRY(home::Home home, open_home(options.home, context));
  ROOMWISE_TRY(const home::OwnThing thing, find_thing(home, options.name));
  ROOMWISE_RETURN_IF_ERROR(home.share_own_thing(thing.id, !options.is_private));
  return Answer{fmt::format("{}: {} is {}\n", home.file(), thing.name,
                            options.is_private ? "its owner's alone" : "shared"),
                {{"home", home.file()}, {"name", thing.name}, {"shared", !options.is_private}}};
}

Expected<Answer> find(const ThingsOptions& options, Context& context) {
  ROOMWISE_TRY(home::Home home, open_home(options.home, context));
  ROOMWISE_TRY(const pipeline::Networks networks, load_networks(options.networks, &home));
  ROOMWISE_TRY(const objects::ObjectFinders finders, load_object_finders());
  CommandRun run(context);
  ROOMWISE_RETURN_IF_ERROR(
      pipeline::calibrate_own_things(home, networks, finders.in_pictures, run));
  ROOMWISE_TRY(const auto watch, pipeline::watch_own_things(home, networks, finders.in_pictures));
  if (watch == nullptr) return fail("{}: nobody taught it a thing yet", home.file());
  Answer answer;
  answer.json["found"] = Json::array();
  for (const std::filesystem::path& file : options.pictures) {
    ROOMWISE_TRY(const image::ColorImage picture, image::read_color(file));
    ROOMWISE_TRY(const auto found, watch->look(picture));
    if (found.empty()) answer.text += fmt::format("{}: nothing that was taught\n", file.string());
    for (const pipeline::FoundOwnThing& one : found) {
      const auto thing = std::ranges::find(watch->things(), one.id, &home::OwnThing::id);
      answer.text +=
          fmt::format("{}: {} at {:.0f} {:.0f} to {:.0f} {:.0f} px\n", file.string(), thing->name,
                      one.box.left, one.box.top, one.box.right, one.box.bottom);
      answer.json["found"].push_back(
          {{"picture", file.string()},
           {"name", thing->name},
           {"box", {one.box.left, one.box.top, one.box.right, one.box.bottom}},
           {"above_threshold", one.above}});
    }
  }
  return answer;
}

}  // namespace

void add_things_commands(CLI::App& app, Context& context) {
  CLI::App* const group = add_group(app, "things", "Things that people taught a home",
                                    "roomwise things list --home my.home");
  const auto with_home = [](CLI::App* command, ThingsOptions& options) {
    command->add_option("--home", options.home, "Home file")->required();
  };
  {
    const auto [command, options] = add_command<ThingsOptions>(
        *group, context, "teach",
        "Teach a home a thing by pictures that show it in their middle, from several sides",
        "roomwise things teach \"my blue mug\" mug-*.jpg --home my.home", teach);
    command->add_option("NAME", options.name, "What it is called")->required();
    command->add_option("PICTURE", options.pictures, "Three or more")->required();
    command->add_option("--owner", options.owner,
                        "Number of the device of whom it is; default: this computer");
    command->add_flag("--private", options.is_private, "Only its owner is told of it");
    add_network_options(*command, options.networks);
    with_home(command, options);
  }
  {
    const auto [command, options] = add_command<ThingsOptions>(
        *group, context, "list", "What was taught, by whom, and where it was seen last",
        "roomwise things list --home my.home", list);
    with_home(command, options);
  }
  {
    const auto [command, options] = add_command<ThingsOptions>(
        *group, context, "find", "Look for what was taught in pictures of the home",
        "roomwise things find table.jpg --home my.home", find);
    command->add_option("PICTURE", options.pictures, "Pictures")->required();
    add_network_options(*command, options.networks);
    with_home(command, options);
  }
  {
    const auto [command, options] = add_command<ThingsOptions>(
        *group, context, "share", "Tell all people of the home of a thing, or only its owner",
        "roomwise things share \"my blue mug\" --home my.home", share);
    command->add_option("NAME", options.name, "What it is called")->required();
    command->add_flag("--private", options.is_private, "Only its owner is told of it");
    with_home(command, options);
  }
  {
    const auto [command, options] = add_command<ThingsOptions>(
        *group, context, "forget", "Forget a thing that was taught, and erase its pictures",
        "roomwise things forget \"my blue mug\" --home my.home", forget_thing);
    command->add_option("NAME", options.name, "What it is called")->required();
    with_home(command, options);
  }
}

}  // namespace roomwise::app
