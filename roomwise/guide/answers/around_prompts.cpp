#include <algorithm>
#include <set>

#include "roomwise/guide/answers/thing_prompts.h"
#include "roomwise/guide/places/surfaces.h"

namespace roomwise::guide {
namespace {

using Today = std::optional<CalendarTime>;

constexpr std::size_t kMaxThings = 4;  // more is forgotten before the last is spoken
// What is nowhere longer than this stands on something and is in nobody's way; it is named as if
// it were so much farther away.
constexpr double kSmall_m = 0.3;
constexpr double kSmallIsFarther_m = 2;

struct Near {
  const KnownThing* thing = nullptr;
  Bearing bearing;
  bool is_sure = false;

  [[nodiscard]] double rank_m() const {
    const bool is_small = thing->size_m().maxCoeff() > 0 && thing->size_m().maxCoeff() < kSmall_m;
    return bearing.distance_m + (is_small ? kSmallIsFarther_m : 0);
  }
};

// The things of this room as somebody meets them, one of a name.
std::vector<Near> nearest_things(const Pose& pose, const std::optional<std::string>& room,
                                 std::span<const KnownThing> things, const Today& today) {
  std::vector<Near> near;
  for (const KnownThing& thing : things) {
    const auto bearing = bearing_of(thing, pose);
    if (!bearing) continue;
    const bool knows_rooms = room && thing.room;
    if (knows_rooms ? *room != *thing.room : bearing->distance_m > kSameRoom_m) continue;
    near.push_back({&thing, *bearing, knows_rooms && thing.is_sure(today) && bearing->is_sure});
  }
  std::ranges::stable_sort(near, {}, &Near::rank_m);
  std::set<std::string> names;
  std::erase_if(near, [&](const Near& each) { return !names.insert(each.thing->name).second; });
  if (near.size() > kMaxThings) near.resize(kMaxThings);
  std::ranges::stable_partition(near, [](const Near& each) { return each.bearing.is_close(); });
  return near;
}

// The names of a room's things, the surest first.
std::vector<std::string> names_in(const std::string& room, std::span<const KnownThing> things,
                                  bool sure, const Today& today) {
  std::vector<const KnownThing*> there;
  for (const KnownThing& thing : things) {
    if (thing.room == room && thing.is_sure(today) == sure) there.push_back(&thing);
  }
  std::ranges::stable_sort(there, std::ranges::greater{}, &KnownThing::probability);
  std::vector<std::string> names;
  for (const KnownThing* thing : there) {
    if (names.size() == kMaxThings) break;
    if (!std::ranges::count(names, thing->name)) names.push_back(thing->name);
  }
  return names;
}

std::string because_of(const Near& near) {
  return fmt::format("the map has it {:.1f} m away (probability {:.2f})", near.bearing.distance_m,
                     near.thing->probability);
}

// Adds the next prompt of the answer.
void add_part(std::vector<Prompt>& answer, const Wording& wording, TimestampNs now_ns,
              double valid_s, const std::string& message, const Values& values, bool sure,
              std::string because) {
  answer.push_back(make_part(wording, "around", answer.size(), message + (sure ? "" : "_probable"),
                             values, sure ? Confidence::kSure : Confidence::kProbable, now_ns,
                             valid_s, std::move(because)));
}

// What a helper noted on a thing that is told.
void add_note(std::vector<Prompt>& answer, const Wording& wording, TimestampNs now_ns,
              double valid_s, const KnownThing& thing) {
  if (thing.note.empty()) return;
  add_part(answer, wording, now_ns, valid_s, "around.note",
           {{"thing", guide::thing(thing.name)}, {"note", as_sentence(thing.note)}}, true,
           "a helper's note");
}

std::vector<Prompt> things_of_room(const std::string& room, std::span<const KnownThing> things,
                                   const Wording& wording, TimestampNs now_ns, const Today& today) {
  std::vector<Prompt> answer;
  for (const bool sure : {true, false}) {
    const auto names = names_in(room, things, sure, today);
    if (names.empty()) continue;
    add_part(answer, wording, now_ns, kRoomValid_s, "around.room", {{"things", thing_list(names)}},
             sure, fmt::format("the map has them in \"{}\"; the position is not known", room));
    for (const KnownThing& one : things) {
      if (one.room == room && std::ranges::count(names, one.name) > 0 &&
          one.is_sure(today) == sure) {
        add_note(answer, wording, now_ns, kRoomValid_s, one);
      }
    }
  }
  return answer;
}

std::vector<Prompt> things_of_place(const Pose& pose, const std::optional<std::string>& room,
                                    std::span<const KnownThing> things, const Wording& wording,
                                    TimestampNs now_ns, const Today& today) {
  const std::vector<Near> near = nearest_things(pose, room, things, today);
  std::vector<Prompt> answer;
  for (const bool sure : {true, false}) {
    std::vector<std::string> names;
    for (const Near& each : near) {
      // The direction of what is close may be unsure, but it is not spoken.
      const bool counts_as_sure = each.is_sure || (room && each.thing->is_sure(today));
      if (each.bearing.is_close() && counts_as_sure == sure) names.push_back(each.thing->name);
    }
    if (names.empty()) continue;
    add_part(answer, wording, now_ns, kDirectionValid_s, "around.close",
             {{"things", thing_list(names)}}, sure, "the map has them here");
    for (const Near& each : near) {
      if (each.bearing.is_close() && std::ranges::count(names, each.thing->name) > 0) {
        add_note(answer, wording, now_ns, kDirectionValid_s, *each.thing);
      }
    }
  }
  for (const Near& each : near) {
    if (each.bearing.is_close()) continue;
    add_part(answer, wording, now_ns, kDirectionValid_s, "around.thing",
             {{"thing", thing(each.thing->name)},
              {"hour", fmt::format("{}", each.bearing.hour)},
              {"distance", wording.distance(each.bearing.distance_m)}},
             each.is_sure, because_of(each));
    add_note(answer, wording, now_ns, kDirectionValid_s, *each.thing);
  }
  return answer;
}

bool lies_on(Side side, const Bearing& bearing) {
  const int first = side == Side::kRight ? 2 : side == Side::kBehind ? 5 : 8;
  return bearing.hour >= first && bearing.hour < first + 3;
}

// Who stands at the end of a long table has it beside them, though its middle is ahead.
bool lies_on(Side side, const KnownThing& thing, const Pose& pose) {
  const auto middle = bearing_of(thing, pose);
  if (!middle) return false;
  const Eigen::Vector2d nearest = outline_of(thing).nearest_to(pose.position_plan);
  return lies_on(side, *middle) ||
         (nearest != pose.position_plan && lies_on(side, bearing_of(nearest, pose)));
}

}  // namespace

std::vector<Prompt> side_prompts(Side side, const UserLocation& location,
                                 std::span<const KnownThing> things, const Wording& wording,
                                 TimestampNs now_ns, const Today& today) {
  const Pose* const pose = location.sure_pose();
  const auto unsure = [&](const char* message, const char* because) {
    return std::vector{make_prompt(wording, "around", message, {}, Confidence::kUnsure,
                                   after(now_ns, kDirectionValid_s), because)};
  };
  if (pose == nullptr) return unsure("around.no_place", "the position is not known");
  std::vector<KnownThing> there;
  for (const KnownThing& thing : things) {
    if (lies_on(side, thing, *pose)) there.push_back(thing);
  }
  auto prompts = things_of_place(*pose, location.room, there, wording, now_ns, today);
  return prompts.empty() ? unsure("beside.nothing", "the map has no thing there") : prompts;
}

std::vector<Prompt> around_prompts(const UserLocation& location, std::span<const KnownThing> things,
                                   const Wording& wording, TimestampNs now_ns,
                                   const std::optional<CalendarTime>& today, bool is_on_map) {
  const Pose* pose = location.sure_pose();
  if (pose == nullptr && !location.room) {
    return {make_prompt(wording, "around", "around.no_place", {}, Confidence::kUnsure,
                        after(now_ns, kRoomValid_s), "neither position nor room is known")};
  }
  auto prompts = pose != nullptr
                     ? things_of_place(*pose, location.room, things, wording, now_ns, today)
                     : things_of_room(*location.room, things, wording, now_ns, today);
  if (!prompts.empty()) return prompts;
  if (!is_on_map) {
    return {make_prompt(wording, "around", "around.no_map", {}, Confidence::kUnsure,
                        after(now_ns, kRoomValid_s), "the room has no place on the map")};
  }
  return {make_prompt(wording, "around", "around.nothing", {}, Confidence::kSure,
                      after(now_ns, kRoomValid_s), "the map has no thing here")};
}

}  // namespace roomwise::guide
