#include "roomwise/guide/answers/route_prompts.h"

#include <algorithm>
#include <cmath>

#include "roomwise/guide/way/legs.h"
#include "roomwise/guide/way/way_phrases.h"

namespace roomwise::guide {
namespace {

constexpr std::size_t kMaxLegs = 4;
constexpr double kThere_m = 0.5;  // less than a step: nobody needs to be told

const char* turn_message(double turn_rad) {
  const double degrees = turn_rad / kDegree_rad;
  if (std::abs(turn_rad) < kNoTurn_rad) return "route.straight";
  if (std::abs(degrees) > 135) return "route.around";
  if (std::abs(degrees) < 60) return degrees > 0 ? "route.slight_left" : "route.slight_right";
  return degrees > 0 ? "route.left" : "route.right";
}

}  // namespace

std::vector<Prompt> route_prompts(const Route& route, const Pose& pose, const Noun& goal,
                                  std::span<const rooms::Doorway> doorways, const Wording& wording,
                                  TimestampNs now_ns, std::span<const fusion::Staircase> stairs,
                                  Confidence confidence) {
  const double whole_m = length_m(route, stairs);
  const auto made = [&](std::size_t part, const std::string& message, const Values& values) {
    return make_part(wording, "route", part, message, values, confidence, now_ns, kDirectionValid_s,
                     fmt::format("a way of {:.1f} m along free floor", whole_m));
  };
  const bool is_sure = confidence == Confidence::kSure;
  if (whole_m < kThere_m) {
    return {made(0, is_sure ? "route.arrived" : "route.arrived_probable", {{"goal", Nouns{goal}}})};
  }
  const std::vector<rooms::Doorway> doors = doors_of(doorways);  // legs point to them
  const std::vector<Leg> legs = legs_of(route, doors, stairs);
  std::vector<Prompt> prompts;
  double heading_rad = pose.heading_rad;
  for (std::size_t i = 0; i < std::min(legs.size(), kMaxLegs); ++i) {
    const Leg& leg = legs[i];
    if (leg.stairs) {
      const Phrase phrase = stairs_phrase(*leg.stairs, wording.phrases());
      prompts.push_back(made(i, phrase.message_id, phrase.values));
      heading_rad = leg.stairs->end_heading_rad();
      continue;
    }
    const std::string turn =
        wording.phrases().text(turn_message(turn_rad(heading_rad, leg.heading_rad())));
    heading_rad = leg.heading_rad();
    const bool is_last = i + 1 == legs.size();
    prompts.push_back(made(
        i,
        is_last && !is_sure  ? "route.step_goal_probable"
        : is_last            ? "route.step_goal"
        : legs[i + 1].stairs ? stairs_message("stairs.route", *legs[i + 1].stairs)
        : leg.ends_at_door() ? "route.step_door"
                             : "route.step",
        {{"turn", turn}, {"distance", wording.distance(leg.length_m)}, {"goal", Nouns{goal}}}));
  }
  return prompts;
}

Prompt none_in_room_prompt(const Noun& thing, const std::string& room, const Wording& wording,
                           TimestampNs now_ns) {
  return make_prompt(wording, "thing " + thing.name, "where.unknown_in",
                     {{"thing", Nouns{thing}}, {"room", guide::room(room)}}, Confidence::kSure,
                     after(now_ns, kHomeValid_s), "the map has none of this name in that room");
}

Prompt no_route_prompt(bool has_pose, std::string because, const Wording& wording,
                       TimestampNs now_ns) {
  return make_prompt(wording, "route", has_pose ? "route.none" : "route.no_place", {},
                     Confidence::kUnsure, after(now_ns, kRoomValid_s), std::move(because));
}

}  // namespace roomwise::guide
