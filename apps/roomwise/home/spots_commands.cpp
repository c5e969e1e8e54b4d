#include <algorithm>
#include <filesystem>

#include "command_run.h"
#include "commands.h"
#include "open_home.h"
#include "roomwise/base/calendar_time.h"
#include "roomwise/base/timestamp.h"
#include "roomwise/pipeline/edits/marked_spots.h"
#include "roomwise/pipeline/mapping/home_floor.h"

namespace roomwise::app {
namespace {

struct SpotsOptions {
  std::filesystem::path home;
  std::string name, new_name, owner;
  std::vector<double> at;  // x, y
  std::optional<std::uint64_t> keyframe;
};

const std::string kWithoutName = "(remember where I am)";

// Where spots are on the plan.
struct Places {
  std::vector<home::Keyframe> keyframes;
  fusion::GravityAlignedFrame frame = {};

  [[nodiscard]] std::optional<Eigen::Vector3d> of(const pipeline::MarkedSpot& spot) const {
    return pipeline::point_on_plan(spot.place, keyframes, frame);
  }
};

Expected<Places> find_places(const home::Home& home, Context& context) {
  Places places;
  ROOMWISE_TRY(places.keyframes, home.keyframes());
  if (places.keyframes.empty()) return places;
  CommandRun run(context);
  ROOMWISE_TRY(const pipeline::HomeFloor floor, pipeline::find_home_floor(home, run));
  places.frame = floor.frame;
  return places;
}

Expected<pipeline::MarkedSpot> find_spot(const home::Home& home, const SpotsOptions& options) {
  ROOMWISE_TRY(const auto spots, pipeline::marked_spots(home));
  const auto found = std::ranges::find_if(spots, [&](const pipeline::MarkedSpot& one) {
    return one.name == options.name && one.owner == options.owner;
  });
  if (found != spots.end()) return *found;
  return fail("{}: {} marked no place called '{}'; roomwise spots list says what there is",
              home.file(), options.owner.empty() ? "this computer" : "device " + options.owner,
              options.name);
}

Json json_of(const pipeline::MarkedSpot& spot, const Places& places) {
  const auto at = places.of(spot);
  return {{"id", spot.id},
          {"name", spot.name},
          {"owner", spot.owner},
          {"marked_s", spot.marked_s},
          {"position", at ? Json{at->x(), at->y(), at->z()} : Json(nullptr)},
          {"keyframe", spot.place.keyframe ? Json(*spot.place.keyframe) : Json(nullptr)}};
}

std::string line_of(const pipeline::MarkedSpot& spot, const Places& places) {
  const auto at = places.of(spot);
  const auto date = calendar_time(spot.marked_s * 1'000'000'000);
  return fmt::format(
      "{}: {}, {}, {}\n", spot.name.empty() ? kWithoutName : spot.name,
      spot.owner.empty() ? "everybody's" : "of device " + spot.owner,
      date ? fmt::format("marked {:04}-{:02}-{:02}", date->year, date->month, date->day)
           : std::string("nobody knows when"),
      at ? fmt::format("at x {:.2f}, y {:.2f} m", at->x(), at->y())
         : std::string("its place is not on the map any more"));
}

Expected<Answer> list(const SpotsOptions& options, Context& context) {
  ROOMWISE_TRY(const home::Home home, open_home_read_only(options.home, context));
  ROOMWISE_TRY(const auto spots, pipeline::marked_spots(home));
  Answer answer{spots.empty() ? "nobody marked a place in this home yet\n" : "",
                {{"spots", Json::array()}}};
  if (spots.empty()) return answer;
  ROOMWISE_TRY(const Places places, find_places(home, context));
  for (const pipeline::MarkedSpot& spot : spots) {
    answer.text += line_of(spot, places);
    answer.json["spots"].push_back(json_of(spot, places));
  }
  return answer;
}

// The place that the options tell.
Expected<home::EditPlace> place_of(const SpotsOptions& options, const Places& places) {
  if (options.keyframe) {
    if (*options.keyframe >= places.keyframes.size()) {
      return fail("there is no key-frame {}; the home has {}", *options.keyframe,
                  places.keyframes.size());
    }
    return pipeline::spot_place(
        places.keyframes, places.keyframes[*options.keyframe].pose.world_from_keyframe.translation);
  }
  if (options.at.size() != 2) return fail("where? Give --at X Y or --keyframe N");
  return pipeline::spot_place_on_plan(places.keyframes, places.frame,
                                      {options.at[0], options.at[1], 0});
}

Expected<Answer> mark(const SpotsOptions& options, Context& context) {
  ROOMWISE_TRY(home::Home home, open_home(options.home, context));
  ROOMWISE_TRY(const Places places, find_places(home, context));
  if (places.keyframes.empty()) return fail("{}: has no map yet; map a walk first", home.file());
  pipeline::MarkedSpot spot{
      .name = options.name, .owner = options.owner, .marked_s = unix_now_ns() / 1'000'000'000};
  ROOMWISE_TRY(spot.place, place_of(options, places));
  ROOMWISE_TRY(spot.id, pipeline::mark_spot(home, spot));
  return Answer{line_of(spot, places), {{"spot", json_of(spot, places)}}};
}

Expected<Answer> rename(const SpotsOptions& options, Context& context) {
  ROOMWISE_TRY(home::Home home, open_home(options.home, context));
  ROOMWISE_TRY(const pipeline::MarkedSpot spot, find_spot(home, options));
  ROOMWISE_RETURN_IF_ERROR(pipeline::rename_spot(home, spot.id, options.new_name));
  return Answer{
      fmt::format("{}: {} is called {} now\n", home.file(), options.name, options.new_name),
      {{"home", home.file()}, {"renamed", options.name}, {"name", options.new_name}}};
}

Expected<Answer> forget(const SpotsOptions& options, Context& context) {
  ROOMWISE_TRY(home::Home home, open_home(options.home, context));
  ROOMWISE_TRY(const pipeline::MarkedSpot spot, find_spot(home, options));
  ROOMWISE_RETURN_IF_ERROR(pipeline::forget_spot(home, spot.id));
  ROOMWISE_RETURN_IF_ERROR(home.erase_removed());
  return Answer{fmt::format("{}: {} is forgotten\n", home.file(),
                            spot.name.empty() ? kWithoutName : spot.name),
                {{"home", home.file()}, {"forgotten", spot.name}}};
}

}  // namespace

void add_spots_commands(CLI::App& app, Context& context) {
  CLI::App* const group = add_group(app, "spots", "Places that people marked to come back to",
                                    "roomwise spots list --home my.home");
  const auto with_home = [](CLI::App* command, SpotsOptions& options) {
    command->add_option("--home", options.home, "Home file")->required();
  };
  const auto with_owner = [](CLI::App* command, SpotsOptions& options) {
    command->add_option("--owner", options.owner,
                        "Number of the device that marked it; default: this computer, whose spots "
                        "are everybody's");
  };
  {
    const auto [command, options] = add_command<SpotsOptions>(
        *group, context, "list", "What was marked, by whom, and where that is",
        "roomwise spots list --home my.home --json", list);
    with_home(command, options);
  }
  {
    const auto [command, options] = add_command<SpotsOptions>(
        *group, context, "mark",
        "Mark a place of the map; one of that name is where you mark it now",
        "roomwise spots mark \"my chair\" --at 1.5 -0.4 --home my.home", mark);
    command->add_option("NAME", options.name, "What it is called")->required();
    auto* at = command
                   ->add_option(
                       "--at", options.at,
                       "Where on the floor: x and y of the plan, m; storeys lie side by side on it")
                   ->expected(2);
    command->add_option("--keyframe", options.keyframe, "Where this key-frame was taken")
        ->excludes(at);
    with_owner(command, options);
    with_home(command, options);
  }
  {
    const auto [command, options] = add_command<SpotsOptions>(
        *group, context, "rename", "Call a marked place otherwise",
        "roomwise spots rename \"my chair\" \"my seat\" --home my.home", rename);
    command->add_option("NAME", options.name, "What it is called")->required();
    command->add_option("NEW_NAME", options.new_name, "What it is called from now on")->required();
    with_owner(command, options);
    with_home(command, options);
  }
  {
    const auto [command, options] =
        add_command<SpotsOptions>(*group, context, "forget", "Forget a marked place, and erase it",
                                  "roomwise spots forget \"my chair\" --home my.home", forget);
    command->add_option("NAME", options.name, "What it is called; \"\": the one without a name")
        ->required();
    with_owner(command, options);
    with_home(command, options);
  }
}

}  // namespace roomwise::app
